// SPDX-License-Identifier: Apache-2.0
// Interactive figures of render delegates on one scene of many meshes, in one run: the time to sync
// the whole scene, and the latency from an edit of each kind to the first pixel of the render that
// it starts: on the clock, and in CPU time of the process, which other work disturbs less.
//   benchHydra [--meshes N] [--quads N] [--repeats N] [--width N] [--edit NAME] [RENDERER...]
// RENDERERs are plug-in ids; ratios are to the last one. Prints tables in Markdown. With an edit's
// name ("transform edit") that one alone, as profilers want it.
#include "testenv/hydra/host.h"

#include <pxr/base/gf/rotation.h>
#include <pxr/base/work/threadLimits.h>
#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/light.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <limits>
#include <thread>

using namespace hydraHost;

namespace {

struct Options {
    int numMeshes = 5184;
    int numQuads = 16; ///< along each side of a mesh
    int numRepeats = 5;
    int width = 320;
    std::string edit; ///< the only one; empty: all, and Sync
    std::vector<TfToken> renderers;
};

const SdfPath kCamera("/camera");
constexpr int kNumSamples = 4;
constexpr const char* kUnderWay = "light edit, render under way";

SdfPath MeshPath(int index) {
    return SdfPath("/wall/mesh" + std::to_string(index));
}

/// Wavy patches side by side before the camera; each has points, st and a colour of its own.
SceneData MakeWall(const Options& options) {
    SceneData scene;
    scene.cameras[kCamera] = MakeCamera(GfVec3d(0.0, 0.0, 5.0));
    scene.lights[SdfPath("/dome")] = MakeDome(GfVec3f(1.0F));
    constexpr int kNumMaterials = 100;
    for (int i = 0; i < kNumMaterials; ++i) {
        scene.materials[SdfPath("/materials/m" + std::to_string(i))] =
            MakeMaterial(GfVec3f(0.2F + 0.006F * float(i), 0.5F, 0.8F - 0.006F * float(i)));
    }
    const int side = int(std::ceil(std::sqrt(double(options.numMeshes))));
    for (int i = 0; i < options.numMeshes; ++i) {
        GprimData patch =
            MakeGrid(2.4F / float(side), 1.8F / float(side), options.numQuads, options.numQuads);
        VtVec3fArray points = patch.FindPrimvar(HdTokens->points)->value.Get<VtVec3fArray>();
        VtVec2fArray st;
        for (GfVec3f& point : points) {
            point[2] = 0.02F * std::sin(200.0F * point[0] + float(i)) * std::cos(170.0F * point[1]);
            st.push_back(GfVec2f(point[0], point[1]));
        }
        patch.SetPrimvar("points", HdInterpolationVertex, VtValue(points),
                         HdPrimvarRoleTokens->point);
        patch.SetPrimvar("st", HdInterpolationVertex, VtValue(st),
                         HdPrimvarRoleTokens->textureCoordinate);
        patch.transform = Translation(4.8 * (i % side + 0.5) / side - 2.4,
                                      3.6 * (i / side + 0.5) / side - 1.8, 0.0);
        patch.material = SdfPath("/materials/m" + std::to_string(i % kNumMaterials));
        scene.gprims[MeshPath(i)] = patch;
    }
    return scene;
}

HostOptions MakeHostOptions(const Options& options, const TfToken& renderer) {
    HostOptions host;
    host.renderer = renderer;
    host.width = options.width;
    host.height = options.width * 3 / 4;
    AovRequest color{HdAovTokens->color};
    color.clearValue = VtValue(GfVec4f(0.0F));
    host.aovs = {color};
    host.settings[TfToken("samples")] = VtValue(kNumSamples);
    host.settings[TfToken("subdivision")] = VtValue(std::string("cage"));
    host.settings[HdRenderSettingsTokens->convergedSamplesPerPixel] = VtValue(kNumSamples);
    return host;
}

double Now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// Seconds of all threads.
double CpuNow() {
    return double(std::clock()) / CLOCKS_PER_SEC;
}

/// An edit that is not shown counts as one that takes for ever. \return infinity when most are not.
double Median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

/// Milliseconds of all samples, by figure and renderer.
using Samples = std::map<std::string, std::map<TfToken, std::vector<double>>>;

/// Sync and commit of everything that is dirty, without the execution of the task.
double TimeSync(Host& host) {
    HdTaskSharedPtr task(&host.Task(), [](HdTask*) {});
    HdTaskSharedPtrVector tasks{task};
    HdTaskContext context;
    const double start = Now();
    host.Index().SyncAll(&tasks, &context);
    task->Prepare(&context, &host.Index());
    host.Delegate().CommitResources(&host.Index().GetChangeTracker());
    return (Now() - start) * 1e3;
}

void MeasureSync(const SceneData& scene, const Options& options, Samples* samples) {
    for (const TfToken& renderer : options.renderers) {
        Host host(scene, MakeHostOptions(options, renderer));
        (*samples)["sync, new scene"][renderer].push_back(TimeSync(host));
        host.Index().GetChangeTracker().MarkAllRprimsDirty(HdChangeTracker::AllDirty);
        (*samples)["sync, all dirty"][renderer].push_back(TimeSync(host));
        host.Index().GetChangeTracker().MarkAllRprimsDirty(HdChangeTracker::DirtyTransform);
        (*samples)["sync, all transforms"][renderer].push_back(TimeSync(host));
    }
}

/// True when a pixel differs from before and is not just cleared.
bool ShowsEdit(const Image& image, const Image& before) {
    const size_t pixelBytes = HdDataSizeOfFormat(image.format);
    const std::vector<std::uint8_t> clear(pixelBytes, 0);
    for (size_t at = 0; at < image.bytes.size(); at += pixelBytes) {
        if (std::memcmp(&image.bytes[at], &before.bytes[at], pixelBytes) != 0 &&
            std::memcmp(&image.bytes[at], clear.data(), pixelBytes) != 0) {
            return true;
        }
    }
    return false;
}

/// One kind of edit: what the repeat of that number changes.
using Edit = std::function<void(Host&, int repeat)>;

GprimData Mesh(Host& host, int index) {
    return host.Scene().Data().gprims.at(MeshPath(index));
}

/// Of one prim each, but for the settings.
std::map<std::string, Edit> Edits(const Options& options) {
    const int middle = options.numMeshes / 2;
    std::map<std::string, Edit> edits;
    edits["camera edit"] = [](Host& host, int) {
        CameraData camera = host.Scene().Data().cameras.at(kCamera);
        camera.transform = camera.transform * Translation(0.05, 0.02, -0.05);
        host.Scene().SetCamera(kCamera, camera, HdCamera::DirtyTransform);
    };
    edits["transform edit"] = [=](Host& host, int repeat) {
        const int index = (middle + repeat) % options.numMeshes;
        GprimData gprim = Mesh(host, index);
        gprim.transform = gprim.transform *
                          GfMatrix4d(1.0).SetRotate(GfRotation(GfVec3d(0, 1, 0), 3.0)) *
                          Translation(0.0, 0.3, 0.5);
        host.Scene().SetGprim(MeshPath(index), gprim, HdChangeTracker::DirtyTransform);
    };
    edits["visibility edit"] = [=](Host& host, int repeat) {
        const int index = middle / 2 + repeat / 2 % (options.numMeshes - middle / 2);
        GprimData gprim = Mesh(host, index);
        gprim.isVisible = !gprim.isVisible;
        host.Scene().SetGprim(MeshPath(index), gprim, HdChangeTracker::DirtyVisibility);
    };
    edits["points edit"] = [=](Host& host, int repeat) {
        const int index = (middle + repeat) % options.numMeshes;
        GprimData gprim = Mesh(host, index);
        VtVec3fArray points = gprim.FindPrimvar(HdTokens->points)->value.Get<VtVec3fArray>();
        for (GfVec3f& point : points) {
            point[2] += 0.05F * std::sin(40.0F * point[0] + float(repeat));
        }
        gprim.SetPrimvar("points", HdInterpolationVertex, VtValue(points),
                         HdPrimvarRoleTokens->point);
        host.Scene().SetGprim(MeshPath(index), gprim, HdChangeTracker::DirtyPoints);
    };
    edits["material edit"] = [](Host& host, int repeat) {
        host.Scene().SetMaterial(SdfPath("/materials/m7"),
                                 MakeMaterial(GfVec3f(0.9F, 0.1F * float(repeat % 9), 0.1F)));
    };
    edits["light edit"] = [](Host& host, int repeat) {
        host.Scene().SetLight(SdfPath("/dome"),
                              MakeDome(GfVec3f(1.0F, 0.9F - 0.1F * float(repeat % 9), 0.8F)),
                              HdLight::DirtyParams);
    };
    edits["settings edit"] = [](Host& host, int repeat) {
        host.SetSetting(HdRenderSettingsTokens->convergedSamplesPerPixel.GetText(),
                        VtValue(kNumSamples + 1 + repeat % 2));
    };
    return edits;
}

/// Milliseconds on the clock, and of the CPU.
struct Latency {
    double wall;
    double cpu;
};

/// From an edit of a converged image to the first frame whose buffer shows it, as an application
/// that redraws as fast as it can sees it. \return infinity when the renderer does not show it.
Latency TimeEdit(Host& host, const std::function<void(Host&)>& edit) {
    host.RenderUntilConverged();
    const Image before = host.Read();
    constexpr double kSecondsToShow = 5.0;
    const double start = Now();
    const double cpuStart = CpuNow();
    edit(host);
    while (Now() - start < kSecondsToShow) {
        host.Frame();
        // An application draws the frame now; without a rest the loop would take the renderer's
        // CPU.
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (ShowsEdit(host.Read(), before)) {
            return {(Now() - start) * 1e3, (CpuNow() - cpuStart) * 1e3};
        }
    }
    constexpr double kForEver = std::numeric_limits<double>::infinity();
    return {kForEver, kForEver};
}

bool IsRed(const Image& image) {
    double red = 0.0;
    double blue = 0.0;
    for (int i = 0; i < image.width * image.height; ++i) {
        red += image.Float(i % image.width, i / image.width, 0);
        blue += image.Float(i % image.width, i / image.width, 2);
    }
    return red > blue;
}

/// From an edit of a render that is under way to the first frame that shows it: of the light's
/// colour, since pictures change without an edit, too.
Latency TimeEditUnderWay(Host& host, bool toRed) {
    constexpr double kSecondsUnderWay = 0.4;
    constexpr double kSecondsToShow = 5.0;
    const double begin = Now();
    while (Now() - begin < kSecondsUnderWay) {
        host.Frame();
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    const double start = Now();
    const double cpuStart = CpuNow();
    host.Scene().SetLight(
        SdfPath("/dome"),
        MakeDome(toRed ? GfVec3f(1.0F, 0.05F, 0.05F) : GfVec3f(0.05F, 0.05F, 1.0F)),
        HdLight::DirtyParams);
    while (Now() - start < kSecondsToShow) {
        host.Frame();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (IsRed(host.Read()) == toRed) {
            return {(Now() - start) * 1e3, (CpuNow() - cpuStart) * 1e3};
        }
    }
    constexpr double kForEver = std::numeric_limits<double>::infinity();
    return {kForEver, kForEver};
}

void MeasureEditsUnderWay(Host& host, const TfToken& renderer, const Options& options,
                          Samples* samples) {
    constexpr int kManySamples = 100000;
    if (!options.edit.empty() && options.edit != kUnderWay) {
        return;
    }
    host.SetSetting(HdRenderSettingsTokens->convergedSamplesPerPixel.GetText(),
                    VtValue(kManySamples));
    TimeEditUnderWay(host, true); // from the colour of before
    for (int repeat = 0; repeat < options.numRepeats; ++repeat) {
        const Latency latency = TimeEditUnderWay(host, repeat % 2 != 0);
        (*samples)[kUnderWay][renderer].push_back(latency.wall);
        (*samples)[std::string(kUnderWay) + ", CPU"][renderer].push_back(latency.cpu);
    }
}

void MeasureEdits(const SceneData& scene, const Options& options, Samples* samples) {
    for (const TfToken& renderer : options.renderers) {
        Host host(scene, MakeHostOptions(options, renderer));
        const double start = Now();
        host.FrameUntil([&host] {
            const Image image = host.Read();
            return std::any_of(image.bytes.begin(), image.bytes.end(),
                               [](auto byte) { return byte != 0; });
        });
        (*samples)["first pixel of all"][renderer].push_back((Now() - start) * 1e3);
        for (const auto& [figure, edit] : Edits(options)) {
            if (!options.edit.empty() && figure != options.edit) {
                continue;
            }
            for (int repeat = 0; repeat < options.numRepeats; ++repeat) {
                const Latency latency =
                    TimeEdit(host, [&, &apply = edit](Host& edited) { apply(edited, repeat); });
                (*samples)[figure][renderer].push_back(latency.wall);
                (*samples)[figure + ", CPU"][renderer].push_back(latency.cpu);
                if (std::isinf(latency.wall) && repeat == 0) {
                    break; // it never shows such edits
                }
            }
        }
        MeasureEditsUnderWay(host, renderer, options, samples);
    }
}

void Print(const Samples& samples, const Options& options) {
    std::printf("\n| median ms, %d meshes of %d quads |", options.numMeshes,
                options.numQuads * options.numQuads);
    for (const TfToken& renderer : options.renderers) {
        std::printf(" %s |", renderer.GetText());
    }
    std::printf(" ratio to the last |\n|---|");
    for (size_t i = 0; i <= options.renderers.size(); ++i) {
        std::printf("---|");
    }
    std::printf("\n");
    for (const auto& [figure, byRenderer] : samples) {
        std::printf("| %s |", figure.c_str());
        for (const TfToken& renderer : options.renderers) {
            const double median = Median(byRenderer.at(renderer));
            std::isinf(median) ? std::printf(" not shown |") : std::printf(" %.1f |", median);
        }
        const double reference = Median(byRenderer.at(options.renderers.back()));
        const double ratio = Median(byRenderer.at(options.renderers.front())) / reference;
        std::isinf(reference) || std::isinf(ratio) ? std::printf(" |\n")
                                                   : std::printf(" %.2f |\n", ratio);
    }
}

Options ReadOptions(int argc, char** argv) {
    Options options;
    const std::map<std::string, int*> numbers{{"--meshes", &options.numMeshes},
                                              {"--quads", &options.numQuads},
                                              {"--repeats", &options.numRepeats},
                                              {"--width", &options.width}};
    for (int i = 1; i < argc; ++i) {
        const auto number = numbers.find(argv[i]);
        if (number != numbers.end() && i + 1 < argc) {
            *number->second = std::atoi(argv[++i]);
        } else if (std::strcmp(argv[i], "--edit") == 0 && i + 1 < argc) {
            options.edit = argv[++i];
        } else {
            options.renderers.emplace_back(argv[i]);
        }
    }
    if (options.renderers.empty()) {
        options.renderers = {RendererId(), TfToken("HdEmbreeRendererPlugin")};
    }
    return options;
}

} // namespace

int main(int argc, char** argv) {
    const Options options = ReadOptions(argc, argv);
    for (const TfToken& renderer : options.renderers) {
        if (!HasRenderer(renderer)) {
            std::fprintf(stderr, "no renderer plug-in %s\n", renderer.GetText());
            return 1;
        }
    }
    const SceneData scene = MakeWall(options);
    std::printf("%d meshes of %d quads, %u threads, image width %d, %d repeats\n",
                options.numMeshes, options.numQuads * options.numQuads, WorkGetConcurrencyLimit(),
                options.width, options.numRepeats);
    Samples samples;
    for (int repeat = 0; repeat < options.numRepeats && options.edit.empty(); ++repeat) {
        MeasureSync(scene, options, &samples);
    }
    MeasureEdits(scene, options, &samples);
    Print(samples, options);
    return 0;
}
