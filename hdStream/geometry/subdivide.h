// SPDX-License-Identifier: Apache-2.0
// Uniform subdivision (OpenSubdiv, Catmull and Clark 1978, Loop 1987) of a control cage: points and
// normals of the limit surface at the vertices of a refinement level, with all primvars.
// Internal to geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/triangleMesh.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// Most refinement levels; each one makes four faces of a quad.
constexpr int kMaxRefineLevel = 8;

/// A refined mesh: polygons (scheme "none") with limit normals as the primvar "normals". Subsets
/// are not refined: they name authored faces.
struct RefinedMesh {
    MeshDescription mesh;
    std::vector<std::uint32_t> authoredFaces; ///< [refined faces], ascending
};

/// Refines a catmullClark, loop or bilinear mesh `level` times (at least 1, at most
/// kMaxRefineLevel). Nothing, and one warning, when the topology cannot be subdivided: the cage is
/// drawn then. Vertex primvars follow the surface's rules, faceVarying ones their own topology,
/// varying ones are linear; uniform and constant ones are shared with the authored mesh.
/// Thread-safe.
std::optional<RefinedMesh> RefineMesh(const MeshDescription& mesh, int level,
                                      const std::string& primPath, Warnings& warnings);

} // namespace hds
