// SPDX-License-Identifier: Apache-2.0
// Normals that were authored for a mesh at rest, where skeletons and blend shapes have moved its
// points. Both front ends ask for them, so that characters are shaded alike. Explained in
// docs/materials.md, "Skinning".
#pragma once

#include "hdStream/geometry/geometryDescription.h"

#include <optional>

namespace hds {

/// The primvar "normals" of a mesh whose points went from `atRest` to `posed`, both [numPoints][3].
/// Each corner of a face has a frame at rest and one posed: a geometric normal and the corner's two
/// sides in the plane of it. A normal keeps its products with the sides, as covectors do, and its
/// part along the geometric normal is divided by the root of the ratio of areas, so that turns and
/// uniform scales are exact. The geometric normal is the smooth one of the point (Max 1999) or that
/// of the face, whichever the authored normal is nearer to: smooth normals stay smooth, those of
/// hard edges stay the face's. Of vertex and varying normals the corners around a point are
/// averaged; all others come back for each corner. Unit length; what is not a direction stays as
/// authored. Of `mesh` the faces alone are read.
/// \return none when counts do not fit: the normals are of no use.
std::optional<Primvar> CarryNormals(const Primvar& normals, const GeometryDescription& mesh,
                                    const SharedSpan<float>& atRest,
                                    const SharedSpan<float>& posed);

} // namespace hds
