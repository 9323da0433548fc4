// SPDX-License-Identifier: Apache-2.0
// Which mip of a light's image a ray cone sees, and where: by the geometry of latitude and
// longitude, and of a rect that is seen from straight ahead. Texels in double precision.
#include "hdStream/shading/lightTable.h"
#include "kernels/shared/program.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/testTextures.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <random>

namespace hds::test {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint32_t kWidth = 64;
constexpr std::uint32_t kHeight = 48; ///< not half of it: the two axes differ
constexpr std::uint32_t kTableMip = 2;

const char* const kKernel = R"(
#include "light/imageLookup.clh"
kernel void lookUp(HDS_LIGHT_PARAMETERS, HDS_TEXTURE_ARGS, global const float* rays, float t,
                   float width, float bias, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HDS_LIGHT_VIEW(view);
    HdsTextureView textures;
    HDS_TEXTURE_VIEW(textures);
    bool isMissing = false;
    HdsRayCones cones = cones_begin(width, rays[7 * i + 6]);
    float3 origin = vload3(0, rays + 7 * i);
    float3 direction = vload3(0, rays + 7 * i + 3);
    const HdsImagePlace place = light_imagePlace(&view, 0u, origin, direction, t, 0.0f);
    float3 value = lightImage_lookup(&view, &textures, 0u, place.image, place.color, direction, t,
                                     cones, false, bias, 0.0f, &isMissing);
    vstore3(isMissing ? (float3)(-1.0f) : value, i, out);
}
)";

/// Origin, direction, and the cone's angle.
struct Ray {
    glm::dvec3 origin{0.0};
    glm::dvec3 direction{0.0};
    double angle = 0.0;
};

class LightImageLookup : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        textures.Add(kWidth, kHeight, HDS_TEXEL_U8 | 2U, HDS_SWIZZLE_RGBA, 11);
    }

    std::vector<glm::dvec3> LookUpOf(const PlacedLight& light, const std::vector<Ray>& rays,
                                     float t, float width, float bias = 0.0F) {
        const LoadLightImage load = [this](const AssetReference&) {
            return LightTexture{std::make_shared<LightImage>(TableImage()), 0};
        };
        Warnings warnings;
        const LightTable table = BuildLightTable({light}, {}, {load, {}, {}}, warnings);
        std::vector<float> values;
        for (const Ray& ray : rays) {
            values.insert(values.end(),
                          {float(ray.origin.x), float(ray.origin.y), float(ray.origin.z),
                           float(ray.direction.x), float(ray.direction.y), float(ray.direction.z),
                           float(ray.angle)});
        }
        const Buffer lights = Upload(table.lights);
        const Buffer cdf = Upload(table.cdf);
        const Buffer records = Upload(textures.Records());
        const Buffer lines = Upload(textures.Lines());
        const Buffer rayBuffer = Upload(values);
        const Buffer out = Allocate(rays.size() * 3 * sizeof(float));
        const auto program = Build(kKernel, {{"HDS_NUM_TEXTURE_POOLS", "1"}});
        program->GetKernel("lookUp").Launch(rays.size(), lights, lights, lights, cdf,
                                            std::uint32_t(1), HDS_TEST_TEXTURE_ARGS(records, lines),
                                            rayBuffer, t, width, bias, out,
                                            std::uint32_t(rays.size()));
        const std::vector<float> results = Download<float>(out, rays.size() * 3);
        std::vector<glm::dvec3> colors;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            colors.emplace_back(results[3 * i], results[3 * i + 1], results[3 * i + 2]);
        }
        return colors;
    }

    /// The mip that tables are made of.
    LightImage TableImage() const {
        LightImage image{kWidth >> kTableMip, kHeight >> kTableMip, {}, kTableMip};
        for (std::uint32_t y = 0; y < image.height; ++y) {
            for (std::uint32_t x = 0; x < image.width; ++x) {
                const glm::dvec2 middle((x + 0.5) / image.width, 1.0 - (y + 0.5) / image.height);
                const glm::dvec3 texel =
                    Expected(middle, HDS_WRAP_REPEAT, double(1U << kTableMip), 0.0);
                image.rgb.insert(image.rgb.end(), {float(texel.x), float(texel.y), float(texel.z)});
            }
        }
        return image;
    }

    /// \param texels that a footprint's lesser axis covers
    glm::dvec3 Expected(const glm::dvec2& st, std::uint32_t wrapS, double covered,
                        double bias) const {
        const double level =
            std::clamp(covered > 0.0 ? std::log2(covered) + bias : 0.0, 0.0, double(kTableMip));
        const glm::dvec4 axes(std::exp2(level) / kWidth, 0.0, 0.0, std::exp2(level) / kHeight);
        return LookUp(textures, 0, wrapS, HDS_WRAP_CLAMP, st, axes, 0.0);
    }

    TestTextures textures;
};

TEST_F(LightImageLookup, DomesAreSeenByTheAngle) {
    PlacedLight dome;
    dome.light.type = LightType::Dome;
    dome.light.textureFile.authoredPath = "sky.exr";
    std::mt19937 generator(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<Ray> rays;
    for (const double angle : {0.0, 1e-4, 0.07, -0.1, 0.19, 0.3, 3.0}) {
        for (int i = 0; i < 200; ++i) {
            Ray ray;
            ray.direction = glm::normalize(
                glm::dvec3(uniform(generator), uniform(generator), uniform(generator)));
            ray.angle = angle;
            rays.push_back(ray);
        }
    }
    for (const float bias : {0.0F, 0.75F}) {
        const std::vector<glm::dvec3> colors = LookUpOf(dome, rays, HDS_LIGHT_FAR, 0.0F, bias);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const glm::dvec3& d = rays[i].direction;
            // OpenEXR: column 0 is at longitude +pi, +z in the middle, the first row is up.
            const glm::dvec2 st(0.5 - std::atan2(d.x, d.z) / (2.0 * kPi),
                                1.0 - std::acos(d.y) / kPi);
            const double angle = std::abs(rays[i].angle);
            const double covered = std::min(angle * kWidth / (2.0 * kPi), angle * kHeight / kPi);
            const glm::dvec3 expected = Expected(st, HDS_WRAP_REPEAT, covered, bias);
            ASSERT_LT(glm::length(colors[i] - expected), 2e-3) << i << " angle " << angle;
        }
    }
}

TEST_F(LightImageLookup, RectsAreSeenByTheWidthAtTheirDistance) {
    PlacedLight rect;
    rect.light.type = LightType::Rect;
    rect.light.width = 4.0F;
    rect.light.height = 1.5F;
    rect.light.textureFile.authoredPath = "panel.exr";
    std::mt19937 generator(6);
    std::uniform_real_distribution<double> uniform(-0.5, 0.5);
    constexpr double kDistance = 3.0;
    constexpr double kBegin = 0.01;
    std::vector<Ray> rays;
    for (const double angle : {0.0, 0.01, 0.03, 0.06, -0.05, 0.5}) {
        for (int i = 0; i < 200; ++i) {
            Ray ray;
            ray.origin = {4.0 * uniform(generator), 1.5 * uniform(generator), -kDistance};
            ray.direction = {0.0, 0.0, 1.0};
            ray.angle = angle;
            rays.push_back(ray);
        }
    }
    const std::vector<glm::dvec3> colors = LookUpOf(rect, rays, float(kDistance), float(kBegin));
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const glm::dvec3& p = rays[i].origin;
        // The first column is at +x, the first row at +y.
        const glm::dvec2 st(0.5 - p.x / 4.0, 0.5 + p.y / 1.5);
        const double width = std::abs(kBegin + kDistance * rays[i].angle);
        const double covered = std::min(width / 4.0 * kWidth, width / 1.5 * kHeight);
        const glm::dvec3 expected = Expected(st, HDS_WRAP_CLAMP, covered, 0.0);
        ASSERT_LT(glm::length(colors[i] - expected), 2e-3) << i << " width " << width;
    }
}

} // namespace
} // namespace hds::test
