// SPDX-License-Identifier: Apache-2.0
// Several processes on one folder, and processes that are killed at any moment.
#include "testenv/unit/persist/pageFixtures.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <memory>
#include <random>

namespace hds {
namespace {

class PageProcessesTest : public PageStoreTest {
protected:
    /// Runs `work` in a child, which ends with 0 if it returns true.
    static pid_t Start(const std::function<bool()>& work) {
        const pid_t child = ::fork();
        if (child == 0) {
            ::_exit(work() ? 0 : 1);
        }
        return child;
    }
    static int StatusOf(pid_t child) {
        int status = 0;
        EXPECT_EQ(::waitpid(child, &status, 0), child);
        return status;
    }
    /// As Has, for children: they have no test to fail.
    static bool IsRight(PageStore* store, std::uint64_t number, std::size_t bytes) {
        std::vector<std::uint8_t> data;
        return store->Load(TestKey(number), &data) && data == TestPage(number, bytes);
    }
    static std::size_t BytesOf(std::uint64_t number) { return 50 + number * 37 % 500; }
};

TEST_F(PageProcessesTest, TwoProcessesSaveTheSameKeysAtOnce) {
    constexpr std::uint64_t kPages = 500;
    std::vector<pid_t> children;
    for (int child = 0; child < 3; ++child) {
        children.push_back(Start([&] {
            PageStore store(Options(512U << 10U), &warnings);
            for (std::uint64_t i = 0; i < kPages; ++i) {
                if (!Save(&store, i, BytesOf(i)) || !IsRight(&store, i, BytesOf(i))) {
                    return false;
                }
            }
            return warnings.Lines().empty();
        }));
    }
    for (const pid_t child : children) {
        EXPECT_EQ(StatusOf(child), 0);
    }
    PageStore store(Options(), &warnings);
    for (std::uint64_t i = 0; i < kPages; ++i) {
        EXPECT_TRUE(Has(&store, i, BytesOf(i)));
    }
    EXPECT_EQ(store.Statistics().pagesRejected, 0U);
}

TEST_F(PageProcessesTest, AKilledWriterLeavesAllItsPages) {
    std::mt19937 random(7);
    std::uint64_t saved = 0; // pages [0, saved) are known to be saved
    for (int run = 0; run < 40; ++run) {
        int ends[2];
        ASSERT_EQ(::pipe(ends), 0);
        const pid_t child = Start([&] {
            PageStore store(Options(), &warnings);
            for (;;) {
                if (!Save(&store, saved, BytesOf(saved))) {
                    return false;
                }
                if (run % 2 == 1) {
                    store.SegmentData(store.Locate(TestKey(saved))->segment);
                }
                ++saved;
                if (::write(ends[1], &saved, sizeof(saved)) != sizeof(saved)) {
                    return false;
                }
            }
        });
        ::close(ends[1]);
        // Killed while it is anywhere in one of the following pages.
        for (auto wanted = random() % 150; wanted > 0; --wanted) {
            ASSERT_EQ(::read(ends[0], &saved, sizeof(saved)), ssize_t{sizeof(saved)});
        }
        ::usleep(random() % 200);
        ::kill(child, SIGKILL);
        EXPECT_TRUE(WIFSIGNALED(StatusOf(child)));
        while (::read(ends[0], &saved, sizeof(saved)) == ssize_t{sizeof(saved)}) {
        }
        ::close(ends[0]);
        PageStore store(Options(), &warnings);
        for (std::uint64_t i = 0; i < saved; ++i) {
            ASSERT_TRUE(Has(&store, i, BytesOf(i))) << "run " << run << ", page " << i;
        }
        Has(&store, saved, BytesOf(saved)); // there or not, but right
        EXPECT_EQ(store.Statistics().pagesRejected, 0U);
    }
    EXPECT_GT(saved, 2000U); // several index blocks
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(PageProcessesTest, AFileIsNotContinuedWhileItsWriterLives) {
    PageStore first(Options(), &warnings);
    EXPECT_TRUE(Save(&first, 1, 1000));
    PageStore second(Options(), &warnings);
    EXPECT_TRUE(Save(&second, 2, 1000));
    EXPECT_EQ(Files().size(), 2U);
    EXPECT_TRUE(Has(&second, 1, 1000));
    EXPECT_TRUE(Save(&first, 3, 1000));
    PageStore third(Options(), &warnings);
    for (const std::uint64_t i : {1, 2, 3}) {
        EXPECT_TRUE(Has(&third, i, 1000));
    }
}

TEST_F(PageProcessesTest, AForkedChildReadsButLeavesTheFileToItsParent) {
    auto store = std::make_unique<PageStore>(Options(), &warnings);
    EXPECT_TRUE(Save(store.get(), 1, 1000));
    EXPECT_NE(store->SegmentData(0), nullptr);
    const auto mappedBytes = std::filesystem::file_size(OnlyFile());
    EXPECT_EQ(StatusOf(Start([&] {
                  const bool isRight = IsRight(store.get(), 1, 1000) && !Save(store.get(), 2, 1000);
                  store.reset();
                  return isRight;
              })),
              0);
    EXPECT_EQ(std::filesystem::file_size(OnlyFile()), mappedBytes);
    EXPECT_TRUE(Save(store.get(), 2, 1000));
    EXPECT_TRUE(Has(store.get(), 2, 1000));
}

} // namespace
} // namespace hds
