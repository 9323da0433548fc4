// SPDX-License-Identifier: Apache-2.0
// Light tables on a device and kernels that call kernels/light over arrays of points and
// directions.
#pragma once

#include "hdStream/shading/lightTable.h"
#include "kernels/shared/texture.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/testTextures.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <array>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace hds::test {

/// What light_sample and, for the direction it returned, light_intersect and light_pdf said.
struct LightSampleResult {
    glm::dvec3 direction{0.0};
    double distance = 0.0;
    glm::dvec3 radiance{0.0};
    double pdf = 0.0;
    std::uint32_t light = HDS_NONE;
    bool isDelta = false;
    bool isValid = false;
    bool isHit = false; ///< light_intersect found that light
    double hitDistance = 0.0;
    double hitPdf = 0.0; ///< light_pdf of the hit
};

inline const char* const kLightKernels = R"(
#include "light/imageLookup.clh"
#include "light/walk.clh"
#include "sample/sampler.clh"
#define LIGHT_ARGS HDS_LIGHT_PARAMETERS, HDS_TEXTURE_ARGS
#define LIGHT_VIEW(view)     \
    HDS_LIGHT_VIEW(view);    \
    HdsTextureView textures; \
    HDS_TEXTURE_VIEW(textures)
/* Radiance of a light that a ray of no width meets at t, with its image. */
float3 radianceOf(const HdsLightView* view, const HdsTextureView* textures, uint light, float3 p,
                  float3 d, float t) {
    float3 radiance = light_radiance(view, light, d, 0.0f);
    if (light_hasImage(view->lights + light)) {
        bool isMissing = false;
        const HdsImagePlace place = light_imagePlace(view, light, p, d, t, 0.0f);
        radiance *= lightImage_lookup(view, textures, light, place.image, place.color, d, t,
                                      cones_begin(0.0f, 0.0f), false, 0.0f, 0.0f, &isMissing);
    }
    return radiance;
}
kernel void sampleAll(LIGHT_ARGS, global const float* points, global const float* normals,
                      global const float* us, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    LIGHT_VIEW(view);
    float3 p = vload3(i, points);
    float3 n = vload3(i, normals);
    const HdsLitPoint lit = {p, n, 0u};
    HdsLightSample s;
    s.direction = (float3)(0.0f);
    s.radiance = (float3)(0.0f);
    s.distance = 0.0f;
    s.pdf = 0.0f;
    s.light = HDS_NONE;
    s.isDelta = 0u;
    bool isValid = light_sample(&view, &lit, us[4 * i], vload2(2 * i + 1, us), &s);
    if (isValid && light_hasImage(view.lights + s.light)) {
        s.radiance = radianceOf(&view, &textures, s.light, p, s.direction, s.distance);
    }
    float t = 0.0f;
    bool isHit = isValid && light_intersect(&view, s.light, p, s.direction, INFINITY, 0.0f, &t);
    float hitPdf = 0.0f;
    if (isHit) {
        const HdsImagePlace place = light_imagePlace(&view, s.light, p, s.direction, t, 0.0f);
        hitPdf = light_pdf(&view, s.light, &lit, s.direction, t, &place);
    }
    global float* o = out + 16 * i;
    vstore3(s.direction, 0, o);
    o[3] = s.distance;
    vstore3(s.radiance, 0, o + 4);
    o[7] = s.pdf;
    o[8] = as_float(s.light);
    o[9] = s.isDelta != 0u ? 1.0f : 0.0f;
    o[10] = isValid ? 1.0f : 0.0f;
    o[11] = isHit ? 1.0f : 0.0f;
    o[12] = t;
    o[13] = hitPdf;
}
/* For each direction: distance at which the light is hit (negative: not), density and radiance. */
kernel void intersectAll(LIGHT_ARGS, uint light, global const float* points,
                         global const float* normals, global const float* directions, uint onePoint,
                         global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    LIGHT_VIEW(view);
    uint at = onePoint != 0u ? 0u : i;
    float3 p = vload3(at, points);
    float3 d = vload3(i, directions);
    const HdsLitPoint lit = {p, vload3(at, normals), 0u};
    float t;
    bool isHit = light_intersect(&view, light, p, d, INFINITY, 0.0f, &t);
    out[3 * i] = isHit ? t : -1.0f;
    out[3 * i + 1] = 0.0f;
    if (isHit) {
        const HdsImagePlace place = light_imagePlace(&view, light, p, d, t, 0.0f);
        out[3 * i + 1] = light_pdf(&view, light, &lit, d, t, &place);
    }
    out[3 * i + 2] = isHit ? radianceOf(&view, &textures, light, p, d, t).x : 0.0f;
}
/* The power heuristic. */
float misOf(float pdf, float other) { return pdf * pdf / (pdf * pdf + other * other); }
/* Irradiance by light sampling, by cosine-weighted directions that look for lights, and by both of
 * them together. */
kernel void irradiances(LIGHT_ARGS, global const float* points,
                        global const float* normals, uint perItem, uint itemsPerPoint,
                        global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    LIGHT_VIEW(view);
    uint point = i / itemsPerPoint;
    float3 p = vload3(point, points);
    float3 n = vload3(point, normals);
    HdsFrame frame = frame_fromNormal(n);
    const HdsLitPoint lit = {p, n, 0u};
    float direct = 0.0f;
    float gathered = 0.0f;
    float together = 0.0f;
    for (uint k = 0; k < perItem; ++k) {
        HdsSampler sampler = sampler_init(point, 0u, (i % itemsPerPoint) * perItem + k, 9u);
        HdsLightSample s;
        if (light_sample(&view, &lit, sampler_get1(sampler, 0u), sampler_get2(sampler, 1u), &s)) {
            float3 radiance = light_hasImage(view.lights + s.light)
                                  ? radianceOf(&view, &textures, s.light, p, s.direction, s.distance)
                                  : s.radiance;
            float cosine = fmax(vec_dot(s.direction, n), 0.0f);
            float value = radiance.x * cosine / s.pdf;
            direct += value;
            together += s.isAlone != 0u ? value : value * misOf(s.pdf, cosine / HDS_PI);
        }
        float3 d = frame_toWorld(&frame, warp_cosineHemisphere(sampler_get2(sampler, 2u)));
        for (uint light = 0u; light < view.numLights; ++light) {
            float t;
            if (light_intersect(&view, light, p, d, INFINITY, 0.0f, &t)) {
                float value = HDS_PI * radianceOf(&view, &textures, light, p, d, t).x;
                gathered += value;
                const HdsImagePlace place = light_imagePlace(&view, light, p, d, t, 0.0f);
                bool isAlone = (view.lights[light].flags & HDS_LIGHT_SAMPLED) != 0u;
                float pdf = light_pdf(&view, light, &lit, d, t, &place);
                together += isAlone ? 0.0f : value * misOf(vec_dot(d, n) / HDS_PI, pdf);
            }
        }
    }
    out[3 * i] = direct / (float)perItem;
    out[3 * i + 1] = gathered / (float)perItem;
    out[3 * i + 2] = together / (float)perItem;
}
/* For each ray: lights that it meets, by trying all and by a walk; and the sums of their indices. */
kernel void meetings(HDS_LIGHT_PARAMETERS, global const float* points,
                     global const float* directions, float tMax, global uint* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HDS_LIGHT_VIEW(view);
    const float3 p = vload3(i, points);
    const float3 d = vload3(i, directions);
    uint4 found = (uint4)(0u);
    float t;
    for (uint light = 0u; light < view.numLights; ++light) {
        if (light_intersect(&view, light, p, d, tMax, 0.0f, &t)) {
            found.xy += (uint2)(1u, light);
        }
    }
    HdsLightWalk walk = lightWalk_begin(&view, p, d, tMax);
    uint light;
    while ((light = lightWalk_next(&view, &walk, p, d, tMax)) != HDS_NONE) {
        if (light_intersect(&view, light, p, d, tMax, 0.0f, &t)) {
            found.zw += (uint2)(1u, light);
        }
    }
    vstore4(found, i, out);
}
kernel void selections(HDS_LIGHT_PARAMETERS, global const float* points, global const float* normals,
                       global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HDS_LIGHT_VIEW(view);
    const HdsLitPoint lit = {vload3(i, points), vload3(i, normals), 0u};
    for (uint light = 0u; light < numLights; ++light) {
        out[i * numLights + light] = light_selectPmf(&view, light, &lit);
    }
}
)";

/// A fixture that holds one table at a time.
class LightFixture : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            _program = Build(kLightKernels, {{"HDS_NUM_TEXTURE_POOLS", "1"}});
            SetImage({});
        }
    }

    void SetTable(const LightTable& table) {
        _lights = Upload(table.lights);
        _nodes = Upload(table.nodes);
        _triangles = Upload(table.triangles);
        _cdf = Upload(table.cdf);
        _numLights = std::uint32_t(table.lights.size());
    }
    /// Builds the table of lights; expects no warning. \param image of all that name one
    LightTable SetLights(const std::vector<PlacedLight>& lights, const LightImage& image = {}) {
        const LoadLightImage load = [&](const AssetReference&) {
            return LightTexture{std::make_shared<LightImage>(image), 0};
        };
        Warnings warnings;
        const LightTable table = BuildLightTable(lights, {}, {load, {}, {}}, warnings);
        EXPECT_EQ(warnings.Lines(), std::vector<std::string>());
        SetTable(table);
        SetImage(image);
        return table;
    }

    std::vector<LightSampleResult> Sample(const std::vector<float>& points,
                                          const std::vector<float>& normals,
                                          const std::vector<float>& us) {
        const std::size_t count = points.size() / 3;
        const Buffer pointBuffer = Upload(points);
        const Buffer normalBuffer = Upload(normals);
        const Buffer usBuffer = Upload(us);
        const Buffer out = Allocate(count * 16 * sizeof(float));
        _program->GetKernel("sampleAll")
            .Launch(count, _lights, _nodes, _triangles, _cdf, _numLights,
                    HDS_TEST_TEXTURE_ARGS(_records, _lines), pointBuffer, normalBuffer, usBuffer,
                    out, std::uint32_t(count));
        const std::vector<float> values = Download<float>(out, count * 16);
        std::vector<LightSampleResult> results(count);
        for (std::size_t i = 0; i < count; ++i) {
            const float* v = &values[16 * i];
            LightSampleResult& r = results[i];
            r.direction = {v[0], v[1], v[2]};
            r.distance = v[3];
            r.radiance = {v[4], v[5], v[6]};
            r.pdf = v[7];
            std::memcpy(&r.light, &v[8], sizeof(r.light));
            r.isDelta = v[9] > 0.0F;
            r.isValid = v[10] > 0.0F;
            r.isHit = v[11] > 0.0F;
            r.hitDistance = v[12];
            r.hitPdf = v[13];
        }
        return results;
    }

    /// distance (-1: no hit), density, red radiance for each direction from one or many points.
    std::vector<float> Intersect(std::uint32_t light, const std::vector<float>& points,
                                 const std::vector<float>& normals,
                                 const std::vector<float>& directions) {
        const std::size_t count = directions.size() / 3;
        const Buffer pointBuffer = Upload(points);
        const Buffer normalBuffer = Upload(normals);
        const Buffer directionBuffer = Upload(directions);
        const Buffer out = Allocate(count * 3 * sizeof(float));
        _program->GetKernel("intersectAll")
            .Launch(count, _lights, _nodes, _triangles, _cdf, _numLights,
                    HDS_TEST_TEXTURE_ARGS(_records, _lines), light, pointBuffer, normalBuffer,
                    directionBuffer, std::uint32_t(points.size() == 3 ? 1 : 0), out,
                    std::uint32_t(count));
        return Download<float>(out, count * 3);
    }

    /// {by light sampling, by gathering, by both together} for each point.
    std::vector<std::array<double, 3>> Irradiance(const std::vector<float>& points,
                                                  const std::vector<float>& normals,
                                                  std::uint32_t samplesPerPoint) {
        constexpr std::uint32_t kItemsPerPoint = 64;
        const std::size_t count = points.size() / 3;
        const std::size_t items = count * kItemsPerPoint;
        const Buffer pointBuffer = Upload(points);
        const Buffer normalBuffer = Upload(normals);
        const Buffer out = Allocate(items * 3 * sizeof(float));
        _program->GetKernel("irradiances")
            .Launch(items, _lights, _nodes, _triangles, _cdf, _numLights,
                    HDS_TEST_TEXTURE_ARGS(_records, _lines), pointBuffer, normalBuffer,
                    samplesPerPoint / kItemsPerPoint, kItemsPerPoint, out, std::uint32_t(items));
        const std::vector<float> values = Download<float>(out, items * 3);
        std::vector<std::array<double, 3>> sums(count, {0.0, 0.0, 0.0});
        for (std::size_t i = 0; i < 3 * items; ++i) {
            sums[i / 3 / kItemsPerPoint][i % 3] += double(values[i]) / kItemsPerPoint;
        }
        return sums;
    }

    /// {lights met, sum of their indices} by trying all lights, then by a walk, for each ray.
    std::vector<std::uint32_t> Meetings(const std::vector<float>& points,
                                        const std::vector<float>& directions, float tMax) {
        const std::size_t count = points.size() / 3;
        const Buffer pointBuffer = Upload(points);
        const Buffer directionBuffer = Upload(directions);
        const Buffer out = Allocate(count * 4 * sizeof(std::uint32_t));
        _program->GetKernel("meetings")
            .Launch(count, _lights, _nodes, _triangles, _cdf, _numLights, pointBuffer,
                    directionBuffer, tMax, out, std::uint32_t(count));
        return Download<std::uint32_t>(out, count * 4);
    }

    /// Probabilities of all lights at each point.
    std::vector<float> Selections(const std::vector<float>& points,
                                  const std::vector<float>& normals) {
        const std::size_t count = points.size() / 3;
        const Buffer pointBuffer = Upload(points);
        const Buffer normalBuffer = Upload(normals);
        const Buffer out = Allocate(count * _numLights * sizeof(float));
        _program->GetKernel("selections")
            .Launch(count, _lights, _nodes, _triangles, _cdf, _numLights, pointBuffer, normalBuffer,
                    out, std::uint32_t(count));
        return Download<float>(out, count * _numLights);
    }

private:
    /// Texture 0: the image, in floats.
    void SetImage(const LightImage& image) {
        TestTextures textures;
        if (!image.rgb.empty()) {
            textures.AddImage(image.width, image.height, image.rgb);
        }
        _records = Upload(textures.Records());
        _lines = Upload(textures.Lines());
    }

    std::unique_ptr<Program> _program;
    Buffer _lights;
    Buffer _nodes;
    Buffer _triangles;
    Buffer _cdf;
    Buffer _records;
    Buffer _lines;
    std::uint32_t _numLights = 0;
};

/// A light of a type with radiance 1 (white, intensity 1) at the origin.
inline PlacedLight MakeLight(LightType type) {
    PlacedLight placed;
    placed.name = "/light";
    placed.light.type = type;
    return placed;
}

inline std::vector<float> RandomUnits(std::mt19937& generator, std::size_t count) {
    std::vector<float> values(count);
    for (float& value : values) {
        value = float(generator() >> 8) * 0x1p-24F;
    }
    return values;
}

inline void Append(std::vector<float>& values, const glm::dvec3& v) {
    values.insert(values.end(), {float(v.x), float(v.y), float(v.z)});
}

} // namespace hds::test
