// SPDX-License-Identifier: Apache-2.0
// Pages whose content follows from their number, so that any process can tell a right one, and a
// folder of the test's own.
#pragma once

#include "hdStream/persist/pageStore.h"
#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace hds {

/// Key of page `number`; plain, since any 128 bits are a key.
inline PageKey TestKey(std::uint64_t number) {
    return {{number * 0x9e3779b97f4a7c15ULL + 1, ~number}};
}

/// Content of page `number`: a linear congruential generator's bytes.
inline std::vector<std::uint8_t> TestPage(std::uint64_t number, std::size_t bytes) {
    std::vector<std::uint8_t> data(bytes);
    std::uint64_t state = number + 1;
    for (std::uint8_t& byte : data) {
        state = state * 6364136223846793005ULL + 1442695040888963407ULL;
        byte = static_cast<std::uint8_t>(state >> 56U);
    }
    return data;
}

class PageStoreTest : public ::testing::Test {
protected:
    PageStoreOptions Options(std::uint64_t segmentBytes = 1U << 20U) const {
        PageStoreOptions options;
        options.directory = folder.string();
        options.segmentBytes = segmentBytes;
        return options;
    }
    bool Save(PageStore* store, std::uint64_t number, std::size_t bytes) const {
        const auto data = TestPage(number, bytes);
        return store->Save(TestKey(number), data.data(), data.size());
    }
    /// Whether the page is there and right. A page that is there and wrong fails the test.
    bool Has(PageStore* store, std::uint64_t number, std::size_t bytes) const {
        std::vector<std::uint8_t> data;
        if (!store->Load(TestKey(number), &data)) {
            return false;
        }
        EXPECT_EQ(data, TestPage(number, bytes)) << "page " << number;
        return true;
    }
    std::vector<std::filesystem::path> Files() const {
        std::vector<std::filesystem::path> files;
        for (const auto& entry : std::filesystem::directory_iterator(folder)) {
            files.push_back(entry.path());
        }
        return files;
    }
    std::filesystem::path OnlyFile() const {
        const auto files = Files();
        EXPECT_EQ(files.size(), 1U);
        return files.empty() ? std::filesystem::path() : files[0];
    }
    void FlipByte(const std::filesystem::path& path, std::uint64_t at) const {
        std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
        file.seekg(static_cast<std::streamoff>(at));
        const char byte = static_cast<char>(file.get() ^ 0x40);
        file.seekp(static_cast<std::streamoff>(at));
        file.put(byte);
        ASSERT_TRUE(file.good());
    }

    test::TemporaryFolder temporary;
    /// With spaces and letters outside of ASCII, for all tests; the store makes it.
    std::filesystem::path folder = temporary.File("hds pages \xc3\xa4\xe7\x94\xbb");
    Warnings warnings;
};

} // namespace hds
