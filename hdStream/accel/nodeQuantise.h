// SPDX-License-Identifier: Apache-2.0
// Packs up to eight child boxes into a node: conservative quantisation to bytes and the assignment
// of children to slots. Source: Ylitie, Karras, Laine 2017, sections 3.1 (slots) and 3.2 (boxes);
// deviates: every decoded plane is compared with the true one and moved until it contains it.
// Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/simd4.h"
#include "kernels/shared/bvhNode.h"

#include <array>

namespace hds {

/// A box as the builder stores it; lane 3 is not read.
struct alignas(16) SlotBox {
    float lo[4];
    float hi[4];
};

/// Writes origin, exponents and planes of `node` (the imask stays). Slots that are not in
/// `slotMask` get an empty box (low 255, high 0). \param parent contains every slot's box; all
/// values are finite.
void QuantiseNode(const SlotBox& parent, const std::array<SlotBox, 8>& slots,
                  std::uint32_t slotMask, shared::HdsBvhNode* node);

/// Chooses a slot for each of `count` children so that slot numbers grow along the octant: slot 0
/// is nearest for a ray that goes to +x +y +z, bit 2 of a slot means "far along x, seen so", bit 1
/// y, bit 0 z. Greedy: the pair of least cost dot(centre of child - centre of node, diagonal of
/// slot) first. \return slot of each child.
std::array<int, 8> AssignSlots(const SlotBox& parent, const std::array<SlotBox, 8>& children,
                               int count);

} // namespace hds
