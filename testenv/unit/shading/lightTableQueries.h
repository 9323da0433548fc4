// SPDX-License-Identifier: Apache-2.0
// Lights for tests of light tables, and what the tables say of them.
#pragma once

#include "hdStream/shading/lightTable.h"

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace hds::test {

inline PlacedLight Make(LightType type) {
    PlacedLight placed;
    placed.name = "/light";
    placed.light.type = type;
    return placed;
}

inline std::uint32_t Word(const LightTable& table, std::size_t index) {
    std::uint32_t word = 0;
    std::memcpy(&word, &table.cdf[index], sizeof(word));
    return word;
}

/// Of a mesh that is one light.
inline std::uint32_t LightOfMesh(const LightTable& table, std::size_t mesh) {
    return Word(table, table.tableByMesh[mesh] + HDS_MESH_LIGHT);
}

} // namespace hds::test
