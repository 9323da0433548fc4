// SPDX-License-Identifier: Apache-2.0
// The hash tells contents, lengths and orders apart, and never changes between builds.
#include "hdStream/base/hash.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <set>
#include <vector>

namespace hds {
namespace {

std::string HexOf(std::initializer_list<std::string_view> texts) {
    Hasher hasher;
    for (const std::string_view text : texts) {
        hasher.Append(text);
    }
    return hasher.Hex();
}

TEST(Hash, TellsSplitsAndOrdersApart) {
    const std::set<std::string> values{HexOf({"ab", "c"}), HexOf({"a", "bc"}), HexOf({"abc"}),
                                       HexOf({"c", "ab"}), HexOf({"", "abc"}), HexOf({})};
    EXPECT_EQ(values.size(), 6U);
    EXPECT_EQ(HexOf({"ab", "c"}), HexOf({"ab", "c"}));
}

TEST(Hash, EverySingleBitMatters) {
    std::set<std::string> values;
    for (int byte = 0; byte < 64; ++byte) {
        for (int bit = 0; bit < 8; ++bit) {
            unsigned char data[64] = {};
            data[byte] = static_cast<unsigned char>(1U << bit);
            Hasher hasher;
            hasher.Append(data, sizeof(data));
            values.insert(hasher.Hex());
        }
    }
    EXPECT_EQ(values.size(), 64U * 8U);
}

std::vector<unsigned char> Bytes(std::size_t count) {
    std::vector<unsigned char> data(count);
    for (std::size_t i = 0; i < count; ++i) {
        data[i] = static_cast<unsigned char>(i * 31 + (i >> 8U) * 7 + 1);
    }
    return data;
}

std::array<std::uint64_t, 2> WordsOf(const void* data, std::size_t bytes) {
    Hasher hasher;
    hasher.Append(data, bytes);
    return hasher.Words();
}

TEST(Hash, SplittingOverCallsDoesNotMatter) {
    const std::vector<unsigned char> data = Bytes(300);
    for (const std::size_t step : {1, 3, 8, 63, 64, 65, 200}) {
        Hasher hasher;
        for (std::size_t at = 0; at < data.size(); at += step) {
            hasher.Append(data.data() + at, std::min(step, data.size() - at));
            hasher.Append(nullptr, 0);
        }
        EXPECT_EQ(hasher.Words(), WordsOf(data.data(), data.size())) << step;
    }
}

TEST(Hash, ValuesAreWhatFilesOnDiskHold) {
    // Recorded. When they change, the versions of persist/store and persist/pageFormat must, and
    // the goldens of testenv/translate.
    EXPECT_EQ(Hasher().Hex(), "043b17c47fba123b768454bbd7b3a483");
    const std::vector<unsigned char> data = Bytes(300);
    Hasher hasher;
    hasher.Append(data.data(), data.size());
    EXPECT_EQ(hasher.Hex(), "72cfb6a19a61c7a40f74e908450e8656");
    hasher = Hasher();
    hasher.Append(std::uint64_t{0x0102030405060708});
    EXPECT_EQ(hasher.Hex(), "45d2f85ffe0ecd5c1f3bbce3545eb478");
    hasher = Hasher();
    const std::vector<unsigned char> large = Bytes((5U << 20U) / 2);
    AppendParallel(&hasher, large.data(), large.size());
    EXPECT_EQ(hasher.Hex(), "c5ac8073a4d6d5576eb805a440231b9d");
}

TEST(Hash, LengthsOfZerosDiffer) {
    const std::vector<unsigned char> zeros(1000);
    std::set<std::array<std::uint64_t, 2>> values;
    for (std::size_t bytes = 0; bytes <= zeros.size(); ++bytes) {
        values.insert(WordsOf(zeros.data(), bytes));
    }
    EXPECT_EQ(values.size(), zeros.size() + 1);
}

TEST(Hash, NoTwoOfAMillionSparseInputsShareAWord) {
    // All inputs of 180 bytes with one or two bits set, in each half of the hash alone: the chance
    // of one collision is 1e12 / 2^65.
    std::vector<unsigned char> data(180);
    std::vector<std::uint64_t> words[2];
    const std::size_t bits = data.size() * 8;
    for (std::size_t a = 0; a < bits; ++a) {
        data[a / 8] ^= static_cast<unsigned char>(1U << (a % 8));
        for (std::size_t b = 0; b < a; ++b) {
            data[b / 8] ^= static_cast<unsigned char>(1U << (b % 8));
            const auto hash = WordsOf(data.data(), data.size());
            words[0].push_back(hash[0]);
            words[1].push_back(hash[1]);
            data[b / 8] ^= static_cast<unsigned char>(1U << (b % 8));
        }
        data[a / 8] ^= static_cast<unsigned char>(1U << (a % 8));
    }
    for (std::vector<std::uint64_t>& half : words) {
        std::sort(half.begin(), half.end());
        EXPECT_EQ(std::adjacent_find(half.begin(), half.end()), half.end());
    }
}

TEST(Hash, AFlippedBitFlipsEachOutputBitHalfOfTheTime) {
    // Binomial(inputs, 1/2) for each of the 128 output bits: five standard deviations.
    std::vector<unsigned char> data = Bytes(200);
    const auto before = WordsOf(data.data(), data.size());
    std::vector<int> flips(128);
    const int inputs = static_cast<int>(data.size()) * 8;
    for (int bit = 0; bit < inputs; ++bit) {
        unsigned char& byte = data[static_cast<std::size_t>(bit) / 8];
        byte ^= static_cast<unsigned char>(1U << (bit % 8));
        const auto after = WordsOf(data.data(), data.size());
        byte ^= static_cast<unsigned char>(1U << (bit % 8));
        for (std::size_t word = 0; word < 2; ++word) {
            const std::bitset<64> changed(before[word] ^ after[word]);
            for (std::size_t i = 0; i < 64; ++i) {
                flips[word * 64 + i] += changed[i] ? 1 : 0;
            }
        }
    }
    for (const int count : flips) {
        EXPECT_NEAR(count, inputs / 2, 5 * std::sqrt(inputs / 4.0));
    }
}

TEST(Hash, TheParallelHashIsThatOfItsBlocksOnAnyNumberOfThreads) {
    constexpr std::size_t kBlock = 1U << 20U;
    for (const std::size_t bytes :
         {std::size_t{0}, std::size_t{1}, kBlock - 1, kBlock, kBlock + 1, 7 * kBlock + 5}) {
        const std::vector<unsigned char> data = Bytes(bytes);
        Hasher expected;
        expected.Append(std::uint64_t{bytes});
        for (std::size_t at = 0; at < bytes; at += kBlock) {
            for (const std::uint64_t word :
                 WordsOf(data.data() + at, std::min(kBlock, bytes - at))) {
                expected.Append(word);
            }
        }
        for (const std::size_t threads : {1, 2, 5}) {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            Hasher hasher;
            AppendParallel(&hasher, data.data(), data.size());
            EXPECT_EQ(hasher.Words(), expected.Words()) << bytes;
        }
    }
}

} // namespace
} // namespace hds
