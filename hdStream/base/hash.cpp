// SPDX-License-Identifier: Apache-2.0
#include "hdStream/base/hash.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <vector>

namespace hds {

namespace {

// Odd, about half of the bits set, no pattern: the primes of xxHash64.
constexpr std::uint64_t kInner = 0xc2b2ae3d27d4eb4fULL;
constexpr std::uint64_t kOuter = 0x9e3779b185ebca87ULL;

/// Bytes of a block of AppendParallel: part of the result, never change it alone.
constexpr std::size_t kParallelBlock = std::size_t{1} << 20U;

/// How far ahead of reading: arrays from memory were hashed 1.7 times as fast with it.
constexpr std::size_t kPrefetchBytes = 1024;

std::uint64_t RotateLeft(std::uint64_t x, unsigned bits) {
    return (x << bits) | (x >> (64U - bits));
}

/// Least significant byte first on every platform (compilers make it one load).
std::uint64_t LoadWord(const unsigned char* p) {
    std::uint64_t word = 0;
    for (unsigned i = 0; i < 8; ++i) {
        word |= static_cast<std::uint64_t>(p[i]) << (8U * i);
    }
    return word;
}

std::uint64_t Finalise(std::uint64_t x) {
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31U);
}

/// One step of two neighbour lanes; a bijection of each lane for given words.
inline void MixPair(std::uint64_t* first, std::uint64_t* second, const unsigned char* p) {
    const std::uint64_t a = LoadWord(p);
    const std::uint64_t b = LoadWord(p + 8);
    *first = (RotateLeft(*first + a * kInner, 31) * kOuter) ^ b;
    *second = (RotateLeft(*second + b * kInner, 31) * kOuter) ^ a;
}

} // namespace

void Hasher::Mix(Lanes* lanes, const unsigned char* data, std::size_t stripes) {
    Lanes local = *lanes; // in registers
    for (const unsigned char* end = data + stripes * kStripeBytes; data != end;
         data += kStripeBytes) {
        __builtin_prefetch(data + kPrefetchBytes);
        MixPair(&local[0], &local[1], data);
        MixPair(&local[2], &local[3], data + 16);
        MixPair(&local[4], &local[5], data + 32);
        MixPair(&local[6], &local[7], data + 48);
    }
    *lanes = local;
}

void Hasher::Append(const void* data, std::size_t bytes) {
    if (bytes == 0) {
        return; // data may be null
    }
    const auto* p = static_cast<const unsigned char*>(data);
    const std::size_t buffered = _totalBytes % kStripeBytes;
    _totalBytes += bytes;
    if (buffered > 0) {
        const std::size_t taken = std::min(bytes, kStripeBytes - buffered);
        std::memcpy(_buffer.data() + buffered, p, taken);
        if (buffered + taken < kStripeBytes) {
            return;
        }
        Mix(&_lanes, _buffer.data(), 1);
        p += taken;
        bytes -= taken;
    }
    Mix(&_lanes, p, bytes / kStripeBytes);
    if (const std::size_t rest = bytes % kStripeBytes; rest > 0) {
        std::memcpy(_buffer.data(), p + (bytes - rest), rest);
    }
}

void Hasher::Append(std::string_view text) {
    Append(static_cast<std::uint64_t>(text.size()));
    Append(text.data(), text.size());
}

void Hasher::Append(std::uint64_t value) {
    unsigned char bytes[8];
    for (unsigned i = 0; i < 8; ++i) {
        bytes[i] = static_cast<unsigned char>(value >> (8U * i));
    }
    Append(bytes, sizeof(bytes));
}

std::array<std::uint64_t, 2> Hasher::Words() const {
    Lanes lanes = _lanes;
    if (const std::size_t rest = _totalBytes % kStripeBytes; rest > 0) {
        // Zeros to the end of the stripe; the length tells them from content.
        std::array<unsigned char, kStripeBytes> last{};
        std::memcpy(last.data(), _buffer.data(), rest);
        Mix(&lanes, last.data(), 1);
    }
    std::uint64_t low = _totalBytes * kInner;
    std::uint64_t high = _totalBytes + kOuter;
    for (std::size_t i = 0; i < kLanes; ++i) {
        low = Finalise(low ^ lanes[i]);
        high = Finalise(high + RotateLeft(lanes[kLanes - 1 - i], 23));
    }
    return {low, high};
}

std::string Hasher::Hex() const {
    const std::array<std::uint64_t, 2> words = Words();
    char digits[33];
    std::snprintf(digits, sizeof(digits), "%016llx%016llx",
                  static_cast<unsigned long long>(words[0]),
                  static_cast<unsigned long long>(words[1]));
    return digits;
}

void AppendParallel(Hasher* hasher, const void* data, std::size_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    const std::size_t blocks = (bytes + kParallelBlock - 1) / kParallelBlock;
    std::vector<std::array<std::uint64_t, 2>> hashes(blocks);
    const auto hashBlock = [&](std::size_t block) {
        const std::size_t begin = block * kParallelBlock;
        Hasher own;
        own.Append(p + begin, std::min(kParallelBlock, bytes - begin));
        hashes[block] = own.Words();
    };
    if (blocks == 1) {
        hashBlock(0);
    } else {
        tbb::this_task_arena::isolate(
            [&] { tbb::parallel_for(std::size_t{0}, blocks, hashBlock); });
    }
    hasher->Append(static_cast<std::uint64_t>(bytes));
    for (const std::array<std::uint64_t, 2>& hash : hashes) {
        hasher->Append(hash[0]);
        hasher->Append(hash[1]);
    }
}

} // namespace hds
