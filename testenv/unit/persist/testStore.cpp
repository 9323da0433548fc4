// SPDX-License-Identifier: Apache-2.0
// An entry is complete and verified, or absent; a cache that cannot be used warns once and is
// silent.
#include "hdStream/persist/store.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

namespace hds {
namespace {

namespace fs = std::filesystem;

class StoreTest : public ::testing::Test {
protected:
    void SetUp() override {
        folder = fs::temp_directory_path() /
                 ("hdsStore-" + std::to_string(::getpid()) + "-" +
                  ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder);
    }
    void TearDown() override { fs::remove_all(folder); }

    Store Open(std::uint64_t maxBytes = 1U << 20U) {
        return {{folder.string(), true, maxBytes}, &warnings};
    }
    fs::path OnlyEntry() const {
        fs::path found;
        for (const auto& entry : fs::directory_iterator(folder)) {
            EXPECT_TRUE(found.empty());
            found = entry.path();
        }
        return found;
    }

    fs::path folder;
    Warnings warnings;
};

std::vector<std::uint8_t> Payload(std::size_t bytes) {
    std::vector<std::uint8_t> data(bytes);
    for (std::size_t i = 0; i < bytes; ++i) {
        data[i] = static_cast<std::uint8_t>(i * 7 + 3);
    }
    return data;
}

TEST_F(StoreTest, ReturnsWhatWasSaved) {
    for (const std::size_t bytes : {std::size_t{0}, std::size_t{1}, std::size_t{4097}}) {
        const auto data = Payload(bytes);
        Open().Save("kind", "key", data.data(), data.size());
        const auto loaded = Open().Load("kind", "key"); // another process, as it were
        ASSERT_TRUE(loaded.has_value());
        EXPECT_EQ(*loaded, data);
    }
    EXPECT_FALSE(Open().Load("other", "key").has_value());
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(StoreTest, EveryFlippedByteIsFoundAndTheEntryDeleted) {
    const auto data = Payload(100);
    Open().Save("kind", "key", data.data(), data.size());
    const fs::path entry = OnlyEntry();
    const auto size = static_cast<std::streamoff>(fs::file_size(entry));
    for (std::streamoff at = 0; at < size; ++at) {
        if (at >= 12 && at < 16) {
            continue; // the reserved word says nothing
        }
        Open().Save("kind", "key", data.data(), data.size());
        {
            std::fstream file(entry, std::ios::in | std::ios::out | std::ios::binary);
            file.seekg(at);
            const char byte = static_cast<char>(file.get() ^ 0x40);
            file.seekp(at);
            file.put(byte);
        }
        const auto loaded = Open().Load("kind", "key");
        // The checksum's padding is the one place where a flip may go unnoticed: the data are right
        // then.
        if (loaded.has_value()) {
            EXPECT_EQ(*loaded, data) << "byte " << at;
        } else {
            EXPECT_FALSE(fs::exists(entry)) << "byte " << at;
        }
    }
}

TEST_F(StoreTest, TruncatedEntriesAreAbsent) {
    const auto data = Payload(100);
    for (const std::uintmax_t size : {0U, 10U, 63U, 64U, 100U, 163U}) {
        Open().Save("kind", "key", data.data(), data.size());
        fs::resize_file(OnlyEntry(), size);
        EXPECT_FALSE(Open().Load("kind", "key").has_value()) << size;
    }
}

TEST_F(StoreTest, AnUnusableFolderWarnsOnce) {
    std::ofstream(folder).put('x'); // a file where the folder should be
    Store store = Open();
    store.Save("kind", "a", "x", 1);
    store.Save("kind", "b", "x", 1);
    EXPECT_FALSE(store.IsWriting());
    EXPECT_EQ(warnings.Lines().size(), 1U);
    EXPECT_NE(warnings.Lines()[0].find(folder.string()), std::string::npos);
}

TEST_F(StoreTest, WhatIsThereIsReadThoughNothingCanBeWritten) {
    Store store = Open();
    store.Save("kind", "good", "abc", 3);
    store.Save("kind", "no/such/folder", "x", 1);
    EXPECT_FALSE(store.IsWriting());
    EXPECT_EQ(warnings.Lines().size(), 1U);
    EXPECT_TRUE(store.Contains("kind", "good"));
    EXPECT_TRUE(store.Load("kind", "good").has_value());
    store.Save("kind", "other", "x", 1);
    EXPECT_FALSE(store.Contains("kind", "other"));
}

TEST_F(StoreTest, WhatKilledWritersLeaveIsCountedAndCleared) {
    Store store = Open();
    store.Save("kind", "good", "abc", 3);
    const std::uint64_t good = store.Size();
    const fs::path fresh = folder / "kind-a.0123456789abcdef.hdsc-tmp";
    const fs::path old = folder / "kind-b.0123456789abcdef.hdsc-tmp";
    std::ofstream(fresh) << std::string(1000, 'x');
    std::ofstream(old) << std::string(1000, 'x');
    fs::last_write_time(old, fs::file_time_type::clock::now() - std::chrono::hours(2));
    const fs::path foreign = folder / "theirs.tmp";
    std::ofstream(foreign) << std::string(1000, 'x');
    fs::last_write_time(foreign, fs::file_time_type::clock::now() - std::chrono::hours(2));
    EXPECT_EQ(store.Size(), good + 2000U);
    EXPECT_EQ(store.Keys("kind"), std::vector<std::string>{"good"});
    store.Save("kind", "other", "abc", 3);
    EXPECT_FALSE(fs::exists(old));
    EXPECT_TRUE(fs::exists(fresh)) << "somebody may be writing it";
    store.Clear();
    EXPECT_FALSE(fs::exists(fresh));
    EXPECT_TRUE(fs::exists(foreign)) << "a folder may hold what is not ours";
    EXPECT_EQ(store.Size(), 0U);
}

TEST_F(StoreTest, AnEntryThatIsReplacedStaysThere) {
    Store store = Open(1U << 30U);
    const auto data = Payload(300'000);
    store.Save("kind", "key", data.data(), data.size());
    std::thread writer([&] {
        Store other = Open(1U << 30U);
        for (std::size_t i = 0; i < 400; ++i) {
            other.Save("kind", "key", data.data(), data.size() - 1000 * (i % 100));
        }
    });
    for (int i = 0; i < 400; ++i) {
        EXPECT_TRUE(store.Load("kind", "key").has_value()) << i;
    }
    writer.join();
}

TEST_F(StoreTest, TheLeastRecentlyUsedGoesFirst) {
    const auto data = Payload(1000);
    Store store = Open(3500);
    for (const char* key : {"a", "b", "c"}) {
        store.Save("kind", key, data.data(), data.size());
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_TRUE(store.Load("kind", "a").has_value()); // now newer than b
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    store.Save("kind", "d", data.data(), data.size());
    EXPECT_FALSE(store.Load("kind", "b").has_value());
    EXPECT_TRUE(store.Load("kind", "a").has_value());
    EXPECT_TRUE(store.Load("kind", "d").has_value());
    EXPECT_LE(store.Size(), 3500U);
}

TEST_F(StoreTest, ClearFreesEverything) {
    Store store = Open();
    store.Save("kind", "a", "abc", 3);
    const std::uint64_t size = store.Size();
    EXPECT_GT(size, 3U);
    EXPECT_EQ(store.Clear(), size);
    EXPECT_EQ(store.Size(), 0U);
}

TEST_F(StoreTest, TwoWritersOfOneKeyLeaveAWholeEntry) {
    const auto data = Payload(20000);
    std::vector<std::thread> writers;
    for (int i = 0; i < 4; ++i) {
        writers.emplace_back([&] {
            Store store = Open();
            for (int k = 0; k < 20; ++k) {
                store.Save("kind", "key", data.data(), data.size());
                const auto loaded = store.Load("kind", "key");
                EXPECT_TRUE(loaded.has_value() && *loaded == data);
            }
        });
    }
    for (std::thread& writer : writers) {
        writer.join();
    }
}

} // namespace
} // namespace hds
