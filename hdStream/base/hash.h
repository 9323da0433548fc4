// SPDX-License-Identifier: Apache-2.0
// A fast 128-bit content hash for cache keys and checksums. Not for adversaries.
// Eight 64-bit lanes take 64 bytes a step with a multiply-rotate-multiply round (the round of
// xxHash64, Collet 2012); each word also enters its neighbour lane, so that a change of one word
// changes 128 bits of state. The lanes are folded with Stafford's variant 13 of the splitmix64
// finaliser (2011).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace hds {

/// Accumulates bytes. The result depends on the bytes and their order only: not on how they were
/// split over calls, not on the platform.
class Hasher {
public:
    void Append(const void* data, std::size_t bytes);
    /// Appends the length too, so that ("ab","c") differs from ("a","bc").
    void Append(std::string_view text);
    /// Appends eight bytes, least significant first.
    void Append(std::uint64_t value);

    /// The hash of what was appended so far; more may follow.
    std::array<std::uint64_t, 2> Words() const;
    /// Words() as 32 hexadecimal digits.
    std::string Hex() const;

private:
    static constexpr std::size_t kLanes = 8;
    static constexpr std::size_t kStripeBytes = 8 * kLanes;
    using Lanes = std::array<std::uint64_t, kLanes>;

    static void Mix(Lanes* lanes, const unsigned char* data, std::size_t stripes);

    // Any odd-looking constants do; these are the hexadecimal digits of pi.
    Lanes _lanes{0x243f6a8885a308d3ULL, 0x13198a2e03707344ULL, 0xa4093822299f31d0ULL,
                 0x082efa98ec4e6c89ULL, 0x452821e638d01377ULL, 0xbe5466cf34e90c6cULL,
                 0xc0ac29b7c97c50ddULL, 0x3f84d5b5b5470917ULL};
    std::array<unsigned char, kStripeBytes> _buffer{}; ///< bytes of a stripe that is not whole yet
    std::uint64_t _totalBytes = 0;
};

/// Appends a large array as the hashes of blocks of fixed size, which are made in parallel, and its
/// length: the same result on any number of threads (but another than that of Hasher::Append).
/// Blocks until done; runs no other TBB task meanwhile, so the caller may hold a lock.
void AppendParallel(Hasher* hasher, const void* data, std::size_t bytes);

} // namespace hds
