// SPDX-License-Identifier: Apache-2.0
// Traversal against Embree (issue 2, "what must be shown" 5): Mrays/s of both kernel forms and of
// Embree, bytes a triangle, build speed; hits are compared while timing.
// Usage: benchTraversal [--rays N] [--repeat N] [--triangles N] [--scene sphere|foliage|instances]
//                       [--threads N] [--stage FILE]    (FILE as traversalStage.py writes it)
//        benchTraversal --watertight N    (leaks of N rays through closed meshes, must be 0)
// Prints one table row a measurement. Figures of one thread are CPU seconds, so that other
// processes disturb less; those of more are wall time.
#include "testenv/bench/traversalEmbree.h"
#include "testenv/support/accelScene.h"
#include "testenv/support/traversalMeshes.h"
#include "testenv/support/watertight.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

namespace hds::bench {
namespace {

const char* const kKernels = R"(
#include "accel/traverse.clh"
HdsTraversalRay bench_load(global const float* rays, uint i) {
    HdsTraversalRay ray;
    ray.origin = vload3(0, rays + 8u * i);
    ray.tMin = rays[8u * i + 3u];
    ray.direction = vload3(0, rays + 8u * i + 4u);
    ray.tMax = rays[8u * i + 7u];
    return ray;
}
kernel void bench_closest(global const float* rays, uint count, global HdsHit* hits,
                          HDS_GEOMETRY_ARGS) {
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    HDS_GEOMETRY_VIEW(view);
    HdsHit hit;
    traverse_closest(&view, bench_load(rays, i), 0u, &hit);
    hits[i] = hit;
}
kernel void bench_occluded(global const float* rays, uint count, global uint* results,
                           HDS_GEOMETRY_ARGS) {
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    HDS_GEOMETRY_VIEW(view);
    results[i] = traverse_occluded(&view, bench_load(rays, i)) ? 1u : 0u;
}
)";

struct Options {
    std::size_t numRays = 1U << 20U;
    std::size_t numTriangles = 1000000;
    int repeat = 3;
    int numThreads = 1;
    std::string scene;
    std::string stage;
    std::uint64_t watertightRays = 0;
};

struct BenchScene {
    std::string name;
    std::vector<TriangleMesh> meshes;
    glm::vec3 eye;
    std::vector<BenchPlacement> placements = {}; ///< none: each mesh once, as it is
    glm::vec3 forward = {0.0F, 1.0F, -0.2F};
    glm::vec3 right = {0.7F, 0.0F, 0.0F}; ///< from the middle of the view to its border
    glm::vec3 up = {0.0F, 0.0F, 0.7F};
    float reach = 1.0F; ///< t at which any-hit rays end; 0: the median of the primary hits

    std::size_t NumTriangles() const {
        std::size_t count = 0;
        for (const TriangleMesh& mesh : meshes) {
            count += mesh.triangles.size();
        }
        return count;
    }
    BenchPlacement Placement(std::size_t i) const {
        return placements.empty() ? BenchPlacement{static_cast<std::uint32_t>(i)} : placements[i];
    }
};

BenchScene SphereScene(std::size_t numTriangles) {
    const auto rows =
        static_cast<std::uint32_t>(std::sqrt(static_cast<double>(numTriangles) / 4.0));
    return {"sphere", {test::BumpySphere(rows + 1), test::Box(2.5F)}, {0.0F, -1.9F, 0.4F}};
}

BenchScene FoliageScene(std::size_t numTriangles) {
    return {"foliage",
            {test::Foliage(static_cast<std::uint32_t>(numTriangles / 2), 5), test::Box(2.5F)},
            {0.0F, -1.9F, 0.4F}};
}

/// A thousand turned and scaled instances of five bushes in a box, which overlap.
BenchScene InstancesScene(std::size_t numTriangles) {
    constexpr std::size_t kNumMeshes = 5;
    constexpr std::size_t kNumInstances = 1000;
    BenchScene scene{"instances", {}, {0.0F, -1.9F, 0.4F}};
    for (std::size_t i = 0; i < kNumMeshes; ++i) {
        scene.meshes.push_back(test::Foliage(
            static_cast<std::uint32_t>(numTriangles / (2 * kNumMeshes)), unsigned(5 + i)));
    }
    scene.meshes.push_back(test::Box(2.5F));
    std::mt19937 random(3);
    const auto uniform = [&random] { return static_cast<float>(random() >> 8U) * 0x1p-24F; };
    for (std::size_t i = 0; i < kNumInstances; ++i) {
        const float angle = 6.2831853F * uniform();
        const float scale = 0.06F + 0.08F * uniform();
        const glm::vec4 place(4.0F * uniform() - 2.0F, 4.0F * uniform() - 2.0F,
                              2.0F * uniform() - 1.5F, 1.0F);
        const glm::mat4 matrix(glm::vec4(std::cos(angle), std::sin(angle), 0.0F, 0.0F) * scale,
                               glm::vec4(-std::sin(angle), std::cos(angle), 0.0F, 0.0F) * scale,
                               glm::vec4(0.0F, 0.0F, scale, 0.0F), place);
        scene.placements.push_back({static_cast<std::uint32_t>(i % kNumMeshes), matrix});
    }
    scene.placements.push_back({kNumMeshes, glm::mat4(1.0F)});
    return scene;
}

/// A stage from a file that traversalStage.py has written.
BenchScene StageScene(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    file.exceptions(std::ios::badbit | std::ios::eofbit | std::ios::failbit);
    const auto read = [&file](void* to, std::size_t bytes) {
        file.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes));
    };
    glm::vec3 frame[4];
    std::uint32_t numMeshes = 0;
    read(frame, sizeof(frame));
    read(&numMeshes, sizeof(numMeshes));
    BenchScene scene{std::filesystem::path(path).stem().string(), {}, frame[0]};
    scene.forward = frame[1];
    scene.right = frame[2];
    scene.up = frame[3];
    for (std::uint32_t i = 0; i < numMeshes; ++i) {
        std::uint32_t counts[2];
        read(counts, sizeof(counts));
        TriangleMesh mesh;
        mesh.positions.resize(counts[0]);
        mesh.triangles.resize(counts[1]);
        read(mesh.positions.data(), counts[0] * sizeof(glm::vec3));
        read(mesh.triangles.data(), counts[1] * sizeof(glm::uvec3));
        scene.meshes.push_back(std::move(mesh));
    }
    scene.reach = 0.0F;
    return scene;
}

std::vector<BenchRay> PrimaryRays(const BenchScene& scene, std::size_t count) {
    const auto side = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(count)));
    std::vector<BenchRay> rays;
    rays.reserve(std::size_t{side} * side);
    for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
            const float u = (static_cast<float>(x) + 0.5F) / static_cast<float>(side) * 2.0F - 1.0F;
            const float v = (static_cast<float>(y) + 0.5F) / static_cast<float>(side) * 2.0F - 1.0F;
            const glm::vec3 direction = scene.forward + u * scene.right - v * scene.up;
            rays.push_back({{scene.eye.x, scene.eye.y, scene.eye.z},
                            0.0F,
                            {direction.x, direction.y, direction.z},
                            INFINITY});
        }
    }
    return rays;
}

/// Cosine-distributed rays from the primary hits, on the side the primary ray came from.
std::vector<BenchRay> DiffuseRays(const BenchScene& scene, const std::vector<BenchRay>& primary,
                                  const std::vector<EmbreeHit>& hits) {
    std::mt19937 random(11);
    const auto uniform = [&random] { return static_cast<float>(random() >> 8U) * 0x1p-24F; };
    std::vector<BenchRay> rays;
    for (std::size_t i = 0; i < primary.size(); ++i) {
        if (hits[i].mesh == 0xffffffffU) {
            continue;
        }
        const BenchPlacement placement = scene.Placement(hits[i].mesh);
        const TriangleMesh& mesh = scene.meshes[placement.mesh];
        const glm::uvec3& t = mesh.triangles[hits[i].triangle];
        const glm::mat3 turn(placement.worldFromMesh); // scales are uniform
        const glm::vec3 a = turn * (mesh.positions[t.y] - mesh.positions[t.x]);
        const glm::vec3 b = turn * (mesh.positions[t.z] - mesh.positions[t.x]);
        glm::vec3 n(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
        n /= std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
        const float* d = primary[i].direction;
        if (n.x * d[0] + n.y * d[1] + n.z * d[2] > 0.0F) {
            n = -n;
        }
        // A point on the unit sphere around the normal's tip.
        const float z = 2.0F * uniform() - 1.0F;
        const float phi = 6.2831853F * uniform();
        const float r = std::sqrt(std::max(0.0F, 1.0F - z * z));
        const glm::vec3 direction = n + glm::vec3(r * std::cos(phi), r * std::sin(phi), z) * 0.999F;
        const float* o = primary[i].origin;
        BenchRay ray{};
        for (int axis = 0; axis < 3; ++axis) {
            ray.origin[axis] = o[axis] + hits[i].t * d[axis] + 1e-4F * n[axis];
            ray.direction[axis] = direction[axis];
        }
        ray.tMax = INFINITY;
        rays.push_back(ray);
    }
    return rays;
}

float MedianDistance(const std::vector<EmbreeHit>& hits) {
    std::vector<float> distances;
    for (const EmbreeHit& hit : hits) {
        distances.push_back(hit.t);
    }
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return *middle;
}

double Seconds(const Options& options) {
    return options.numThreads == 1
               ? ProcessSeconds()
               : std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
                     .count();
}

/// Best rate of several runs of `run`, in million rays a second.
template <typename Run>
double MeasureMrays(std::size_t numRays, const Options& options, const Run& run) {
    double best = 1e30;
    for (int i = 0; i < options.repeat; ++i) {
        const double start = Seconds(options);
        run();
        best = std::min(best, Seconds(options) - start);
    }
    return static_cast<double>(numRays) / best * 1e-6;
}

/// Our kernels on a device.
class OurScene {
public:
    OurScene(const std::shared_ptr<Device>& device, const test::AccelScene& scene,
             test::AccelForm form)
        : _device(device), _isFlat(form == test::AccelForm::Flat),
          _scene(device, scene, {1, {}, {_isFlat ? ~0ULL : 0, 4.0, 0.0}}) {
        const std::string text = kKernels;
        ProgramDefines defines = {{"HDS_FEATURE_GROUPS", "0"}, {"HDS_FEATURE_CUTOUT", "0"},
                                  {"HDS_FEATURE_MOTION", "0"}, {"HDS_FEATURE_CURVES", "0"},
                                  {"HDS_FEATURE_SPLATS", "0"}, // they need curves
                                  {"HDS_NUM_POOLS", "1"}};
        if (!_scene.Flat().hasInstances) {
            defines["HDS_FEATURE_FLAT_INSTANCES"] = "0";
        }
        if (_scene.Flat().numCopies == 0) {
            defines["HDS_FEATURE_FLAT_COPIES"] = "0";
        }
        defines.merge(test::DefinesOf(form));
        _program = std::make_unique<Program>(device, "bench.cl", defines, nullptr, &text);
    }
    const FlatBvh& Flat() const { return _scene.Flat(); }

    template <typename Result>
    std::vector<Result> Run(const char* name, const std::vector<BenchRay>& rays,
                            const Options& options, double* mrays) {
        const Buffer input = UploadVector(_device, "rays", rays);
        const Buffer output(_device, "results", rays.size() * sizeof(Result));
        const auto count = static_cast<std::uint32_t>(rays.size());
        Kernel kernel = _program->GetKernel(name);
        kernel.SetBuffer(0, input);
        kernel.SetBytes(1, &count, sizeof(count));
        kernel.SetBuffer(2, output);
        _scene.Bind(&kernel, 3, false, _isFlat);
        kernel.Enqueue(rays.size());
        _device->Finish();
        *mrays = MeasureMrays(rays.size(), options, [&] {
            kernel.Enqueue(rays.size());
            _device->Finish();
        });
        std::vector<Result> results(rays.size());
        output.Read(results.data(), results.size() * sizeof(Result));
        return results;
    }

private:
    std::shared_ptr<Device> _device;
    bool _isFlat;
    test::DeviceAccelScene _scene;
    std::unique_ptr<Program> _program;
};

/// Rays on which presence or distance differ by more than Embree's own rounding allows.
std::size_t CountDifferences(const std::vector<shared::HdsHit>& ours,
                             const std::vector<EmbreeHit>& theirs) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
        const bool isHit = ours[i].chunk != HDS_NONE;
        const bool isTheirs = theirs[i].mesh != 0xffffffffU;
        const float tolerance = 1e-4F * (1.0F + std::fabs(theirs[i].t));
        count +=
            isHit != isTheirs || (isHit && std::fabs(ours[i].t - theirs[i].t) > tolerance) ? 1 : 0;
    }
    return count;
}

void PrintBytes(const BenchScene& scene, const test::AccelScene& ours, double wallSeconds,
                double cpuSeconds, const EmbreeScene& standard, const EmbreeScene& compact) {
    std::size_t nodes = ours.topNodes.size() * sizeof(shared::HdsBvhNode);
    std::size_t leaves = 0;
    for (const GeometryPage& page : ours.pages) {
        shared::HdsPageHeader header{};
        std::memcpy(&header, page.bytes.data(), sizeof(header));
        nodes += page.numNodes * sizeof(shared::HdsBvhNode);
        leaves += header.numTriangles * (sizeof(shared::HdsTriangle) + sizeof(std::uint32_t));
    }
    const auto triangles = static_cast<double>(scene.NumTriangles());
    std::printf("%s: %.0f triangles, %zu chunks\n", scene.name.c_str(), triangles,
                ours.pages.size());
    std::printf("  bytes/triangle    ours nodes %.1f, nodes + leaves %.1f; Embree default %.1f, "
                "compact+robust %.1f\n",
                static_cast<double>(nodes) / triangles,
                static_cast<double>(nodes + leaves) / triangles,
                static_cast<double>(standard.Bytes()) / triangles,
                static_cast<double>(compact.Bytes()) / triangles);
    std::printf("  build             ours %.2f Mtriangles/s wall, %.2f a CPU second (plan, gather, "
                "pages, tops); Embree a CPU second: default %.2f, compact+robust %.2f\n",
                triangles / wallSeconds * 1e-6, triangles / cpuSeconds * 1e-6,
                triangles / standard.BuildSeconds() * 1e-6,
                triangles / compact.BuildSeconds() * 1e-6);
}

void PrintFlat(const test::AccelScene& ours) {
    const double start = ProcessSeconds();
    const FlatBvh flat = BuildFlatBvh(test::FlatSourceOf(ours), {~0ULL, 4.0, 0.0});
    const double seconds = ProcessSeconds() - start;
    const auto triangles = static_cast<double>(std::max<std::uint64_t>(flat.numTriangles, 1));
    std::printf("  flat hierarchy    %.1f bytes a triangle, %.2f Mtriangles a CPU second\n",
                static_cast<double>(flat.buffer.size()) / triangles, triangles / seconds * 1e-6);
}

/// Million rays a second.
struct Rates {
    double flat = 0.0;
    double simd8 = 0.0;
    double scalar = 0.0;
    double standard = 0.0;
    double compact = 0.0;
};

void PrintRow(const char* what, const Rates& rates, std::size_t differences, std::size_t numRays) {
    std::printf(
        "  %-16s  flat %.2f  simd8 %.2f  scalar %.2f  Embree default %.2f  compact+robust %.2f "
        "Mrays/s; flat/default %.2f  flat/compact %.2f  simd8/default %.2f; differing %zu of %zu\n",
        what, rates.flat, rates.simd8, rates.scalar, rates.standard, rates.compact,
        rates.flat / rates.standard, rates.flat / rates.compact, rates.simd8 / rates.standard,
        differences, numRays);
    std::fflush(stdout);
}

void RunScene(const std::shared_ptr<Device>& device, const BenchScene& scene,
              const Options& options) {
    const auto start = std::chrono::steady_clock::now();
    const double cpuStart = ProcessSeconds();
    test::AccelScene ours;
    std::vector<test::AccelPlacement> placements;
    std::vector<std::uint32_t> objects;
    for (const TriangleMesh& mesh : scene.meshes) {
        objects.push_back(ours.AddMesh(mesh));
    }
    const std::size_t numPlacements =
        scene.placements.empty() ? scene.meshes.size() : scene.placements.size();
    for (std::size_t i = 0; i < numPlacements; ++i) {
        const BenchPlacement placement = scene.Placement(i);
        placements.push_back(
            {objects[placement.mesh], glm::dmat4(placement.worldFromMesh), HDS_INSTANCE_SEEN});
    }
    ours.SetRoot(placements);
    const std::chrono::duration<double> buildTime = std::chrono::steady_clock::now() - start;
    const double buildCpuSeconds = ProcessSeconds() - cpuStart;
    const EmbreeScene standard(scene.meshes, scene.placements, false);
    const EmbreeScene compact(scene.meshes, scene.placements, true);
    PrintBytes(scene, ours, buildTime.count(), buildCpuSeconds, standard, compact);

    PrintFlat(ours);
    OurScene flat(device, ours, test::AccelForm::Flat);
    OurScene simd8(device, ours, test::AccelForm::Simd8);
    OurScene scalar(device, ours, test::AccelForm::Scalar);
    const std::vector<BenchRay> primary = PrimaryRays(scene, options.numRays);
    const auto numThreads = static_cast<unsigned>(options.numThreads);
    const std::vector<EmbreeHit> primaryHits = compact.Closest(primary, numThreads);
    const std::vector<BenchRay> diffuse = DiffuseRays(scene, primary, primaryHits);
    const float reach = scene.reach > 0.0F ? scene.reach : MedianDistance(primaryHits);
    for (const bool isPrimary : {true, false}) {
        const std::vector<BenchRay>& rays = isPrimary ? primary : diffuse;
        Rates rates;
        std::vector<EmbreeHit> hits;
        rates.standard =
            MeasureMrays(rays.size(), options, [&] { hits = standard.Closest(rays, numThreads); });
        const auto ourHits =
            simd8.Run<shared::HdsHit>("bench_closest", rays, options, &rates.simd8);
        const auto flatHits = flat.Run<shared::HdsHit>("bench_closest", rays, options, &rates.flat);
        rates.compact =
            MeasureMrays(rays.size(), options, [&] { hits = compact.Closest(rays, numThreads); });
        const auto scalarHits =
            scalar.Run<shared::HdsHit>("bench_closest", rays, options, &rates.scalar);
        const std::size_t bytes = ourHits.size() * sizeof(ourHits[0]);
        if (std::memcmp(ourHits.data(), scalarHits.data(), bytes) != 0 ||
            std::memcmp(ourHits.data(), flatHits.data(), bytes) != 0) {
            std::printf("  THE FORMS DIFFER\n");
        }
        PrintRow(isPrimary ? "primary closest" : "diffuse closest", rates,
                 CountDifferences(ourHits, hits), rays.size());

        std::vector<std::uint8_t> blocked;
        std::vector<BenchRay> finite = rays;
        for (BenchRay& ray : finite) {
            ray.tMax = reach;
        }
        rates.standard = MeasureMrays(rays.size(), options,
                                      [&] { blocked = standard.Occluded(finite, numThreads); });
        rates.compact = MeasureMrays(rays.size(), options,
                                     [&] { blocked = compact.Occluded(finite, numThreads); });
        const auto ourBlocked =
            simd8.Run<std::uint32_t>("bench_occluded", finite, options, &rates.simd8);
        if (flat.Run<std::uint32_t>("bench_occluded", finite, options, &rates.flat) != ourBlocked) {
            std::printf("  THE FORMS DIFFER\n");
        }
        scalar.Run<std::uint32_t>("bench_occluded", finite, options, &rates.scalar);
        std::size_t differences = 0;
        for (std::size_t i = 0; i < blocked.size(); ++i) {
            differences += (ourBlocked[i] != 0) != (blocked[i] != 0) ? 1 : 0;
        }
        PrintRow(isPrimary ? "primary any hit" : "diffuse any hit", rates, differences,
                 rays.size());
    }
}

/// Shares the rays among the cases and forms. \return leaks.
std::uint64_t RunWatertight(std::uint64_t numRays) {
    const std::shared_ptr<Device> device = Device::Create("");
    const std::vector<test::WatertightCase> cases = test::MakeWatertightCases();
    const std::uint64_t raysPerRun = numRays / (3 * cases.size()) + 1;
    std::uint64_t total = 0;
    for (const test::AccelForm form : test::kAccelForms) {
        test::LeakCounter counter(device, form);
        for (const test::WatertightCase& watertight : cases) {
            const std::uint64_t leaks = counter.Count(watertight, raysPerRun);
            std::printf("%-36s %-4s  %llu rays  %llu leaks\n", watertight.name.c_str(),
                        test::NameOf(form), static_cast<unsigned long long>(raysPerRun),
                        static_cast<unsigned long long>(leaks));
            std::fflush(stdout);
            total += leaks;
        }
    }
    std::printf("leaks in all: %llu\n", static_cast<unsigned long long>(total));
    return total;
}

bool ParseOptions(int argc, char** argv, Options* options) {
    for (int i = 1; i + 1 < argc; i += 2) {
        const std::string name = argv[i];
        const char* value = argv[i + 1];
        if (name == "--rays") {
            options->numRays = std::strtoull(value, nullptr, 10);
        } else if (name == "--repeat") {
            options->repeat = std::atoi(value);
        } else if (name == "--threads") {
            options->numThreads = std::atoi(value);
        } else if (name == "--triangles") {
            options->numTriangles = std::strtoull(value, nullptr, 10);
        } else if (name == "--scene") {
            options->scene = value;
        } else if (name == "--stage") {
            options->stage = value;
        } else if (name == "--watertight") {
            options->watertightRays = std::strtoull(value, nullptr, 10);
        } else {
            return false;
        }
    }
    return argc % 2 == 1 && options->numThreads > 0;
}

int Main(int argc, char** argv) {
    Options options;
    if (!ParseOptions(argc, argv, &options)) {
        std::fprintf(stderr, "usage: benchTraversal [--rays N] [--repeat N] [--triangles N] "
                             "[--scene sphere|foliage|instances] [--threads N] [--stage FILE] | "
                             "--watertight N\n");
        return 2;
    }
    if (options.watertightRays > 0) {
        return RunWatertight(options.watertightRays) == 0 ? 0 : 1;
    }
    // Workers for the kernels; read by PoCL when the device is made.
    setenv("POCL_MAX_PTHREAD_COUNT", std::to_string(options.numThreads).c_str(), 1);
    const std::shared_ptr<Device> device = Device::Create("");
    std::printf("device: %s\n", device->Properties().name.c_str());
    if (!options.stage.empty()) {
        RunScene(device, StageScene(options.stage), options);
        return 0;
    }
    for (const auto& [name, make] :
         {std::pair("sphere", SphereScene), std::pair("foliage", FoliageScene),
          std::pair("instances", InstancesScene)}) {
        if (options.scene.empty() || options.scene == name) {
            RunScene(device, make(options.numTriangles), options);
        }
    }
    return 0;
}

} // namespace
} // namespace hds::bench

int main(int argc, char** argv) {
    return hds::bench::Main(argc, argv);
}
