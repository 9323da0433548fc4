// SPDX-License-Identifier: Apache-2.0
// Ids of MaterialX's node definitions, ND_<category>_<types>. Part of the material compiler.
#pragma once

#include <cstdint>
#include <string>

namespace hds {

/// An id in parts.
struct NodeId {
    std::string category;
    std::uint32_t firstComponents = 0; ///< of the first type in the id; 0: it names none
    std::uint32_t lastComponents = 0;
};

/// \pre the identifier begins with "ND_".
NodeId ParseId(const std::string& identifier);

} // namespace hds
