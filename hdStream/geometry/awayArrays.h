// SPDX-License-Identifier: Apache-2.0
// Geometry whose large arrays are away (base/arraySource.h): held while something is made of them.
#pragma once

#include "hdStream/geometry/geometryDescription.h"

#include <cstdint>
#include <memory>

namespace hds {

/// The geometry with all of its arrays in memory; itself where none is away. \throws Error where an
/// array cannot be read again.
std::shared_ptr<const GeometryDescription>
Held(const std::shared_ptr<const GeometryDescription>& geometry);

/// The same of a primvar.
Primvar Held(const Primvar& primvar);

/// Its sources keep their arrays no more than others do who hold them.
void DropArrays(const GeometryDescription& geometry);

/// Bytes of the arrays that are away: what holding them takes.
std::uint64_t AwayBytes(const GeometryDescription& geometry);

} // namespace hds
