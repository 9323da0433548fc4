// SPDX-License-Identifier: Apache-2.0
// Checks of an authored mesh, with the warnings of each: what both the whole-mesh interpretation
// and the source of chunks begin with. Internal to geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/geometry/faceTable.h"
#include "hdStream/geometry/primvars.h"

#include <glm/vec3.hpp>

#include <optional>
#include <string>
#include <vector>

namespace hds {

/// The warnings of one prim.
class PrimLog {
public:
    PrimLog(std::string primPath, Warnings& warnings)
        : _primPath(std::move(primPath)), _warnings(warnings) {}
    void Warn(const std::string& text) { _warnings.Add(_primPath, text); }
    const std::string& PrimPath() const { return _primPath; }
    Warnings& Sink() { return _warnings; }

private:
    std::string _primPath;
    Warnings& _warnings;
};

/// True for schemes whose cage is the surface: faceted unless normals are authored.
bool IsPolygonal(const std::string& scheme);

/// Lengths of the arrays, the scheme's name.
void CheckHeader(const GeometryDescription& mesh, const FaceTable& table, PrimLog& log);

/// False, with a line, when faces or face-vertices cannot be counted in 32 bits.
bool IsCountable(const GeometryDescription& mesh, const FaceTable& table, PrimLog& log);

/// One byte a face; empty when there are no holes.
std::vector<std::uint8_t> MarkHoles(const GeometryDescription& mesh, PrimLog& log);

/// Where positions are relative to. An axis moves only when the whole mesh lies within a factor 2
/// of the new origin on it, so that float subtraction is exact (Sterbenz 1974, theorem 4.3.1).
glm::vec3 ChooseOrigin(const Bounds& bounds);

/// Material entry per face: 1 + the first subset that names it, else 0. Empty: all 0.
std::vector<std::uint32_t> AssignSubsets(const GeometryDescription& mesh, PrimLog& log);

/// User primvars that can be used, sorted by name.
std::vector<GeometryAttribute> CollectAttributes(const GeometryDescription& mesh,
                                                 const TopologySize& size, PrimLog& log);

/// The authored normals, if they can be used; some may still be zero or not finite.
std::optional<GeometryAttribute> AuthoredNormals(const GeometryDescription& mesh,
                                                 const TopologySize& size, PrimLog& log);

/// Replaces unusable normals (RepairNormals), with a line. Precondition: not Constant.
void RepairAuthoredNormals(const TriangleMesh& mesh, const TopologySize& size,
                           GeometryAttribute& normals, PrimLog& log);

} // namespace hds
