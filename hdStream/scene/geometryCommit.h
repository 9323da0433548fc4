// SPDX-License-Identifier: Apache-2.0
// A mesh, curves or points -> chunks and pages.
#pragma once

#include "hdStream/accel/chunkPages.h"
#include "hdStream/accel/chunkedGeometry.h"
#include "hdStream/accel/sourceKeeper.h"
#include "hdStream/base/log.h"
#include "hdStream/geometry/dicing.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/shading/materialCompiler.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// Geometry, checked and cut into chunks that are not made yet, with its top tree.
struct PlannedGeometry {
    std::vector<AttributeName> attributes; ///< user primvars, in the order of their slots
    bool leftHanded = false;
    glm::dvec3 origin{0.0};         ///< object-space point that all positions are relative to
    std::uint64_t numTriangles = 0; ///< upper bound; exact for polygons
    std::shared_ptr<const ChunkedGeometry> geometry; ///< null: nothing can be drawn
    std::vector<std::shared_ptr<ChunkPages>> chunks; ///< in the leaf order of the top tree
    std::vector<shared::HdsBvhNode> topNodes;        ///< empty for a single chunk
    Bounds bounds;                                   ///< relative to origin
};

/// All that the pages of geometry are made of.
struct GeometryInputs {
    std::shared_ptr<const GeometryDescription> geometry;
    std::uint64_t chunkBytes = 1U << 17U; ///< about what the pages of a chunk take at most
    /// Of a mesh with a subdivision scheme; nothing: its cage is drawn as polygons.
    Apart<std::optional<DicingOptions>> dicing;
    std::vector<DisplacementInput> displacements; ///< by material entry
    bool autobump = false; ///< shading adds what triangles leave of these (kMovedBy)
    /// Those that something reads, sorted; of the others only normals and widths, which
    /// give shape, count.
    std::vector<std::string> primvars;
    Shutter shutter; ///< of geometry whose points move; else closed

    static constexpr auto Fields() {
        return FieldList(
            HDS_FIELD(GeometryInputs, geometry), HDS_FIELD(GeometryInputs, chunkBytes),
            HDS_FIELD(GeometryInputs, dicing), HDS_FIELD(GeometryInputs, displacements),
            HDS_FIELD(GeometryInputs, autobump),
            HDS_FIELD(GeometryInputs, primvars)
                .NotInKey("of primvars that are not read, the geometry has none by then"),
            HDS_FIELD(GeometryInputs, shutter));
    }

    /// Whether geometry made of these serves where `other` is asked for.
    bool Suffice(const GeometryInputs& other) const;
};

/// Checks geometry, cuts it into chunks and builds its top tree, on all cores if it is large; makes
/// no triangles. Unusable geometry has no chunks. \param path subject of the warnings, which must
/// outlive the result. \param store of finished pages; may be null. \param keeper of what chunks
/// are cut from; null: it stays. Arrays of the geometry that can be read again are dropped.
/// \throws Error where they cannot be read again.
PlannedGeometry PlanGeometry(const std::string& path,
                             const std::shared_ptr<const GeometryInputs>& inputs,
                             std::shared_ptr<PageStore> store, Warnings& warnings,
                             std::shared_ptr<SourceKeeper> keeper = nullptr);

/// All triangles of planned geometry, in an order that does not depend on its chunks.
ChunkGeometry GatherAll(const PlannedGeometry& planned);

} // namespace hds
