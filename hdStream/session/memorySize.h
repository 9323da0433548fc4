// SPDX-License-Identifier: Apache-2.0
// Sizes as users write them, for all front ends. Both throw Error (usage) that quotes the text and
// says what is expected; whoever calls adds the option's name.
#pragma once

#include <cstdint>
#include <string>

namespace hds {

/// Bytes, or a share of all that there is; the other one is 0.
struct MemorySize {
    std::uint64_t bytes = 0;
    double share = 0.0; ///< in ]0, 1]
};

/// "4096", "512M", "1.5g": above 0, suffixes K, M, G, T are powers of 1024.
std::uint64_t ParseBytes(const std::string& text);

/// As ParseBytes, or "30%", a percentage in ]0, 100].
MemorySize ParseMemorySize(const std::string& text);

} // namespace hds
