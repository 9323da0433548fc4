// SPDX-License-Identifier: Apache-2.0
// Edits while rendering end in the image of the edited scene; control is latched; errors converge.
#include "hdStream/session/renderThread.h"

#include "testenv/support/deviceFixture.h"
#include "testenv/support/sessionScene.h"
#include "testenv/support/temporaryFolder.h"

#include <nlohmann/json.hpp>

#include <chrono>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>

namespace hds::test {
namespace {

constexpr std::chrono::seconds kGuard(120); ///< far beyond any render here

class RenderThreadTest : public DeviceFixture {
protected:
    static void WaitUntilConverged(const RenderThread& thread) {
        const auto end = std::chrono::steady_clock::now() + kGuard;
        while (!thread.IsConverged() && std::chrono::steady_clock::now() < end) {
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        ASSERT_TRUE(thread.IsConverged());
    }
    static std::shared_ptr<const FilmImage> WaitForAnImage(const RenderThread& thread,
                                                           std::uint64_t version) {
        const auto end = std::chrono::steady_clock::now() + kGuard;
        while (std::chrono::steady_clock::now() < end) {
            auto image = thread.Newest();
            if (image && image->version >= version) {
                return image;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        ADD_FAILURE() << "no image of version " << version;
        return nullptr;
    }
    static std::vector<ImageLayer> Direct(const std::function<void(Session&)>& edit) {
        Session session;
        FillSession(&session);
        edit(session);
        session.Render(MakeSettings());
        return session.Layers();
    }
    static RenderThread::Edit MoveBall(double x) {
        return [x](Session& session) {
            GeometryPrim ball = session.Scene().geometry.at("/ball");
            ball.placement.worldFromObject = Move(x, 0.8, 0.0);
            session.SetGeometry("/ball", ball);
        };
    }
    static RenderThread::Edit Fill() {
        return [](Session& session) { FillSession(&session); };
    }
    static Settings LongSettings() {
        Settings settings = MakeSettings();
        settings.samples = 1U << 20U;
        settings.interactive = true;
        return settings;
    }
};

TEST_F(RenderThreadTest, RendersWhatASessionRenders) {
    RenderThread thread;
    thread.Post({Fill()});
    thread.SetSettings(MakeSettings());
    WaitUntilConverged(thread);
    EXPECT_TRUE(SameLayers(thread.Newest()->layers, Direct([](Session&) {})));
    EXPECT_NE(thread.Newest()->statistics.find("\"geometry\""), std::string::npos);
}

TEST_F(RenderThreadTest, EditsWhileRenderingEndInTheEditedImage) {
    RenderThread thread;
    thread.Post({Fill()});
    thread.SetSettings(LongSettings());
    for (int i = 0; i < 40; ++i) {
        thread.Post({MoveBall(0.05 * i)});
        if (i % 3 == 0) {
            std::this_thread::sleep_for(std::chrono::milliseconds(i));
        }
    }
    WaitForAnImage(thread, thread.Version());
    EXPECT_FALSE(thread.IsConverged());
    thread.SetSettings(MakeSettings());
    WaitUntilConverged(thread);
    EXPECT_TRUE(SameLayers(thread.Newest()->layers, Direct(MoveBall(0.05 * 39))));
}

// Edits that come as soon as the first picture of the one before is there: statistics, which such
// pictures do not wait for, follow all the same.
TEST_F(RenderThreadTest, StatisticsFollowEditsThatDoNotPause) {
    RenderThread thread;
    thread.Post({Fill()});
    thread.SetSettings(LongSettings());
    double x = 0.0;
    const auto move = [&] {
        thread.Post({MoveBall(x += 0.001)});
        return WaitForAnImage(thread, thread.Version())->statistics;
    };
    WaitForAnImage(thread, thread.Version());
    const std::string first = move();
    EXPECT_NE(first, "");
    const auto end = std::chrono::steady_clock::now() + kGuard;
    bool isSame = true;
    while (isSame && std::chrono::steady_clock::now() < end) {
        isSame = move() == first;
    }
    EXPECT_FALSE(isSame);
}

TEST_F(RenderThreadTest, EditsAndDeletesWhileRequestsAreInFlight) {
    // A pool of few chunks, so that rays wait all the time; meshes change, go and come back.
    const auto stream = [](Settings settings) {
        settings.residency = "stream";
        settings.geometryMemory = "24K";
        settings.chunkBytes = 4096;
        return settings;
    };
    const auto setBall = [](int size) {
        return [size](Session& session) {
            GeometryPrim ball;
            ball.geometry = MakeGrid(size, 0.4F);
            ball.placement.worldFromObject = Move(-1.5, 0.8, 0.0);
            session.SetGeometry("/ball", ball);
        };
    };
    const RenderThread::Edit remove = [](Session& session) {
        session.Remove("/ball");
        session.Remove("/many/leaf");
    };
    RenderThread thread;
    thread.Post({Fill()});
    thread.SetSettings(stream(LongSettings()));
    for (int i = 0; i < 30; ++i) {
        thread.Post({i % 3 == 1 ? remove : setBall(10 + i)});
        std::this_thread::sleep_for(std::chrono::milliseconds(7 * (i % 5)));
    }
    WaitForAnImage(thread, thread.Version());
    thread.SetSettings(stream(MakeSettings()));
    WaitUntilConverged(thread);
    EXPECT_EQ(thread.Newest()->error, "");
    const auto result = [&](Session& session) {
        remove(session);
        setBall(39)(session);
    };
    EXPECT_TRUE(SameLayers(thread.Newest()->layers, Direct(result)));
}

TEST_F(RenderThreadTest, GeometryBecomesResidentWhileSomeoneLooks) {
    const RenderThread::Edit setGround = [](Session& session) {
        GeometryPrim ground = session.Scene().geometry.at("/ground");
        ground.geometry = MakeGrid(700, 0.1F); // too much to be resident from the start
        session.SetGeometry("/ground", ground);
    };
    const auto whole = [](Settings settings, const char* residency) {
        settings.residency = residency; // with a pool that holds everything
        return settings;
    };
    const auto geometry = [](const RenderThread& thread) {
        return nlohmann::json::parse(thread.Newest()->statistics)["geometry"];
    };
    for (const char* residency : {"auto", "stream"}) {
        SCOPED_TRACE(residency);
        RenderThread thread;
        thread.Post({Fill(), setGround});
        thread.SetSettings(whole(LongSettings(), residency)); // whose samples repay everything
        WaitForAnImage(thread, thread.Version());
        const auto end = std::chrono::steady_clock::now() + kGuard;
        while (geometry(thread)["mode"] == "stream" && std::chrono::steady_clock::now() < end) {
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        EXPECT_EQ(geometry(thread)["mode"], "resident");
        EXPECT_GE(geometry(thread)["streamedSamples"], 1) << "the first picture came before";
        thread.Post({MoveBall(0.3)});
        thread.SetSettings(whole(MakeSettings(), residency));
        WaitUntilConverged(thread);
        EXPECT_EQ(thread.Newest()->error, "");
        EXPECT_EQ(geometry(thread)["mode"], "resident");
        EXPECT_EQ(geometry(thread)["streamedSamples"], 0) << "it stays so";
        EXPECT_TRUE(SameLayers(thread.Newest()->layers, Direct([&](Session& session) {
                                   setGround(session);
                                   MoveBall(0.3)(session);
                               })));
    }
}

TEST_F(RenderThreadTest, EditsThatNeverPauseShowPictures) {
    RenderThread thread;
    thread.Post({Fill()});
    thread.SetSettings(LongSettings());
    WaitForAnImage(thread, 1);
    const std::uint64_t first = thread.Version();
    std::set<std::uint64_t> shown;
    const auto end = std::chrono::steady_clock::now() + kGuard;
    for (int i = 0; shown.size() < 5 && std::chrono::steady_clock::now() < end; ++i) {
        thread.Post({MoveBall(0.001 * i)});
        std::this_thread::sleep_for(std::chrono::microseconds(500));
        const std::uint64_t version = thread.Newest()->version;
        EXPECT_LE(version, thread.Version());
        if (version > first) {
            shown.insert(version);
        }
    }
    EXPECT_EQ(shown.size(), 5U);
}

TEST_F(RenderThreadTest, EqualSettingsDoNotStartAgain) {
    RenderThread thread;
    thread.Post({Fill()});
    const std::uint64_t version = thread.SetSettings(MakeSettings());
    WaitUntilConverged(thread);
    EXPECT_EQ(thread.SetSettings(MakeSettings()), version);
    EXPECT_EQ(thread.Post({}), version);
    EXPECT_TRUE(thread.IsConverged());
}

TEST_F(RenderThreadTest, PauseKeepsTheFilm) {
    RenderThread thread;
    thread.Pause();
    EXPECT_TRUE(thread.IsPaused());
    thread.Post({Fill()});
    thread.SetSettings(MakeSettings());
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_EQ(thread.Newest(), nullptr);
    thread.Resume();
    WaitForAnImage(thread, 1);
    thread.Pause();
    thread.Resume();
    WaitUntilConverged(thread);
    EXPECT_TRUE(SameLayers(thread.Newest()->layers, Direct([](Session&) {})));
}

TEST_F(RenderThreadTest, StopIsLatchedAcrossEdits) {
    RenderThread thread;
    thread.Post({Fill()});
    thread.SetSettings(LongSettings());
    WaitForAnImage(thread, 1);
    thread.Stop(true);
    EXPECT_TRUE(thread.IsStopped());
    EXPECT_TRUE(thread.IsConverged());
    const std::uint64_t shown = thread.Newest()->version;
    const std::uint64_t version = thread.Post({MoveBall(1.0)});
    thread.SetSettings(MakeSettings());
    thread.Call([](Session&) {}); // whatever an edit could have started has been seen by now
    EXPECT_EQ(thread.Newest()->version, shown);
    thread.Restart();
    EXPECT_FALSE(thread.IsStopped());
    WaitForAnImage(thread, version + 1);
    WaitUntilConverged(thread);
    EXPECT_TRUE(SameLayers(thread.Newest()->layers, Direct(MoveBall(1.0))));
}

TEST_F(RenderThreadTest, ErrorsConvergeAndAreNotTheEnd) {
    RenderThread thread;
    thread.Post({Fill()});
    Settings wrong = MakeSettings();
    wrong.camera = "/nowhere";
    thread.SetSettings(wrong);
    WaitUntilConverged(thread);
    EXPECT_NE(thread.Newest()->error.find("/nowhere"), std::string::npos);
    thread.SetSettings(MakeSettings());
    WaitUntilConverged(thread);
    EXPECT_EQ(thread.Newest()->error, "");
    EXPECT_FALSE(thread.Newest()->layers.empty());
}

TEST_F(RenderThreadTest, EditsThatThrowAreWarningsAndTheOthersCount) {
    RenderThread thread;
    thread.Post({Fill(), [](Session&) { throw std::runtime_error("an edit without memory"); },
                 MoveBall(0.5)});
    thread.SetSettings(MakeSettings());
    WaitUntilConverged(thread);
    EXPECT_TRUE(SameLayers(thread.Newest()->layers, Direct(MoveBall(0.5))));
    EXPECT_NE(thread.Newest()->statistics.find("an edit without memory"), std::string::npos);
}

TEST_F(RenderThreadTest, CallRunsBetweenRendersAndRethrows) {
    RenderThread thread;
    thread.Post({Fill()});
    thread.SetSettings(LongSettings());
    std::string dump;
    thread.Call([&](Session& session) { dump = session.Dump(); });
    EXPECT_NE(dump.find("/ground"), std::string::npos);
    EXPECT_THROW(thread.Call([](Session&) { throw Error("no"); }), Error);
    WaitForAnImage(thread, thread.Version()); // it goes on
}

TEST_F(RenderThreadTest, DestructionWhileRendering) {
    for (int i = 0; i < 5; ++i) {
        RenderThread thread;
        thread.Post({Fill()});
        thread.SetSettings(LongSettings());
        std::this_thread::sleep_for(std::chrono::milliseconds(30 * i));
    }
}

TEST_F(RenderThreadTest, TwoAtOnce) {
    RenderThread a;
    RenderThread b;
    a.Post({Fill()});
    b.Post({Fill(), MoveBall(1.0)});
    a.SetSettings(MakeSettings());
    b.SetSettings(MakeSettings());
    WaitUntilConverged(a);
    WaitUntilConverged(b);
    EXPECT_TRUE(SameLayers(a.Newest()->layers, Direct([](Session&) {})));
    EXPECT_TRUE(SameLayers(b.Newest()->layers, Direct(MoveBall(1.0))));
}

TEST_F(RenderThreadTest, WarmingChangesNothing) {
    RenderThread thread;
    thread.Warm(MakeSettings());
    EXPECT_EQ(thread.Version(), 0U);
    thread.Call([](Session& session) { EXPECT_FALSE(session.HasImage()); }); // after it
    thread.Post({Fill()});
    thread.SetSettings(MakeSettings());
    WaitUntilConverged(thread);
    EXPECT_TRUE(thread.Newest()->error.empty()) << thread.Newest()->error;
    const std::vector<ImageLayer> expected = Direct([](Session&) {});
    ASSERT_EQ(thread.Newest()->layers.size(), expected.size());
    EXPECT_EQ(thread.Newest()->layers[0].values, expected[0].values);
}

TEST_F(RenderThreadTest, WarmKernelsAreThoseOfTheRender) {
    const TemporaryFolder cache;
    Settings settings = MakeSettings();
    settings.noCache = false;
    settings.cacheDirectory = cache.Path();
    settings.interactive = true;
    const std::vector<ImageLayer> expected = Direct([](Session&) {});
    for (const bool isFirst : {true, false}) {
        RenderThread thread;
        thread.Warm(settings);
        thread.Post({Fill()});
        thread.SetSettings(settings); // while kernels are loaded, if any are
        WaitUntilConverged(thread);
        const std::shared_ptr<const FilmImage> image = thread.Newest();
        ASSERT_TRUE(image->error.empty()) << image->error;
        EXPECT_EQ(image->layers[0].values, expected[0].values);
        const double seconds =
            nlohmann::json::parse(image->statistics)["time"]["compile"].get<double>();
        EXPECT_EQ(seconds > 0.0, isFirst) << "the render has loaded kernels itself";
    }
}

TEST_F(RenderThreadTest, WhatWarmingMissesIsToldByTheRender) {
    Settings settings = MakeSettings();
    settings.device = "no such device";
    RenderThread thread;
    thread.Warm(settings);
    thread.Call([](Session&) {});
    thread.Post({Fill()});
    thread.SetSettings(settings);
    WaitUntilConverged(thread);
    EXPECT_NE(thread.Newest()->error.find("no such device"), std::string::npos);
    thread.SetSettings(MakeSettings());
    WaitUntilConverged(thread);
    EXPECT_TRUE(thread.Newest()->error.empty()) << thread.Newest()->error;
}

} // namespace
} // namespace hds::test
