// SPDX-License-Identifier: Apache-2.0
// A subdivided mesh with its rates and groups, and the triangles of some of its groups. Internal to
// geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/subdivPoints.h"

#include <memory>
#include <vector>

namespace hds {

/// What groups are made from. Immutable; any number of threads may read it.
struct SubdivDice {
    std::unique_ptr<const SubdivModel> model;
    std::unique_ptr<Warnings> keyWarnings; ///< of keyModels: all were heard of the other
    /// The same topology at each of the mesh's keys; empty: it does not move.
    std::vector<std::unique_ptr<const SubdivModel>> keyModels;
    SubdivDisplacement displacement;
    std::vector<std::uint32_t> entries;        ///< material entry by authored face; empty: all 0
    std::vector<std::uint8_t> edgeLevels;      ///< [cage edges]
    std::vector<std::uint32_t> faceGroups;     ///< [cage faces + 1] first group
    std::vector<std::uint32_t> groupTriangles; ///< [groups + 1] first primId
    glm::dvec3 origin{0.0};
    bool keepsRest = false; ///< chunks have kMovedBy and, unless flat, kRestNormals

    /// Upper bounds of all groups together.
    struct Counts {
        std::uint64_t triangles = 0;
        std::uint64_t vertices = 0; ///< shared ones once
    };

    /// Fills faceGroups and groupTriangles from edgeLevels; lowers the highest levels until primIds
    /// can be counted.
    Counts NumberGroups();
    /// Levels of a cage face's edges. \param levels of at least its size.
    void FaceLevels(int face, std::vector<std::uint8_t>& levels) const;
    /// The cage face of a group.
    int FaceOf(std::uint32_t group) const;
};

/// The triangles of some groups, in their order.
ChunkGeometry DiceGroups(const SubdivDice& dice, const std::uint32_t* groups, std::size_t count);

} // namespace hds
