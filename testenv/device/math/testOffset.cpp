// SPDX-License-Identifier: Apache-2.0
// Rays that leave a triangle at the offset origin start on the right side of its plane, and never
// come back to it, whatever the scale, place and nesting of the mesh.
#include "testenv/support/deviceFixture.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat4x4.hpp>

#include <cmath>
#include <random>

namespace hds::test {
namespace {

constexpr int kLevels = 2; ///< nested instances above a triangle

const char* const kSource = R"(
#include "accel/triangle.clh"
#include "math/inverse.clh"
#include "math/offset.clh"
kernel void offsets(global const float* triangles, global const float* uv,
                    global const float* childFromParent,
                    global const float* directions, uint levels, global float* origins,
                    global float* inObject, global float* sides,
                    uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsSurfacePoint point = offset_begin(vload3(3 * i, triangles), vload3(3 * i + 1, triangles),
                                         vload3(3 * i + 2, triangles), uv[2 * i], uv[2 * i + 1]);
    for (uint level = 0; level < levels; ++level) {
        HdsTransform inward = transform_load(childFromParent + (i * levels + level) * 12);
        HdsTransform outward = transform_inverse(&inward);
        const HdsAffine in = affine_fromTransform(&inward);
        const HdsAffine out = affine_fromTransform(&outward);
        offset_toParent(&point, &out, &in);
    }
    offset_finish(&point);
    float3 d = vload3(i, directions);
    float3 origin = offset_origin(&point, d);
    vstore3(origin, i, origins);
    sides[i] = vec_dot(d, point.normal) >= 0.0f ? 1.0f : -1.0f;
    /* The way back that a traversal takes: level by level, in float. */
    for (uint level = levels; level > 0; --level) {
        HdsTransform inward = transform_load(childFromParent + (i * levels + level - 1) * 12);
        origin = transform_point(&inward, origin);
        d = transform_vector(&inward, d);
    }
    vstore3(origin, 2 * i, inObject);
    vstore3(d, 2 * i + 1, inObject);
    HdsShear shear = triangle_shear(origin, d);
    HdsTriangleHit hit;
    global const float* p0 = triangles + 9 * i;
    bool isHit = triangle_intersect(&shear, p0, p0 + 3, p0 + 6, 0.0f, INFINITY, &hit);
    sides[i] = isHit ? 2.0f * sides[i] : sides[i];
}
)";

struct Cases {
    std::vector<float> triangles;
    std::vector<float> uv;
    std::vector<float> inward;
    std::vector<float> directions;
};

glm::dvec3 RandomUnit(std::mt19937& generator) {
    std::normal_distribution<double> normal;
    return glm::normalize(glm::dvec3(normal(generator), normal(generator), normal(generator)));
}

double LogUniform(std::mt19937& generator, double low, double high) {
    std::uniform_real_distribution<double> uniform(std::log(low), std::log(high));
    return std::exp(uniform(generator));
}

void AppendRows(const glm::dmat4& m, std::vector<float>& rows) {
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
            rows.push_back(float(m[column][row]));
        }
    }
}

/// A rotation, a (not uniform) scale of 1e-6 to 1e6, some of them mirrored or sheared, and a
/// translation of up to 1e7.
glm::dmat4 RandomTransform(std::mt19937& generator) {
    const double scale = LogUniform(generator, 1e-6, 1e6);
    const glm::dvec3 scales(scale * LogUniform(generator, 0.3, 3.0),
                            scale * LogUniform(generator, 0.3, 3.0), scale);
    const glm::dvec3 translation = RandomUnit(generator) * LogUniform(generator, 1e-3, 1e7);
    glm::dmat4 m = glm::translate(glm::dmat4(1.0), translation);
    m = glm::rotate(m, LogUniform(generator, 0.01, 3.0), RandomUnit(generator));
    m = glm::scale(m, generator() % 4 == 0 ? -scales : scales);
    if (generator() % 4 == 0) {
        glm::dmat4 shear(1.0);
        shear[1][0] = LogUniform(generator, 0.01, 2.0);
        m = m * shear;
    }
    return m;
}

Cases RandomCases(std::size_t count, int levels, unsigned seed) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> uniform;
    Cases cases;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 base = RandomUnit(generator) * LogUniform(generator, 1e-2, 1e2);
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 p = base + RandomUnit(generator) * LogUniform(generator, 1e-2, 1.0);
            cases.triangles.insert(cases.triangles.end(), {float(p.x), float(p.y), float(p.z)});
        }
        const double root = std::sqrt(uniform(generator));
        const double v = uniform(generator) * root;
        cases.uv.insert(cases.uv.end(), {float(1.0 - root), float(v)});
        for (int level = 0; level < levels; ++level) {
            const glm::dmat4 m = RandomTransform(generator);
            AppendRows(glm::inverse(m), cases.inward);
        }
    }
    return cases;
}

glm::dvec3 Load(const std::vector<float>& values, std::size_t index) {
    return {values[index * 3], values[index * 3 + 1], values[index * 3 + 2]};
}

class OffsetTest : public DeviceFixture {
protected:
    /// Runs the cases with directions that graze each triangle's world plane on a random side.
    /// Expects the origin, back in the triangle's space, strictly on the side that the device took
    /// the direction for (within 1e-5 of the plane of a sliver that may be either), and the ray to
    /// leave the plane or to come back only beyond the triangle.
    void Check(std::size_t count, int levels, unsigned seed) {
        Cases cases = RandomCases(count, levels, seed);
        AddGrazingDirections(cases, count, levels, seed);
        auto program = Build(kSource);
        const Buffer triangles = Upload(cases.triangles);
        const Buffer uv = Upload(cases.uv);
        const Buffer inward = Upload(cases.inward);
        const Buffer directions = Upload(cases.directions);
        const Buffer origins = Allocate(count * 3 * sizeof(float));
        const Buffer local = Allocate(count * 6 * sizeof(float));
        const Buffer sideBuffer = Allocate(count * sizeof(float));
        program->GetKernel("offsets").Launch(count, triangles, uv, inward, directions,
                                             std::uint32_t(levels), origins, local, sideBuffer,
                                             std::uint32_t(count));
        const std::vector<float> sides = Download<float>(sideBuffer, count);
        const std::vector<float> rays = Download<float>(local, count * 6);
        std::size_t wrongSide = 0;
        std::size_t rehits = 0;
        std::size_t rehitsByTest = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const glm::dvec3 p0 = Load(cases.triangles, 3 * i);
            const glm::dvec3 e1 = Load(cases.triangles, 3 * i + 1) - p0;
            const glm::dvec3 e2 = Load(cases.triangles, 3 * i + 2) - p0;
            const glm::dvec3 n = glm::normalize(glm::cross(e1, e2));
            const glm::dvec3 origin = Load(rays, 2 * i);
            const glm::dvec3 direction = Load(rays, 2 * i + 1);
            rehitsByTest += std::abs(sides[i]) > 1.5F ? 1 : 0;
            const double height = glm::dot(n, origin - p0) * sides[i];
            const double climb = glm::dot(n, direction) * sides[i];
            wrongSide += height > 0.0 ? 0 : 1;
            // The rounded direction may sink towards the plane; it must meet it off the triangle.
            if (height > 0.0 && climb < 0.0) {
                const glm::dvec3 hit = origin + direction * (height / -climb) - p0;
                const double d11 = glm::dot(e1, e1);
                const double d12 = glm::dot(e1, e2);
                const double d22 = glm::dot(e2, e2);
                const double h1 = glm::dot(hit, e1);
                const double h2 = glm::dot(hit, e2);
                const double determinant = d11 * d22 - d12 * d12;
                const double u = (d22 * h1 - d12 * h2) / determinant;
                const double v = (d11 * h2 - d12 * h1) / determinant;
                rehits += u >= 0.0 && v >= 0.0 && u + v <= 1.0 ? 1 : 0;
            }
        }
        EXPECT_EQ(wrongSide, 0U);
        EXPECT_EQ(rehits, 0U);
        EXPECT_EQ(rehitsByTest, 0U);
    }

private:
    static void AddGrazingDirections(Cases& cases, std::size_t count, int levels, unsigned seed) {
        std::mt19937 generator(seed + 1000);
        for (std::size_t i = 0; i < count; ++i) {
            // World normal: the covector through the inverse of every level.
            const glm::dvec3 p0 = Load(cases.triangles, 3 * i);
            glm::dvec3 n = glm::cross(Load(cases.triangles, 3 * i + 1) - p0,
                                      Load(cases.triangles, 3 * i + 2) - p0);
            for (int level = 0; level < levels; ++level) {
                const float* rows =
                    &cases.inward[(i * std::size_t(levels) + std::size_t(level)) * 12];
                n = n.x * glm::dvec3(rows[0], rows[1], rows[2]) +
                    n.y * glm::dvec3(rows[4], rows[5], rows[6]) +
                    n.z * glm::dvec3(rows[8], rows[9], rows[10]);
                n = glm::normalize(n);
            }
            n = glm::normalize(n);
            const double side = generator() & 1U ? 1.0 : -1.0;
            const glm::dvec3 along = glm::normalize(glm::cross(n, RandomUnit(generator)));
            const double elevation = LogUniform(generator, 1e-5, 1.0);
            const glm::dvec3 d = glm::normalize(along + n * (side * elevation));
            cases.directions.insert(cases.directions.end(), {float(d.x), float(d.y), float(d.z)});
        }
    }
};

TEST_F(OffsetTest, RaysDoNotReturnToATriangleInWorldSpace) {
    Check(300000, 0, 11);
}
TEST_F(OffsetTest, RaysDoNotReturnToATriangleOfAnInstance) {
    Check(1000000, 1, 12);
}
TEST_F(OffsetTest, RaysDoNotReturnToATriangleOfANestedInstance) {
    Check(300000, kLevels, 13);
}

TEST_F(OffsetTest, OffsetIsScaleFreeAndSmall) {
    // Near the origin of its space a triangle of extent 1 moves by about 1e-6, at any scale.
    for (const float scale : {1e-12F, 1.0F, 1e12F}) {
        const std::vector<float> triangle = {0, 0, 0, scale, 0, 0, 0, scale, 0};
        const std::vector<float> uv = {0.25F, 0.25F};
        const std::vector<float> direction = {0, 0, 1};
        auto program = Build(kSource);
        const Buffer triangles = Upload(triangle);
        const Buffer barycentrics = Upload(uv);
        const Buffer none = Allocate(16);
        const Buffer directions = Upload(direction);
        const Buffer origins = Allocate(16);
        const Buffer local = Allocate(32);
        const Buffer sides = Allocate(16);
        program->GetKernel("offsets").Launch(1, triangles, barycentrics, none, directions,
                                             std::uint32_t(0), origins, local, sides,
                                             std::uint32_t(1));
        const std::vector<float> origin = Download<float>(origins, 3);
        EXPECT_GT(origin[2], 2e-7F * scale);
        EXPECT_LT(origin[2], 2e-6F * scale);
    }
}

} // namespace
} // namespace hds::test
