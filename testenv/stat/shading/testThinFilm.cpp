// SPDX-License-Identifier: Apache-2.0
// Thin films (kernels/shading/thinFilm.clh) against Airy's closed form, integrated over the
// spectrum here, and layered surfaces that have them. Tolerances: docs/materials.md.
#include "testenv/stat/shading/layeredFixture.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include <cmath>
#include <complex>

namespace hds::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// XYZ of the CIE's standard observer (Wyman, Sloan and Shirley 2013, JCGT 2(2), listing 1).
glm::dvec3 Observer(double wavelength) {
    const auto lobe = [&](double peak, double below, double above) {
        const double t = (wavelength - peak) / (wavelength < peak ? below : above);
        return std::exp(-0.5 * t * t);
    };
    return {1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) -
                0.065 * lobe(501.1, 20.4, 26.2),
            0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
            1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8)};
}

/// Of linear Rec. 709 to one wavelength, not normalised.
glm::dvec3 Response(double wavelength) {
    const glm::dmat3 rows(3.2404542, -1.5371385, -0.4985314, -0.9692660, 1.8760108, 0.0415560,
                          0.0556434, -0.2040259, 1.0572252);
    return glm::transpose(rows) * Observer(wavelength);
}

struct Film {
    double eta;       ///< below
    double index;     ///< of the film
    double thickness; ///< nanometres
};

/// Airy's reflectance for one wavelength, by complex amplitudes and the characteristic angles.
double Airy(const Film& film, double cosine, double wavelength) {
    const double sine2 = 1.0 - cosine * cosine;
    const double within = std::sqrt(1.0 - sine2 / (film.index * film.index));
    const double below = std::sqrt(1.0 - sine2 / (film.eta * film.eta));
    const double phase = 4.0 * kPi * film.index * film.thickness * within / wavelength;
    const std::complex<double> turn = std::polar(1.0, phase);
    const auto reflectance = [&](double outer, double inner) {
        return std::norm((outer + inner * turn) / (1.0 + outer * inner * turn));
    };
    const double s = reflectance((cosine - film.index * within) / (cosine + film.index * within),
                                 (film.index * within - film.eta * below) /
                                     (film.index * within + film.eta * below));
    const double p = reflectance((film.index * cosine - within) / (film.index * cosine + within),
                                 (film.eta * within - film.index * below) /
                                     (film.eta * within + film.index * below));
    return 0.5 * (s + p);
}

/// Averages over the spectrum as red, green and blue see it.
glm::dvec3 Expected(const Film& film, double cosine) {
    glm::dvec3 sum(0.0);
    glm::dvec3 norm(0.0);
    for (double wavelength = 340.0; wavelength < 860.0; wavelength += 0.5) {
        const glm::dvec3 response = Response(wavelength);
        sum += response * Airy(film, cosine, wavelength);
        norm += response;
    }
    return glm::clamp(sum / norm, 0.0, 1.0);
}

class ThinFilmTest : public LayeredFixture {};

TEST_F(ThinFilmTest, ReflectanceIsAirysIntegratedOverTheSpectrum) {
    const std::unique_ptr<Program> program = Build(R"(
#include "shading/thinFilm.clh"
kernel void reflect(global const float4* in, global float4* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    out[i] = (float4)(film_reflectance(in[i].x, (float3)(in[i].y), in[i].z, in[i].w), 0.0f);
}
)");
    std::vector<float> in;
    std::vector<glm::dvec3> expected;
    for (const double eta : {1.0, 1.5, 4.0, 40.0}) {
        for (const double index : {1.0, 1.33, 1.5, 2.4}) {
            for (const double thickness : {0.0, 100.0, 300.0, 550.0, 1200.0, 5000.0}) {
                for (const double cosine : {0.1, 0.3, 0.7, 1.0}) {
                    in.insert(in.end(),
                              {float(cosine), float(eta), float(index), float(thickness)});
                    expected.push_back(Expected({eta, index, thickness}, cosine));
                }
            }
        }
    }
    const std::size_t count = expected.size();
    const Buffer inBuffer = Upload(in);
    const Buffer outBuffer = Allocate(count * 4 * sizeof(float));
    program->GetKernel("reflect").Launch(count, inBuffer, outBuffer, std::uint32_t(count));
    const std::vector<float> out = Download<float>(outBuffer, count * 4);
    for (std::size_t i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(out[4 * i + k], expected[i][k], 0.003)
                << "cosine " << in[4 * i] << " eta " << in[4 * i + 1] << " index " << in[4 * i + 2]
                << " thickness " << in[4 * i + 3] << " channel " << k;
        }
    }
}

/// The surface's lobe has the film's reflectance in place of Fresnel's, from both sides.
TEST_F(ThinFilmTest, LobesHaveTheFilmsColor) {
    const Film film{1.5, 1.8, 350.0};
    for (const double cosine : {0.4, 0.8, 1.0}) {
        for (const bool isBack : {false, true}) {
            LayeredParameters bare;
            bare.Set(HDS_INPUT_ROUGHNESS, 0.05F).Set(HDS_INPUT_TRANSMISSION, 1.0F);
            bare.isBack = isBack;
            LayeredParameters covered = bare;
            covered.Set(HDS_INPUT_FILM, 1.0F, float(film.thickness), float(film.index));
            const double sine2 = (1.0 - cosine * cosine) * (isBack ? film.eta * film.eta : 1.0);
            if (sine2 >= 1.0) {
                continue; // total reflection
            }
            const double outside = std::sqrt(1.0 - sine2);
            const glm::dvec3 expected = Expected(film, outside);
            const glm::dvec3 plain = Expected({film.eta, 1.0, 0.0}, outside);
            const auto value = [&](const LayeredParameters& p) {
                const auto v = Evaluate(p, {{Towards(cosine), Towards(cosine, kPi)}})[0];
                return glm::dvec3(v[0], v[1], v[2]);
            };
            const glm::dvec3 ratio = value(covered) / value(bare);
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(ratio[k] * plain[k], expected[k], 1e-3)
                    << cosine << " " << isBack << " " << k;
            }
        }
    }
}

/// Of a metal's film: Airy's with the real index whose reflectance at normal incidence is its
/// colour, times what the tint of the edge leaves.
TEST_F(ThinFilmTest, MetalsHaveTheFilmsColor) {
    const double colors[] = {0.9, 0.5, 0.1};
    LayeredParameters metal;
    metal.Set(HDS_INPUT_METALLIC, 1.0F).Set(HDS_INPUT_DIELECTRIC, 0.0F);
    metal.Set(HDS_INPUT_ROUGHNESS, 0.05F).Set(HDS_INPUT_METAL_COLOR, 0.9F, 0.5F, 0.1F);
    LayeredParameters dielectric; // of the same Schlick's term
    dielectric.Set(HDS_INPUT_ROUGHNESS, 0.05F).Set(HDS_INPUT_SCHLICK_EXPONENT, 5.0F);
    dielectric.Set(HDS_INPUT_SCHLICK_COLOR, 0.9F, 0.5F, 0.1F);
    for (const LayeredParameters& plain : {metal, dielectric}) {
        LayeredParameters covered = plain;
        covered.Set(HDS_INPUT_FILM, 1.0F, 300.0F, 1.5F);
        for (const double cosine : {0.3, 0.7, 1.0}) {
            const auto pair = std::array<glm::dvec3, 2>{Towards(cosine), Towards(cosine, kPi)};
            const auto bare = Evaluate(plain, {pair})[0];
            const auto film = Evaluate(covered, {pair})[0];
            for (int k = 0; k < 3; ++k) {
                const double root = std::sqrt(colors[k]);
                const Film expected{(1.0 + root) / (1.0 - root), 1.5, 300.0};
                const double schlick = colors[k] + (1.0 - colors[k]) * std::pow(1.0 - cosine, 5.0);
                EXPECT_NEAR(film[k] / bare[k] * schlick, Expected(expected, cosine)[k], 1e-3)
                    << cosine << " " << k;
            }
        }
    }
}

} // namespace
} // namespace hds::test
