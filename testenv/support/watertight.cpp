// SPDX-License-Identifier: Apache-2.0
#include "testenv/support/watertight.h"

#include "testenv/support/dicedSource.h"
#include "testenv/support/traversalMeshes.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>

namespace hds::test {
namespace {

const char* const kKernel = R"(
#include "accel/traverse.clh"

uint leak_hash(uint x) {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}
/* A counter, hashed: it has no short cycles, in which leak_ball would never end. */
float leak_uniform(uint* state) {
    *state += 0x6d2b79f5u;
    return (float)(leak_hash(*state) >> 8) * 5.9604644775390625e-8f;
}
float3 leak_ball(uint* state, float radius) {
    float3 p = (float3)(2.0f);
    while (dot(p, p) > 1.0f) {
        p.x = 2.0f * leak_uniform(state) - 1.0f;
        p.y = 2.0f * leak_uniform(state) - 1.0f;
        p.z = 2.0f * leak_uniform(state) - 1.0f;
    }
    return p * radius;
}

/* world: 3 rows of 4. Counts rays from inside that find nothing. */
kernel void leak_count(uint seed, uint count, global const float* positions,
                       global const uint* triangles, uint numTriangles, global const float* world,
                       float innerRadius, volatile global uint* leaks, HDS_GEOMETRY_ARGS) {
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    HDS_GEOMETRY_VIEW(view);
    uint state = leak_hash(seed) ^ i * 0x9e3779b9u;
    const uint triangle = (uint)(((ulong)leak_hash(state) * numTriangles) >> 32);
    const float3 a = vload3(triangles[3u * triangle], positions);
    const float3 b = vload3(triangles[3u * triangle + 1u], positions);
    float3 origin = leak_ball(&state, innerRadius);
    const uint mode = i % 6u;
    float3 direction = leak_ball(&state, 1.0f); /* modes 4 and 5: anywhere */
    if (mode == 0u) {
        direction = a - origin;
    } else if (mode == 1u) {
        direction = a + (b - a) * leak_uniform(&state) - origin;
    } else if (mode == 2u) {
        origin = (float3)(0.0f); /* symmetric meshes: many coordinates are equal */
        direction = i % 12u < 6u ? a : a + (b - a) * 0.5f;
    } else if (mode == 3u) {
        const uint axis = i / 6u % 3u;
        /* Through a vertex along an axis, where the start is surely inside. */
        float3 across = a;
        if (axis == 0u) across.x = 0.0f;
        if (axis == 1u) across.y = 0.0f;
        if (axis == 2u) across.z = 0.0f;
        if (dot(across, across) < innerRadius * innerRadius) {
            origin = across;
        }
        const float sign = (i & 1u) ? 1.0f : -1.0f;
        direction = (float3)(axis == 0u ? sign : 0.0f, axis == 1u ? sign : -0.0f,
                             axis == 2u ? sign : 0.0f);
    }
    const HdsTransform m = transform_load(world);
    HdsTraversalRay ray;
    ray.origin = transform_point(&m, origin);
    ray.direction = transform_vector(&m, direction);
    ray.tMin = 0.0f;
    ray.tMax = INFINITY;
    HdsHit hit;
    const bool isHit = traverse_closest(&view, ray, 0u, &hit);
    if (!isHit || !traverse_occluded(&view, ray)) {
        atomic_inc(leaks);
    }
}
)";

constexpr std::uint64_t kRaysPerLaunch = 1U << 22U;

TriangleMesh Scaled(TriangleMesh mesh, glm::vec3 scale, glm::vec3 offset) {
    for (glm::vec3& p : mesh.positions) {
        p = p * scale + offset;
    }
    return mesh;
}

/// The mesh under its transforms, one group a level. `world` becomes the whole transform.
void BuildScene(const WatertightCase& watertight, AccelScene* scene, glm::dmat4* world) {
    std::uint32_t object = watertight.source
                               ? scene->AddSource(*watertight.source, watertight.maxTriangles)
                               : scene->AddMesh(watertight.mesh, watertight.maxTriangles);
    for (std::size_t level = watertight.transforms.size(); level-- > 0;) {
        *world = watertight.transforms[level] * *world;
        const std::vector<AccelPlacement> placed = {{object, watertight.transforms[level], 0}};
        if (level == 0) {
            scene->SetRoot(placed);
        } else {
            object = scene->AddGroup(placed);
        }
    }
}

} // namespace

std::vector<WatertightCase> MakeWatertightCases() {
    const glm::dmat4 one(1.0);
    const glm::dmat4 turned = glm::rotate(one, 0.7, glm::dvec3(1.0, 2.0, 3.0));
    const glm::dmat4 stretched = turned * glm::scale(one, glm::dvec3(0.05, 3.0, 40.0)) *
                                 glm::rotate(one, 0.3, glm::dvec3(1, 0, 1));
    const glm::dmat4 far = glm::translate(one, glm::dvec3(1e6, -2e6, 3e6)) * turned *
                           glm::scale(one, glm::dvec3(100.0));
    const glm::dmat4 tiny =
        glm::translate(one, glm::dvec3(0.1, 0.2, -0.3)) * glm::scale(one, glm::dvec3(1e-4));
    const glm::dmat4 mirrored = glm::scale(turned, glm::dvec3(-1.0, 1.0, 1.0));
    const TriangleMesh smooth = BumpySphere(48, 0.0F);
    const TriangleMesh bumpy = BumpySphere(120, 0.05F);
    std::vector<WatertightCase> cases = {
        {"sphere", smooth, 0.9F, 700, {one}, nullptr},
        {"bumpy sphere, rotated", bumpy, 0.8F, 700, {turned}, nullptr},
        {"bumpy sphere, stretched", bumpy, 0.8F, 700, {stretched}, nullptr},
        {"bumpy sphere, far away", bumpy, 0.8F, 700, {far}, nullptr},
        {"bumpy sphere, tiny", bumpy, 0.8F, 700, {tiny}, nullptr},
        {"bumpy sphere, mirrored, one chunk", bumpy, 0.8F, 1000000, {mirrored}, nullptr},
        {"bumpy sphere, nested", bumpy, 0.8F, 700, {turned, mirrored, turned}, nullptr},
        {"box", Box(1.0F), 0.9F, 700, {one}, nullptr},
        {"box, stretched", Box(1.0F), 0.9F, 700, {stretched}, nullptr},
        {"needle sphere",
         Scaled(smooth, glm::vec3(1.0F, 1.0F, 1e4F), glm::vec3(0.0F)),
         0.9F,
         700,
         {turned},
         nullptr},
    };
    for (const char* scheme : {"catmullClark", "loop"}) {
        WatertightCase diced;
        diced.name = std::string("displaced and creased, ") + scheme;
        diced.source = MakeDicedSource(scheme);
        diced.mesh = GatherMesh(*diced.source);
        diced.innerRadius = 0.8F;
        diced.maxTriangles = 200;
        diced.transforms = {turned};
        cases.push_back(diced);
    }
    return cases;
}

LeakCounter::LeakCounter(std::shared_ptr<Device> device, AccelForm form)
    : _device(std::move(device)), _form(form) {
    const std::string text = kKernel;
    const auto build = [&](const char* groups) {
        ProgramDefines defines = {{"HDS_FEATURE_GROUPS", groups},
                                  {"HDS_FEATURE_MOTION", "0"},
                                  {"HDS_NUM_POOLS", "1"}};
        defines.merge(DefinesOf(form));
        return std::make_unique<Program>(_device, "watertight.cl", defines, nullptr, &text);
    };
    _plainProgram = build("0");
    _nestedProgram = build("1");
}

std::uint64_t LeakCounter::Count(const WatertightCase& watertight, std::uint64_t numRays) {
    AccelScene scene;
    glm::dmat4 world(1.0);
    BuildScene(watertight, &scene, &world);
    const DeviceAccelScene onDevice(_device, scene);
    std::vector<float> rows(12);
    for (int i = 0; i < 12; ++i) {
        rows[static_cast<std::size_t>(i)] = static_cast<float>(world[i % 4][i / 4]);
    }
    const Buffer positions = UploadVector(_device, "positions", watertight.mesh.positions);
    const Buffer triangles = UploadVector(_device, "triangles", watertight.mesh.triangles);
    const Buffer transform = UploadVector(_device, "transform", rows);
    Buffer leaks(_device, "leaks", sizeof(std::uint32_t));
    leaks.Fill(0, sizeof(std::uint32_t));
    const bool isNested = watertight.transforms.size() > 1;
    Kernel kernel = (isNested ? _nestedProgram : _plainProgram)->GetKernel("leak_count");
    const auto numTriangles = static_cast<std::uint32_t>(watertight.mesh.triangles.size());
    kernel.SetBuffer(2, positions);
    kernel.SetBuffer(3, triangles);
    kernel.SetBytes(4, &numTriangles, sizeof(numTriangles));
    kernel.SetBuffer(5, transform);
    kernel.SetBytes(6, &watertight.innerRadius, sizeof(float));
    kernel.SetBuffer(7, leaks);
    onDevice.Bind(&kernel, 8, false, _form == AccelForm::Flat);
    std::uint32_t seed = 1;
    for (std::uint64_t done = 0; done < numRays; done += kRaysPerLaunch, ++seed) {
        const auto count =
            static_cast<std::uint32_t>(std::min<std::uint64_t>(kRaysPerLaunch, numRays - done));
        kernel.SetBytes(0, &seed, sizeof(seed));
        kernel.SetBytes(1, &count, sizeof(count));
        kernel.Enqueue(count);
    }
    _device->Finish();
    std::uint32_t numLeaks = 0;
    leaks.Read(&numLeaks, sizeof(numLeaks));
    return numLeaks;
}

} // namespace hds::test
