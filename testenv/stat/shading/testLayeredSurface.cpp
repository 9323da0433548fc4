// SPDX-License-Identifier: Apache-2.0
// Layered surfaces, lobe by lobe: what is white stays white in a furnace, nothing gains energy,
// samples follow their densities, and lobes without layers above them are reciprocal. Fresnel terms
// and refraction against closed forms. Tolerances: docs/materials.md.
#include "testenv/stat/chiSquare.h"
#include "testenv/stat/shading/layeredFixture.h"

#include <glm/geometric.hpp>

#include <cmath>

namespace hds::test {
namespace {

struct Case {
    std::string name;
    LayeredParameters parameters;
};

LayeredParameters WhiteDielectric(float roughness) {
    LayeredParameters p;
    return p.Set(HDS_INPUT_DIFFUSE_COLOR, 1.0F).Set(HDS_INPUT_ROUGHNESS, roughness);
}
LayeredParameters Metal(float roughness) {
    LayeredParameters p;
    p.Set(HDS_INPUT_METALLIC, 1.0F).Set(HDS_INPUT_DIELECTRIC, 0.0F);
    return p.Set(HDS_INPUT_ROUGHNESS, roughness);
}
LayeredParameters Glass(float roughness) {
    LayeredParameters p;
    return p.Set(HDS_INPUT_TRANSMISSION, 1.0F).Set(HDS_INPUT_ROUGHNESS, roughness);
}
/// It sends light back.
LayeredParameters Retro(LayeredParameters p) {
    return p.Set(HDS_INPUT_RETRO, 1.0F);
}
LayeredParameters Frosted(float roughness) {
    LayeredParameters p = Glass(roughness);
    p.flags = HDS_MATERIAL_THIN_WALLED | HDS_MATERIAL_FROSTED;
    return p;
}

/// Surfaces that absorb nothing.
std::vector<Case> WhiteCases() {
    std::vector<Case> cases;
    for (const float r : {0.0F, 0.2F, 0.5F, 1.0F}) {
        const std::string suffix = " roughness " + std::to_string(r);
        cases.push_back({"dielectric" + suffix, WhiteDielectric(r)});
        cases.push_back({"metal" + suffix, Metal(r)});
        cases.push_back({"dielectric that sends back" + suffix, Retro(WhiteDielectric(r))});
        cases.push_back({"metal that sends back" + suffix, Retro(Metal(r))});
        cases.push_back(
            {"rough diffuse" + suffix, WhiteDielectric(0.3F).Set(HDS_INPUT_DIFFUSE_ROUGHNESS, r)});
        cases.push_back({"coat" + suffix, WhiteDielectric(0.4F)
                                              .Set(HDS_INPUT_CLEARCOAT, 1.0F)
                                              .Set(HDS_INPUT_CLEARCOAT_ROUGHNESS, r)});
        LayeredParameters sheen =
            WhiteDielectric(0.4F).Set(HDS_INPUT_SHEEN, 1.0F).Set(HDS_INPUT_SHEEN_ROUGHNESS, r);
        cases.push_back({"sheen" + suffix, sheen});
        cases.push_back({"frosted wall" + suffix, Frosted(r)});
        cases.push_back(
            {"half frosted wall" + suffix,
             Frosted(r).Set(HDS_INPUT_DIFFUSE_COLOR, 1.0F).Set(HDS_INPUT_TRANSMISSION, 0.5F)});
        sheen.flags = HDS_MATERIAL_FUZZ;
        cases.push_back({"fuzz" + suffix, sheen});
        LayeredParameters over =
            Metal(0.4F).Set(HDS_INPUT_SHEEN, 0.7F).Set(HDS_INPUT_SHEEN_ROUGHNESS, r);
        over.flags = HDS_MATERIAL_SHEEN_OVER;
        cases.push_back({"sheen over metal" + suffix, over});
    }
    cases.push_back({"stretched metal", Metal(0.4F).Set(HDS_INPUT_STRETCH, 1.6F, 0.6F, 0.0F)});
    cases.push_back({"translucent", WhiteDielectric(0.3F)
                                        .Set(HDS_INPUT_DIFFUSE_COLOR, 0.4F)
                                        .Set(HDS_INPUT_TRANSLUCENCY, 0.6F)});
    cases.push_back({"high index", WhiteDielectric(0.3F).Set(HDS_INPUT_IOR, 2.5F)});
    cases.push_back({"index 1", WhiteDielectric(0.3F).Set(HDS_INPUT_IOR, 1.0F)});
    cases.push_back({"schlick", WhiteDielectric(0.3F)
                                    .Set(HDS_INPUT_SCHLICK_EXPONENT, 2.0F)
                                    .Set(HDS_INPUT_SCHLICK_COLOR, 0.3F)
                                    .Set(HDS_INPUT_SCHLICK_GRAZING, 0.9F)});
    cases.push_back({"film", WhiteDielectric(0.3F).Set(HDS_INPUT_FILM, 1.0F, 400.0F, 1.8F)});
    cases.push_back({"film on metal", Metal(0.3F).Set(HDS_INPUT_FILM, 1.0F, 400.0F, 1.4F)});
    cases.push_back({"mixed", WhiteDielectric(0.3F)
                                  .Set(HDS_INPUT_METALLIC, 0.4F)
                                  .Set(HDS_INPUT_DIELECTRIC, 0.6F)
                                  .Set(HDS_INPUT_CLEARCOAT, 0.5F)
                                  .Set(HDS_INPUT_SHEEN, 0.5F)});
    return cases;
}

class LayeredTest : public LayeredFixture {
protected:
    glm::dvec3 Albedo(const LayeredParameters& parameters, double cosine, int side = 180) {
        std::vector<float> us;
        for (int i = 0; i < side; ++i) {
            for (int j = 0; j < side; ++j) {
                us.push_back((float(i) + 0.5F) / float(side));
                us.push_back((float(j) + 0.5F) / float(side));
            }
        }
        glm::dvec3 sum(0.0);
        for (const LayeredSample& sample : Sample(parameters, Towards(cosine), us)) {
            sum += sample.weight;
        }
        return sum / double(us.size() / 2);
    }

    void CheckChiSquare(const std::string& name, const LayeredParameters& parameters, double cosine,
                        unsigned seed, int subdivisions = kChiSquareSubdivisions) {
        constexpr std::size_t kCount = 1000000;
        const glm::dvec3 wo = Towards(cosine);
        std::vector<Square> squares;
        for (const LayeredSample& sample : Sample(parameters, wo, RandomSquares(kCount, seed))) {
            if (sample.pdf > 0.0) {
                squares.push_back(SphereDomain::ToSquare(&sample.wi.x));
            }
        }
        std::vector<std::array<glm::dvec3, 2>> pairs;
        const std::vector<Square> points = DensityPoints(subdivisions);
        for (const Square& point : points) {
            float d[3];
            SphereDomain::FromSquare(point, d);
            pairs.push_back({wo, {d[0], d[1], d[2]}});
        }
        const auto values = Evaluate(parameters, pairs);
        std::vector<double> densities;
        for (std::size_t i = 0; i < points.size(); ++i) {
            densities.push_back(values[i][3] * SphereDomain::Jacobian(points[i]));
        }
        ExpectChiSquare(name, squares, kCount, densities);
    }
};

TEST_F(LayeredTest, WhiteSurfacesVanishInAFurnace) {
    for (const Case& c : WhiteCases()) {
        for (const double cosine : {0.1, 0.3, 0.7, 1.0}) {
            // Smooth fuzz is at grazing angles, where samples of a cosine lobe are few.
            const bool isGrazing = c.name.compare(0, 18, "fuzz roughness 0.2") == 0;
            const glm::dvec3 albedo = Albedo(c.parameters, cosine, isGrazing ? 1000 : 180);
            // Tables are of isotropic lobes, and linear between their nodes.
            const double tolerance = c.name == "stretched metal" ? 0.05 : 0.03;
            EXPECT_NEAR(albedo.x, 1.0, tolerance) << c.name << " cosine " << cosine;
        }
    }
}

TEST_F(LayeredTest, GlassVanishesInAFurnaceFromBothSides) {
    for (const bool isBack : {false, true}) {
        for (const float roughness : {0.0F, 0.2F, 0.5F, 1.0F}) {
            for (const float ior : {1.2F, 1.5F, 2.0F}) {
                LayeredParameters glass = Glass(roughness).Set(HDS_INPUT_IOR, ior);
                glass.isBack = isBack;
                for (const double cosine : {0.1, 0.5, 0.9}) {
                    const double albedo = Albedo(glass, cosine).x;
                    const double loss = roughness == 0.0F ? 0.01 : 0.02;
                    EXPECT_LE(albedo, 1.01)
                        << roughness << " " << ior << " " << cosine << " " << isBack;
                    EXPECT_GE(albedo, 1.0 - loss)
                        << roughness << " " << ior << " " << cosine << " " << isBack;
                }
            }
        }
    }
}

/// Glass and a surface that does not transmit, each with its own compensation.
TEST_F(LayeredTest, HalfGlassVanishesInAFurnace) {
    for (const float roughness : {0.2F, 0.6F, 1.0F}) {
        const LayeredParameters half = WhiteDielectric(roughness).Set(HDS_INPUT_TRANSMISSION, 0.5F);
        for (const double cosine : {0.1, 0.5, 0.9}) {
            EXPECT_NEAR(Albedo(half, cosine).x, 1.0, 0.02) << roughness << " " << cosine;
        }
    }
}

TEST_F(LayeredTest, SamplesHaveTheBitsOfEvaluations) {
    for (const Case& c : WhiteCases()) {
        for (const LayeredSample& sample :
             Sample(c.parameters, Towards(0.5), RandomSquares(200, 7))) {
            if (sample.pdf > 0.0) {
                EXPECT_EQ(sample.pdf, sample.evaluatedPdf) << c.name;
                EXPECT_NEAR(sample.weight.x * sample.pdf, sample.value.x,
                            1e-6 * sample.value.x + 1e-30)
                    << c.name;
            }
        }
    }
}

TEST_F(LayeredTest, SamplesFollowTheirDensity) {
    unsigned seed = 900;
    for (const double cosine : {0.3, 0.9}) {
        CheckChiSquare("stretched metal", Metal(0.6F).Set(HDS_INPUT_STRETCH, 1.4F, 0.6F, 0.0F),
                       cosine, seed++);
        CheckChiSquare("stretched metal that sends back below a coat",
                       Retro(Metal(0.6F))
                           .Set(HDS_INPUT_STRETCH, 1.4F, 0.6F, 0.0F)
                           .Set(HDS_INPUT_CLEARCOAT, 1.0F)
                           .Set(HDS_INPUT_CLEARCOAT_ROUGHNESS, 0.3F),
                       cosine, seed + 1000);
        CheckChiSquare("glass that sends back", Retro(Glass(0.6F)), cosine, seed + 1001,
                       kChiSquareFineSubdivisions);
        CheckChiSquare("coat",
                       WhiteDielectric(0.7F)
                           .Set(HDS_INPUT_CLEARCOAT, 1.0F)
                           .Set(HDS_INPUT_CLEARCOAT_ROUGHNESS, 0.5F),
                       cosine, seed++);
        CheckChiSquare("coat of its own frame",
                       WhiteDielectric(0.7F)
                           .Set(HDS_INPUT_CLEARCOAT, 1.0F)
                           .Set(HDS_INPUT_CLEARCOAT_ROUGHNESS, 0.5F)
                           .Set(HDS_INPUT_COAT_STRETCH, 1.4F, 0.6F, 0.0F)
                           .Set(HDS_INPUT_COAT_NORMAL, 0.48F, -0.36F, 0.8F)
                           .Set(HDS_INPUT_TRANSLUCENCY, 0.7F),
                       cosine, seed++);
        CheckChiSquare("sheen", WhiteDielectric(0.6F).Set(HDS_INPUT_SHEEN, 1.0F), cosine, seed++);
        CheckChiSquare("translucent", WhiteDielectric(0.6F).Set(HDS_INPUT_TRANSLUCENCY, 0.7F),
                       cosine, seed++);
        CheckChiSquare("frosted wall", Frosted(0.6F).Set(HDS_INPUT_TRANSLUCENCY, 0.3F), cosine,
                       seed++);
        LayeredParameters glass = Glass(0.6F);
        CheckChiSquare("glass", glass, cosine, seed++, kChiSquareFineSubdivisions);
        glass.isBack = true;
        CheckChiSquare("glass from inside", glass, cosine, seed++, kChiSquareFineSubdivisions);
    }
}

/// Lobes that nothing lies above, and whose scale does not depend on the viewer.
TEST_F(LayeredTest, LobesAloneAreReciprocal) {
    LayeredParameters reflection = Metal(0.5F).Set(HDS_INPUT_STRETCH, 1.4F, 0.6F, 0.0F);
    reflection.Set(HDS_INPUT_METAL_COLOR, 0.0F); // what bounces more often is black then
    LayeredParameters diffuse = WhiteDielectric(0.3F).Set(HDS_INPUT_DIFFUSE_ROUGHNESS, 0.8F);
    diffuse.Set(HDS_INPUT_SPECULAR_WEIGHT, 0.0F);
    std::vector<std::array<glm::dvec3, 2>> pairs;
    std::vector<std::array<glm::dvec3, 2>> swapped;
    for (const double cosine : {0.15, 0.4, 0.8}) {
        for (const double phi : {0.3, 2.0, 4.0}) {
            pairs.push_back({Towards(cosine, phi), Towards(0.6, 1.0)});
            swapped.push_back({pairs.back()[1], pairs.back()[0]});
        }
    }
    for (const LayeredParameters& p : {reflection, diffuse}) {
        const auto forth = Evaluate(p, pairs);
        const auto back = Evaluate(p, swapped);
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const double f = forth[i][0] / pairs[i][1].z;
            EXPECT_NEAR(f, back[i][0] / pairs[i][0].z, 1e-5 * f) << i;
            EXPECT_GT(f, 0.0);
        }
    }
}

/// Of white metal, whose factor depends on the viewer: it is that of the lobe that does not send
/// light back, and so is what the two directions differ by.
TEST_F(LayeredTest, LobesThatSendLightBackAreReciprocal) {
    const LayeredParameters metal = Metal(0.5F).Set(HDS_INPUT_STRETCH, 1.4F, 0.6F, 0.0F);
    for (const double cosine : {0.15, 0.4, 0.8}) {
        for (const double phi : {0.3, 2.0, 4.0}) {
            const glm::dvec3 a = Towards(cosine, phi);
            const glm::dvec3 b = Towards(0.6, 1.0);
            const auto asymmetry = [&](const LayeredParameters& p) {
                const auto values = Evaluate(p, {{a, b}, {b, a}});
                EXPECT_GT(values[1][0], 0.0);
                return values[0][0] / b.z / (values[1][0] / a.z);
            };
            EXPECT_NEAR(asymmetry(Retro(metal)), asymmetry(metal), 1e-5) << cosine << " " << phi;
        }
    }
}

/// Fresnel's equations and Snell's law at a surface as smooth as there is.
TEST_F(LayeredTest, SmoothGlassFollowsFresnelAndSnell) {
    for (const double eta : {1.5, 1.0 / 1.5}) {
        LayeredParameters glass = Glass(0.0F);
        glass.isBack = eta < 1.0;
        for (const double cosine : {0.8, 0.9, 1.0}) {
            const double sine = std::sqrt(1.0 - cosine * cosine) / eta;
            const double inner = std::sqrt(1.0 - sine * sine);
            const double s = (cosine - eta * inner) / (cosine + eta * inner);
            const double p = (eta * cosine - inner) / (eta * cosine + inner);
            const double fresnel = 0.5 * (s * s + p * p);
            double reflected = 0.0;
            int numRefracted = 0;
            int numOff = 0; // in the tails of the distribution, alpha 1e-4
            const std::vector<float> us = RandomSquares(4000, 3);
            const auto samples = Sample(glass, Towards(cosine), us);
            for (const LayeredSample& sample : samples) {
                if (sample.wi.z > 0.0) {
                    reflected += sample.weight.x / double(samples.size());
                } else if (sample.pdf > 0.0) {
                    ++numRefracted;
                    numOff += std::abs(-sample.wi.z - inner) > 2e-3 ||
                                      std::abs(-sample.wi.x - sine) > 2e-3
                                  ? 1
                                  : 0;
                }
            }
            EXPECT_NEAR(reflected, fresnel, 0.02) << eta << " " << cosine;
            EXPECT_GT(numRefracted, 1000);
            EXPECT_LT(numOff, numRefracted / 50) << eta << " " << cosine;
        }
    }
}

/// F82: the tint is the factor of Schlick's term at cosine 1 / 7; white stays Schlick's.
TEST_F(LayeredTest, MetalsHaveTheirColorAndTheirEdge) {
    const auto lobe = [&](const LayeredParameters& p, double cosine) {
        const auto values = Evaluate(p, {{Towards(cosine), Towards(cosine, std::acos(-1.0))}});
        return glm::dvec3(values[0][0], values[0][1], values[0][2]);
    };
    for (const double cosine : {1.0, 1.0 / 7.0}) {
        const LayeredParameters mirror = Metal(0.05F);
        LayeredParameters metal = mirror;
        metal.Set(HDS_INPUT_METAL_COLOR, 0.9F, 0.5F, 0.1F)
            .Set(HDS_INPUT_EDGE_COLOR, 0.8F, 0.6F, 1.0F);
        const glm::dvec3 ratio = lobe(metal, cosine) / lobe(mirror, cosine);
        const double weight = std::pow(1.0 - cosine, 5.0);
        const glm::dvec3 schlick = glm::dvec3(0.9, 0.5, 0.1) + glm::dvec3(0.1, 0.5, 0.9) * weight;
        const glm::dvec3 tint = cosine == 1.0 ? glm::dvec3(1.0) : glm::dvec3(0.8, 0.6, 1.0);
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(ratio[k], schlick[k] * tint[k], 5e-3) << cosine << " " << k;
        }
    }
}

} // namespace
} // namespace hds::test
