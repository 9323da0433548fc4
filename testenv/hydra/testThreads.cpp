// SPDX-License-Identifier: Apache-2.0
// Threads and lifetimes: parallel sync, several delegates, deletion at any moment, no growth.
#include "hydraTest.h"

#include <pxr/base/work/threadLimits.h>
#include <pxr/imaging/hd/changeTracker.h>

#include <atomic>
#include <fstream>
#include <thread>

#include <unistd.h>

namespace hydraHost {

namespace {

using Threads = HydraTest;

/// A wall of small meshes that share nothing.
SceneData ManyMeshes(int numX, int numY) {
    SceneData scene = EmptyScene();
    for (int y = 0; y < numY; ++y) {
        for (int x = 0; x < numX; ++x) {
            GprimData quad = MakeGrid(1.6F / float(numX), 1.2F / float(numY));
            quad.transform = Translation(4.0 * (x + 0.5) / numX - 2.0, 3.0 * (y + 0.5) / numY - 1.5,
                                         0.001 * ((x * 7 + y * 3) % 11));
            quad.SetPrimvar("displayColor", HdInterpolationConstant,
                            VtValue(VtVec3fArray(1, GfVec3f(float(x % 5) * 0.2F, 0.5F, 0.3F))),
                            HdPrimvarRoleTokens->color);
            scene.gprims[SdfPath("/wall/mesh" + std::to_string(y * numX + x))] = quad;
        }
    }
    return scene;
}

/// Restores the limit of OpenUSD's worker threads.
class ThreadLimit {
public:
    explicit ThreadLimit(unsigned limit) { WorkSetConcurrencyLimit(limit); }
    ~ThreadLimit() { WorkSetMaximumConcurrencyLimit(); }
};

TEST_F(Threads, ParallelSyncOfManyMeshesHasTheBitsOfASerialOne) {
    const SceneData scene = ManyMeshes(100, 50);
    Image serial;
    {
        const ThreadLimit limit(1);
        Host host(scene, Quick({HdAovTokens->color}, 1));
        serial = host.Render();
    }
    const ThreadLimit limit(16);
    Host host(scene, Quick({HdAovTokens->color}, 1));
    EXPECT_EQ(host.Render(), serial);
    EXPECT_EQ(host.Statistic("geometry.meshes"), 5000.0);
    // All at once again, every bit dirty.
    host.Index().GetChangeTracker().MarkAllRprimsDirty(HdChangeTracker::AllDirty);
    EXPECT_EQ(host.Render(), serial);
}

TEST_F(Threads, DelegatesOnTheirOwnThreadsDoNotDisturbEachOther) {
    Host reference(ThreeMeshes(), Quick({HdAovTokens->color}, 4));
    const Image expected = reference.Render();
    std::vector<std::thread> threads;
    std::atomic<int> numRight{0};
    for (int thread = 0; thread < 2; ++thread) {
        threads.emplace_back([&] {
            for (int round = 0; round < 3; ++round) {
                Host host(ThreeMeshes(), Quick({HdAovTokens->color}, 4));
                numRight += host.Render() == expected;
            }
        });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    EXPECT_EQ(numRight, 6);
}

TEST_F(Threads, DeletionInAnyStateOfARender) {
    for (int numFrames = 0; numFrames < 12; ++numFrames) {
        Host host(ThreeMeshes(), Quick({HdAovTokens->color, HdAovTokens->depth}, 1000000));
        for (int frame = 0; frame < numFrames; ++frame) {
            host.Frame();
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
    }
    // And while another one renders, which must not mind.
    Host survivor(ThreeMeshes(), Quick({HdAovTokens->color}, 32));
    survivor.Frame();
    {
        Host deleted(ThreeMeshes(), Quick({HdAovTokens->color}, 1000000));
        deleted.Frame();
    }
    EXPECT_EQ(survivor.Render(), RenderFresh(survivor, Quick({HdAovTokens->color}, 32)));
}

TEST_F(Threads, DeletionWhilePausedOrStopped) {
    for (const bool isPaused : {true, false}) {
        Host host(ThreeMeshes(), Quick({HdAovTokens->color}, 1000000));
        host.Frame();
        if (isPaused) {
            host.Delegate().Pause();
        } else {
            host.Delegate().Stop(false);
        }
        host.Frame();
    }
}

#if defined(__linux__)
/// Bytes of the process in memory now.
double ResidentBytes() {
    std::ifstream file("/proc/self/statm");
    double pages = 0.0;
    double resident = 0.0;
    file >> pages >> resident;
    return resident * double(sysconf(_SC_PAGESIZE));
}

TEST_F(Threads, CreateEditDeleteLoopsDoNotGrow) {
    // Renderer switches of an application: what a delegate leaves behind adds up. The bound is 1 MB
    // a round, less than the film, the path state and the meshes of one.
    const SceneData scene = ManyMeshes(20, 20);
    const auto round = [&scene](int number) {
        Host host(scene, Quick({HdAovTokens->color}, 1));
        host.Frame();
        for (int edit = 0; edit < 3; ++edit) {
            const SdfPath path("/wall/mesh" + std::to_string((number * 3 + edit) % 400));
            GprimData gprim = host.Scene().Data().gprims.at(path);
            gprim.transform = gprim.transform * Translation(0.0, 0.01, 0.0);
            host.Scene().SetGprim(path, gprim, HdChangeTracker::DirtyTransform);
            host.Frame();
        }
        host.Scene().Remove(SdfPath("/wall/mesh" + std::to_string(number % 400)));
        if (number % 5 == 0) {
            ASSERT_TRUE(host.RenderUntilConverged());
        } else {
            host.Frame();
        }
    };
    for (int number = 0; number < 10; ++number) {
        round(number);
    }
    const double before = ResidentBytes();
    for (int number = 0; number < 50; ++number) {
        round(number);
    }
    const double growth = ResidentBytes() - before;
    RecordProperty("growthBytes", std::to_string(growth));
    EXPECT_LT(growth, 50e6);
}
#endif

} // namespace

} // namespace hydraHost
