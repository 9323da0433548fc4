// SPDX-License-Identifier: Apache-2.0
// A 128-bit content hash for cache keys and checksums: two FNV-1a-like 64-bit lanes with a strong
// final mix (Stafford's variant 13 of splitmix64). Not for adversaries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace hds {

/// Accumulates bytes; the result depends on content and order only, not on the platform.
class Hasher {
public:
    void Append(const void* data, std::size_t bytes);
    /// Appends the length too, so that ("ab","c") differs from ("a","bc").
    void Append(std::string_view text);
    void Append(std::uint64_t value) { Append(&value, sizeof(value)); }
    /// 32 hexadecimal digits.
    std::string Hex() const;

private:
    std::uint64_t _a = 0xcbf29ce484222325ULL;
    std::uint64_t _b = 0x9ae16a3b2f90404fULL;
};

} // namespace hds
