// SPDX-License-Identifier: Apache-2.0
// A subdivision surface as a source of chunks: diced per edge, evaluated on the limit surface,
// displaced. A group is a cage face, or a tile of one that is cut finely. Explained in
// docs/geometry.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/geometry/chunkSource.h"
#include "hdStream/geometry/dicing.h"
#include "hdStream/geometry/displacement.h"

#include <memory>
#include <string>
#include <vector>

namespace hds {

/// True for catmullClark, loop and bilinear.
bool IsSubdivisionScheme(const std::string& scheme);

/// A source that knows its rates.
class SubdivChunkSource : public ChunkSource {
public:
    /// Level of each edge of the cage, in OpenSubdiv's order. With the mesh and its displacement
    /// they are all that the chunks depend on, whatever camera they were chosen for.
    virtual const std::vector<std::uint8_t>& EdgeLevels() const = 0;
};

/// Checks the mesh, chooses rates and measures the groups; evaluates no triangle.
/// \return null, with a warning, when OpenSubdiv refuses the mesh: its cage is drawn as polygons
/// then. Null too when no face can be used, with the warnings of MakePolygonSource. Never throws on
/// content.
/// \param keepsRest chunks of a mesh whose displacement varies, and which does not deform, have
/// kMovedBy and kRestNormals (displacement.h). \param warnings must outlive the source: values of
/// primvars are looked at when the first chunk is gathered. Cost: one evaluation of OpenSubdiv per
/// cage face, on all cores. Precondition: IsSubdivisionScheme(mesh->subdivisionScheme).
std::shared_ptr<const SubdivChunkSource>
MakeSubdivSource(std::shared_ptr<const GeometryDescription> mesh, const std::string& primPath,
                 const DicingOptions& options, const Displacement& displacement, Warnings& warnings,
                 bool keepsRest = false);

} // namespace hds
