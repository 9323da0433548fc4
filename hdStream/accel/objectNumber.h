// SPDX-License-Identifier: Apache-2.0
// What the number of an object says (kernels/shared/instanceChunk.h). Private to the layer.
#pragma once

#include "kernels/shared/instanceChunk.h"

#include <cstdint>
#include <vector>

namespace hds {

/// The object of that number. \param objects the table
inline shared::HdsObject ObjectOf(const std::vector<shared::HdsObject>& objects,
                                  std::uint32_t number) {
    const std::uint32_t kind = number >> HDS_OBJECT_NUMBER_SHIFT;
    return kind < HDS_OBJECT_CHUNK
               ? objects[number]
               : shared::HdsObject{kind, 0, number & ((1U << HDS_OBJECT_NUMBER_SHIFT) - 1U), 1};
}

} // namespace hds
