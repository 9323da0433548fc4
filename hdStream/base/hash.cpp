// SPDX-License-Identifier: Apache-2.0
#include "hdStream/base/hash.h"

#include <cstdio>

namespace hds {

namespace {

std::uint64_t Mix(std::uint64_t x) {
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31U);
}

} // namespace

void Hasher::Append(const void* data, std::size_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) {
        _a = (_a ^ p[i]) * 0x100000001b3ULL;
        _b = (_b + p[i] + 1) * 0x9fb21c651e98df25ULL;
        _b ^= _b >> 29U;
    }
}

void Hasher::Append(std::string_view text) {
    Append(static_cast<std::uint64_t>(text.size()));
    Append(text.data(), text.size());
}

std::string Hasher::Hex() const {
    char digits[33];
    std::snprintf(digits, sizeof(digits), "%016llx%016llx",
                  static_cast<unsigned long long>(Mix(_a)),
                  static_cast<unsigned long long>(Mix(_b ^ (_a << 1U))));
    return digits;
}

} // namespace hds
