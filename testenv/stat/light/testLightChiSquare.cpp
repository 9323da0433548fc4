// SPDX-License-Identifier: Apache-2.0
// light_sample follows the density that light_pdf states, for each type of light: chi-square tests.
// Each light has a domain of its own on which its density has no edges: points of its surface, or
// directions of its cone.
#include "hdStream/shading/domeGuide.h"
#include "testenv/device/light/lightFixture.h"
#include "testenv/stat/chiSquare.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace hds::test {
namespace {

constexpr std::size_t kNumSamples = 400000;
constexpr double kPi = 3.14159265358979323846;

/// How the light's directions cover the unit square, in double precision.
struct LightDomain {
    /// From a direction (unit) and the lit point's hit.
    std::function<Square(const glm::dvec3& direction, const glm::dvec3& hit)> toSquare;
    std::function<glm::dvec3(const Square&)> fromSquare;     ///< a direction, any length
    std::function<double(const Square&)> solidAngleOfSquare; ///< per unit of the square
};

/// A surface p(s) with outward area normal: the domain of area lights.
LightDomain SurfaceDomain(const glm::dvec3& point,
                          const std::function<glm::dvec3(const Square&)>& surface,
                          const std::function<glm::dvec3(const Square&)>& areaNormal,
                          const std::function<Square(const glm::dvec3&)>& inverse) {
    LightDomain domain;
    domain.toSquare = [inverse](const glm::dvec3&, const glm::dvec3& hit) { return inverse(hit); };
    domain.fromSquare = [=](const Square& s) { return surface(s) - point; };
    domain.solidAngleOfSquare = [=](const Square& s) {
        const glm::dvec3 v = surface(s) - point;
        const double length = glm::length(v);
        return std::max(0.0, -glm::dot(v, areaNormal(s))) / (length * length * length);
    };
    return domain;
}

/// A cone of directions about an axis, in a space M away from the world's.
LightDomain ConeDomain(const glm::dmat3& m, const glm::dvec3& axis, double oneMinusCos) {
    const glm::dvec3 z = glm::normalize(axis);
    const glm::dvec3 x = glm::normalize(
        glm::cross(std::abs(z.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0), z));
    const glm::dmat3 frame(x, glm::cross(z, x), z);
    const glm::dmat3 inverse = glm::inverse(m);
    const auto local = [=](const Square& s) {
        const double k = s[0] * oneMinusCos;
        const double r = std::sqrt(k * (2.0 - k));
        const double phi = 2.0 * kPi * s[1];
        return frame * glm::dvec3(r * std::cos(phi), r * std::sin(phi), 1.0 - k);
    };
    LightDomain domain;
    domain.fromSquare = [=](const Square& s) { return m * local(s); };
    domain.solidAngleOfSquare = [=](const Square& s) {
        const double stretch = glm::length(m * local(s));
        return 2.0 * kPi * oneMinusCos * std::abs(glm::determinant(m)) /
               (stretch * stretch * stretch);
    };
    domain.toSquare = [=](const glm::dvec3& direction, const glm::dvec3&) {
        const glm::dvec3 d = glm::transpose(frame) * glm::normalize(inverse * direction);
        const glm::dvec2 side(d.x, d.y);
        const double squared = glm::dot(side, side);
        const double k = squared / (1.0 + std::abs(d.z)); // 1 - |cos|
        const double share = (d.z >= 0.0 ? k : 2.0 - k) / oneMinusCos;
        // Float directions may lie outside by a rounding.
        return Square{std::min(share, 1.0 - 1e-9 + std::max(0.0, share - 1.0 - 1e-3)),
                      DiskDomain::ToSquare(d.x, d.y)[1]};
    };
    return domain;
}

class LightChiSquareTest : public LightFixture {
protected:
    void Check(const std::string& name, const glm::dvec3& point, const glm::dvec3& normal,
               const LightDomain& domain, unsigned seed) {
        std::vector<float> points;
        std::vector<float> normals;
        for (std::size_t i = 0; i < kNumSamples; ++i) {
            Append(points, point);
            Append(normals, normal);
        }
        const std::vector<LightSampleResult> results =
            Sample(points, normals, RandomSquares(kNumSamples * 2, seed));
        std::vector<Square> samples;
        for (const LightSampleResult& r : results) {
            if (r.isValid) {
                samples.push_back(domain.toSquare(r.direction, point + r.distance * r.direction));
            }
        }
        ExpectChiSquare(name, samples, kNumSamples, Densities(point, normal, domain));
    }

private:
    std::vector<double> Densities(const glm::dvec3& point, const glm::dvec3& normal,
                                  const LightDomain& domain) {
        const std::vector<Square> squares = DensityPoints();
        std::vector<float> directions;
        for (const Square& s : squares) {
            Append(directions, glm::normalize(domain.fromSquare(s)));
        }
        std::vector<float> at;
        std::vector<float> facing;
        Append(at, point);
        Append(facing, normal);
        const std::vector<float> hits = Intersect(0, at, facing, directions);
        std::vector<double> densities;
        for (std::size_t i = 0; i < squares.size(); ++i) {
            densities.push_back(hits[3 * i + 1] * domain.solidAngleOfSquare(squares[i]));
        }
        return densities;
    }
};

glm::dmat4 Rotation() {
    return glm::rotate(glm::translate(glm::dmat4(1.0), {1.0, -2.0, 0.5}), 0.7, {0.3, 1.0, 0.5});
}

TEST_F(LightChiSquareTest, Sphere) {
    PlacedLight light = MakeLight(LightType::Sphere);
    light.light.radius = 1.0F;
    for (const bool isEllipsoid : {false, true}) {
        light.worldFromLight =
            glm::scale(Rotation(), isEllipsoid ? glm::dvec3(2.0, 0.6, 1.0) : glm::dvec3(1.5));
        SetLights({light});
        const glm::dmat3 m(light.worldFromLight);
        for (const double distance : {1.2, 5.0, 300.0}) {
            const glm::dvec3 q = distance * glm::normalize(glm::dvec3(0.5, -0.6, 0.4));
            const glm::dvec3 point(light.worldFromLight * glm::dvec4(q, 1.0));
            const double oneMinusCos = 1.0 - std::sqrt(1.0 - 1.0 / (distance * distance));
            Check("sphere", point, glm::dvec3(0.0), ConeDomain(m, -q, oneMinusCos),
                  300 + unsigned(distance) + (isEllipsoid ? 1000U : 0U));
        }
    }
}

/// Solid angle of a rect about the middle of the xy plane, from q. Source: the formula for a
/// rectangle with a corner below the eye, atan(x y / (z sqrt(x^2 + y^2 + z^2))), four times.
double RectSolidAngle(double width, double height, const glm::dvec3& q) {
    double sum = 0.0;
    for (const int i : {-1, 1}) {
        for (const int j : {-1, 1}) {
            const double x = i * 0.5 * width - q.x;
            const double y = j * 0.5 * height - q.y;
            sum += i * j * std::atan2(x * y, std::abs(q.z) * std::sqrt(x * x + y * y + q.z * q.z));
        }
    }
    return sum;
}

/// Strips of light that subtend little: by their density, and each sample brings nearly the same.
/// A rect about the middle of m's xy plane, as seen from a point.
LightDomain RectDomain(const glm::dmat4& m, double width, double height, const glm::dvec3& point) {
    const glm::dmat4 inverse = glm::inverse(m);
    return SurfaceDomain(
        point,
        [=](const Square& s) {
            return glm::dvec3(m *
                              glm::dvec4(width * (s[0] - 0.5), height * (s[1] - 0.5), 0.0, 1.0));
        },
        [=](const Square&) { return -width * height * glm::dvec3(m[2]); },
        [=](const glm::dvec3& hit) {
            const glm::dvec4 p = inverse * glm::dvec4(hit, 1.0);
            // Float positions may lie outside by a rounding, which is more of the short side.
            const auto inside = [](double v) {
                return v > -0.01 && v < 1.01 ? std::clamp(v, 0.0, 1.0 - 1e-9) : v;
            };
            return Square{inside(p.x / width + 0.5), inside(p.y / height + 0.5)};
        });
}

/// Sampled along a side, too, where the solid angle is not even.
TEST_F(LightChiSquareTest, SquareRectsAtAGrazingAngle) {
    const glm::dmat4 m = Rotation();
    const glm::dvec3 q(1.5, 0.0, -0.01);
    ASSERT_LT(RectSolidAngle(1.0, 1.0, q), 0.01); // HDS_SPHERICAL_RECT_MIN
    PlacedLight rect = MakeLight(LightType::Rect);
    rect.light.width = 1.0F;
    rect.light.height = 1.0F;
    rect.worldFromLight = m;
    SetLights({rect});
    const glm::dvec3 point(m * glm::dvec4(q, 1.0));
    Check("square", point, glm::dvec3(0.0), RectDomain(m, 1.0, 1.0, point), 480);
}

TEST_F(LightChiSquareTest, LongThinRects) {
    unsigned seed = 450;
    const glm::dmat4 m = Rotation();
    for (const bool isUpright : {false, true}) {
        for (const glm::dvec3& along : {glm::dvec3(0.0, 0.3, -1.5), glm::dvec3(5.0, 0.1, -1.0),
                                        glm::dvec3(-9.0, 0.5, -0.3), glm::dvec3(7.0, -2.0, -3.0)}) {
            const double width = isUpright ? 0.004 : 12.0;
            const double height = isUpright ? 12.0 : 0.004;
            const glm::dvec3 q = isUpright ? glm::dvec3(along.y, along.x, along.z) : along;
            const glm::dvec3 point(m * glm::dvec4(q, 1.0));
            PlacedLight rect = MakeLight(LightType::Rect);
            rect.light.width = float(width);
            rect.light.height = float(height);
            rect.worldFromLight = m;
            SetLights({rect});
            Check("strip", point, glm::dvec3(0.0), RectDomain(m, width, height, point), seed++);
            std::vector<float> points;
            std::vector<float> normals;
            for (int i = 0; i < 1000; ++i) {
                Append(points, point);
                Append(normals, glm::dvec3(0.0));
            }
            const double solidAngle = RectSolidAngle(width, height, q);
            ASSERT_LT(solidAngle, 0.01); // HDS_SPHERICAL_RECT_MIN
            for (const LightSampleResult& r :
                 Sample(points, normals, RandomSquares(2000, seed++))) {
                ASSERT_TRUE(r.isValid);
                ASSERT_NEAR(1.0 / r.pdf, solidAngle, 0.02 * solidAngle);
            }
        }
    }
}

TEST_F(LightChiSquareTest, RectAndDisk) {
    unsigned seed = 400;
    for (const bool isSheared : {false, true}) {
        glm::dmat4 m = glm::scale(Rotation(), {1.3, 0.8, 1.0});
        if (isSheared) {
            m[1] += 0.5 * m[0];
        }
        const glm::dmat4 inverse = glm::inverse(m);
        const glm::dvec3 cross = glm::cross(glm::dvec3(m[0]), glm::dvec3(m[1]));
        for (const glm::dvec3& q : {glm::dvec3(0.2, 0.1, -0.4), glm::dvec3(3.0, 1.0, -0.7),
                                    glm::dvec3(1.0, -2.0, -20.0)}) {
            const glm::dvec3 point(m * glm::dvec4(q, 1.0));
            PlacedLight rect = MakeLight(LightType::Rect);
            rect.light.width = 2.0F;
            rect.light.height = 1.0F;
            rect.worldFromLight = m;
            const auto onRect = [=](const Square& s) {
                return glm::dvec3(m * glm::dvec4(2.0 * s[0] - 1.0, s[1] - 0.5, 0.0, 1.0));
            };
            const LightDomain domain = SurfaceDomain(
                point, onRect, [=](const Square&) { return -2.0 * cross; },
                [=](const glm::dvec3& hit) {
                    const glm::dvec4 p = inverse * glm::dvec4(hit, 1.0);
                    return Square{0.5 * p.x + 0.5, p.y + 0.5};
                });
            SetLights({rect});
            Check("rect", point, glm::dvec3(0.0), domain, seed++);
            rect.light.textureFile.authoredPath = "panel.exr";
            SetLights({rect},
                      {4,
                       2,
                       {1, 1, 1, 9, 9, 9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 3, 3},
                       0});
            Check("rect with an image", point, glm::dvec3(0.0), domain, seed++);
            PlacedLight dome = MakeLight(LightType::Dome);
            dome.portals.push_back({m, 2.0F, 1.0F});
            SetLights({dome});
            LightDomain throughPortal = domain; // the light beyond it is at infinity
            throughPortal.toSquare = [=](const glm::dvec3& direction, const glm::dvec3&) {
                const glm::dvec3 d = glm::dmat3(inverse) * direction;
                const glm::dvec3 p = q - d * (q.z / d.z);
                return Square{0.5 * p.x + 0.5, p.y + 0.5};
            };
            Check("portal", point, glm::dvec3(0.0), throughPortal, seed++);
            PlacedLight disk = MakeLight(LightType::Disk);
            disk.light.radius = 1.0F;
            disk.worldFromLight = m;
            SetLights({disk});
            const auto onDisk = [=](const Square& s) {
                const double r = std::sqrt(s[0]);
                const double phi = 2.0 * kPi * s[1];
                return glm::dvec3(m * glm::dvec4(r * std::cos(phi), r * std::sin(phi), 0.0, 1.0));
            };
            Check("disk", point, glm::dvec3(0.0),
                  SurfaceDomain(
                      point, onDisk, [=](const Square&) { return -kPi * cross; },
                      [=](const glm::dvec3& hit) {
                          const glm::dvec4 p = inverse * glm::dvec4(hit, 1.0);
                          return DiskDomain::ToSquare(p.x, p.y);
                      }),
                  seed++);
        }
    }
}

TEST_F(LightChiSquareTest, Cylinder) {
    unsigned seed = 500;
    const double radius = 0.5;
    PlacedLight light = MakeLight(LightType::Cylinder);
    light.light.radius = float(radius);
    light.light.length = 2.0F;
    for (const double stretch : {1.0, 2.0}) {
        const glm::dmat4 m = glm::scale(Rotation(), {1.0, stretch, 1.0});
        const glm::dmat4 inverse = glm::inverse(m);
        light.worldFromLight = m;
        SetLights({light});
        for (const glm::dvec3& q : {glm::dvec3(0.2, 0.5, -0.7), glm::dvec3(1.6, 0.1, -0.9),
                                    glm::dvec3(10.0, -40.0, 20.0)}) {
            const glm::dvec3 point(m * glm::dvec4(q, 1.0));
            // The visible arc alone, so that no bin is cut by its end.
            const double toward = std::atan2(q.z, q.y);
            const double halfArc = std::acos(radius / std::hypot(q.y, q.z));
            const auto normalAt = [=](const Square& s) {
                const double phi = toward + (2.0 * s[0] - 1.0) * halfArc;
                return glm::dvec3(0.0, std::cos(phi), std::sin(phi));
            };
            const auto onSurface = [=](const Square& s) {
                return glm::dvec3(
                    m *
                    glm::dvec4(glm::dvec3(2.0 * s[1] - 1.0, 0.0, 0.0) + radius * normalAt(s), 1.0));
            };
            const auto areaNormal = [=](const Square& s) {
                const glm::dmat3 linear(m);
                return glm::transpose(glm::inverse(linear)) * normalAt(s) *
                       (glm::determinant(linear) * 2.0 * halfArc * radius * 2.0);
            };
            Check("cylinder", point, glm::dvec3(0.0),
                  SurfaceDomain(point, onSurface, areaNormal,
                                [=](const glm::dvec3& hit) {
                                    const glm::dvec4 p = inverse * glm::dvec4(hit, 1.0);
                                    const double turns =
                                        (std::atan2(p.z, p.y) - toward) / (2.0 * kPi);
                                    const double phi =
                                        2.0 * kPi * (turns - std::floor(turns + 0.5));
                                    return Square{0.5 + 0.5 * phi / halfArc, 0.5 * p.x + 0.5};
                                }),
                  seed++);
        }
    }
}

/// Domes with a guide that knows the place of the point, and half of its directions.
class GuidedDomeTest : public LightChiSquareTest {
protected:
    void Guide(LightTable table) {
        constexpr std::uint32_t kCells = HDS_GUIDE_ROWS * HDS_GUIDE_COLUMNS;
        std::vector<std::uint32_t> cells(std::size_t{HDS_GUIDE_PLACES} * kCells);
        for (std::uint32_t i = 0; i < cells.size(); ++i) {
            cells[i] = i % kCells < kCells / 2 ? 100 * (i % 7) : 0;
        }
        shared::HdsLight& dome = table.lights[0];
        const auto base = std::uint32_t(table.cdf.size());
        dome.flags |= HDS_LIGHT_GUIDED;
        dome.params[0] = shared::FloatOfBits(base);
        const std::vector<float> guide =
            BuildDomeGuide({1.0F, 2.0F, 3.0F}, cells, LightOfCells(dome, table.cdf), base);
        table.cdf.insert(table.cdf.end(), guide.begin(), guide.end());
        SetTable(table);
    }

    void CheckSphere(const char* name, const glm::dvec3& point, const glm::dvec3& normal,
                     unsigned seed) {
        LightDomain sphere;
        sphere.toSquare = [](const glm::dvec3& d, const glm::dvec3&) {
            return Square{std::clamp(std::atan2(d.y, d.x) / (2.0 * kPi) + 0.5, 0.0, 1.0 - 1e-9),
                          std::clamp(0.5 * d.z + 0.5, 0.0, 1.0 - 1e-9)};
        };
        sphere.fromSquare = [](const Square& s) {
            const double z = 2.0 * s[1] - 1.0;
            const double r = std::sqrt(1.0 - z * z);
            const double phi = 2.0 * kPi * (s[0] - 0.5);
            return glm::dvec3(r * std::cos(phi), r * std::sin(phi), z);
        };
        sphere.solidAngleOfSquare = [](const Square&) { return 4.0 * kPi; };
        Check(name, point, normal, sphere, seed);
    }
};

TEST_F(GuidedDomeTest, WithoutAnImage) {
    Guide(SetLights({MakeLight(LightType::Dome)}));
    CheckSphere("guide, in the air", {4.0, 2.5, 3.5}, glm::dvec3(0.0), 700);
    CheckSphere("guide, on a surface", {0.0, 1.0, 9.0}, glm::normalize(glm::dvec3(1.0, 0.5, -2.0)),
                701);
}

TEST_F(GuidedDomeTest, WithAnImageAlsoUnderAnAffineTransform) {
    LightImage image;
    image.width = 64;
    image.height = 32;
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            const double phi = 2.0 * kPi * (x + 0.5) / image.width;
            const double polar = kPi * (y + 0.5) / image.height;
            const double value = 2.0 + 0.8 * std::sin(polar) * std::sin(phi) + std::cos(polar);
            image.rgb.insert(image.rgb.end(), 3, float(value));
        }
    }
    PlacedLight light = MakeLight(LightType::Dome);
    light.light.textureFile.authoredPath = "dome.exr";
    unsigned seed = 702;
    for (const glm::dvec3& scale : {glm::dvec3(1.0), glm::dvec3(1.0, 0.5, -2.0)}) {
        light.worldFromLight = glm::scale(Rotation(), scale);
        Guide(SetLights({light}, image));
        CheckSphere("guided image", {4.0, 2.5, 3.5}, glm::dvec3(0.0), seed++);
    }
}

TEST_F(LightChiSquareTest, Distant) {
    unsigned seed = 600;
    for (const double angle : {0.53, 60.0, 270.0}) {
        PlacedLight light = MakeLight(LightType::Distant);
        light.light.angle = float(angle);
        light.worldFromLight = Rotation();
        SetLights({light});
        const double half = 0.5 * double(float(angle)) * kPi / 180.0;
        Check("distant", {3, 4, 5}, glm::dvec3(0.0),
              ConeDomain(glm::dmat3(1.0), glm::dvec3(light.worldFromLight[2]),
                         2.0 * std::pow(std::sin(0.5 * half), 2.0)),
              seed++);
    }
}

/// SphereDomain about the frame's z axis, in a space M away from the world's.
LightDomain WholeSphereDomain(const glm::dmat3& m) {
    const glm::dmat3 inverse = glm::inverse(m);
    LightDomain domain;
    const auto local = [](const Square& s) {
        const double r = std::sin(kPi * s[0]);
        const double phi = 2.0 * kPi * s[1];
        return glm::dvec3(r * std::cos(phi), r * std::sin(phi), std::cos(kPi * s[0]));
    };
    domain.toSquare = [=](const glm::dvec3& direction, const glm::dvec3&) {
        const glm::dvec3 d = inverse * direction;
        return SphereDomain::ToSquare(&d.x);
    };
    domain.fromSquare = [=](const Square& s) { return m * local(s); };
    domain.solidAngleOfSquare = [=](const Square& s) {
        const double stretch = glm::length(m * local(s));
        return SphereDomain::Jacobian(s) * std::abs(glm::determinant(m)) /
               (stretch * stretch * stretch);
    };
    return domain;
}

TEST_F(LightChiSquareTest, UniformDome) {
    SetLights({MakeLight(LightType::Dome)});
    const glm::dvec3 n = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));
    const glm::dvec3 x = glm::normalize(glm::cross(n, glm::dvec3(1, 0, 0)));
    const glm::dmat3 frame(x, glm::cross(n, x), n);
    Check("dome above a normal", {0, 0, 0}, n, WholeSphereDomain(frame), 700);
    Check("dome all around", {0, 0, 0}, glm::dvec3(0.0), WholeSphereDomain(frame), 701);
}

TEST_F(LightChiSquareTest, ImageDomeAlsoUnderAnAffineTransform) {
    // Texel borders coincide with those of the bins' subdivisions; a bright spot and black rows.
    LightImage image;
    image.width = 32;
    image.height = 32;
    std::mt19937 generator(7);
    for (std::uint32_t y = 0; y < 32; ++y) {
        for (std::uint32_t x = 0; x < 32; ++x) {
            float value = float(generator() >> 8) * 0x1p-24F;
            value = y > 24 ? 0.0F : value;
            value = x == 5 && y == 9 ? 40.0F : value;
            image.rgb.insert(image.rgb.end(), 3, value);
        }
    }
    PlacedLight light = MakeLight(LightType::Dome);
    light.light.textureFile.authoredPath = "dome.exr";
    // The domain's pole is the image's: (x, y, z) of the domain is (z, x, y) of light space.
    const glm::dmat3 poleUp(glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0));
    unsigned seed = 710;
    for (const glm::dvec3& scale : {glm::dvec3(1.0), glm::dvec3(1.0, 0.5, -2.0)}) {
        light.worldFromLight = glm::scale(Rotation(), scale);
        SetLights({light}, image);
        Check("image dome", {0, 0, 0}, glm::dvec3(0.0),
              WholeSphereDomain(glm::dmat3(light.worldFromLight) * poleUp), seed++);
    }
}

/// A parallelogram of two triangles that `height` leaves that far above the point: far enough it is
/// sampled by area, near by solid angle.
class ParallelogramTest : public LightChiSquareTest {
protected:
    void CheckAt(double height, unsigned seed) {
        EmissiveMesh mesh;
        mesh.radiance = glm::dvec3(1.0);
        const glm::dvec3 base(-1.0, -0.5, height);
        const glm::dvec3 e1(2.0, 0.1, 0.4);
        const glm::dvec3 e2(0.2, 1.5, -0.2);
        mesh.triangles.push_back({{base, base + e2, base + e1}, 0});
        mesh.triangles.push_back({{base + e1, base + e2, base + e1 + e2}, 1});
        Warnings warnings;
        SetTable(BuildLightTable({}, {mesh}, {}, warnings));
        const std::size_t count = kNumSamples;
        const std::vector<float> origins(count * 3, 0.0F);
        const auto results = Sample(origins, origins, RandomSquares(count * 2, seed));
        const glm::dmat3 toSquare = glm::inverse(glm::dmat3(e1, e2, glm::cross(e1, e2)));
        std::vector<Square> samples;
        for (const LightSampleResult& r : results) {
            ASSERT_TRUE(r.isValid);
            const glm::dvec3 s = toSquare * (r.direction * r.distance - base);
            samples.push_back({s.x, s.y});
        }
        const glm::dvec3 normal = glm::cross(e1, e2); // as long as the area
        std::vector<double> densities;
        double sum = 0.0;
        for (const Square& s : DensityPoints()) {
            const glm::dvec3 p = base + s[0] * e1 + s[1] * e2;
            const double distance = glm::length(p);
            const double solidAngle =
                std::abs(glm::dot(p, normal)) / (distance * distance * distance);
            densities.push_back(solidAngle);
            sum += solidAngle;
        }
        const double mean = sum / double(densities.size());
        const bool isByArea = mean < 0.01;
        for (double& density : densities) {
            density = isByArea ? 1.0 : density / mean;
        }
        for (std::size_t i = 0; i < 100; ++i) {
            const double distance = results[i].distance;
            const double cosine = std::abs(glm::dot(results[i].direction, glm::normalize(normal)));
            const double byArea = distance * distance / (glm::length(normal) * cosine);
            const double expected = isByArea ? byArea : 1.0 / mean; // the solid angle of all
            ASSERT_NEAR(results[i].pdf / expected, 1.0, 1e-3);
        }
        EXPECT_TRUE(isByArea || *std::max_element(densities.begin(), densities.end()) > 2.0);
        ExpectChiSquare("mesh", samples, count, densities);
    }
};

TEST_F(ParallelogramTest, FarIsSampledByArea) {
    CheckAt(30.0, 720);
}

TEST_F(ParallelogramTest, NearIsSampledBySolidAngle) {
    CheckAt(0.7, 721);
}

} // namespace
} // namespace hds::test
