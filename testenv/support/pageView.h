// SPDX-License-Identifier: Apache-2.0
// The parts of a geometry page, read from its bytes by the layout of kernels/shared/geometry.h.
#pragma once

#include "kernels/shared/geometry.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <cstring>
#include <vector>

namespace hds::test {

/// Copies of a page's parts.
struct PageView {
    explicit PageView(const std::uint8_t* page) {
        std::memcpy(&header, page, sizeof(header));
        const std::uint8_t* triangleAt = page + std::size_t{header.triangles} * 16;
        const std::uint32_t count = header.numTriangles & ((1U << HDS_PRIMITIVE_SHIFT) - 1U);
        for (std::uint32_t i = 0; i < count; ++i) {
            std::uint64_t word = 0;
            std::uint32_t primId = 0;
            std::memcpy(&word, triangleAt + std::size_t{i} * 8, 8);
            std::memcpy(&primId, page + std::size_t{header.primIds} * 16 + std::size_t{i} * 4, 4);
            triangles.emplace_back(word % 0x200000, word / 0x200000 % 0x200000,
                                   word / 0x200000 / 0x200000);
            primIds.push_back(primId);
        }
    }

    shared::HdsPageHeader header{};
    std::vector<glm::uvec3> triangles; ///< chunk-local vertices
    std::vector<std::uint32_t> primIds;
};

} // namespace hds::test
