// SPDX-License-Identifier: Apache-2.0
// The emissive meshes of a scene as lights: which they are, and what each of their triangles emits.
// Explained in docs/lights.md, "Emissive meshes".
#pragma once

#include "hdStream/scene/lightCommit.h"

namespace hds {

/// The emissive meshes, and which of them each material entry of each world instance is.
struct EmissiveMeshes {
    std::vector<EmissiveMesh> meshes;
    std::vector<std::uint32_t> firstEntryByRecord; ///< into meshByEntry
    std::vector<std::uint32_t> meshByEntry;        ///< HDS_NONE: none
    std::uint64_t numTriangles = 0;
};

/// Warns of meshes that emit but are not sampled as lights.
EmissiveMeshes CollectEmissiveMeshes(const LightCommitInput& input, CommitCache* cache,
                                     Warnings& warnings);

} // namespace hds
