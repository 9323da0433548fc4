// SPDX-License-Identifier: Apache-2.0
// What a recorded dicing camera sees of each subdivided mesh: the view of its finest instance.
// Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/dicing.h"
#include "hdStream/scene/sceneDescription.h"

#include <map>
#include <string>
#include <vector>

namespace hds {

/// The camera that rates are chosen for. It stays when the render's camera moves, until the scene
/// is diced again.
struct DicingCamera {
    glm::dmat4 worldFromCamera{1.0};
    bool isOrthographic = false;
    bool isPanoramic = false;
    glm::dvec2 windowMin{-1.0}; ///< as DicingView's
    glm::dvec2 windowMax{1.0};
    glm::dvec2 imageSize{0.0}; ///< pixels
    double nearClip = 1e-3;
    bool isStill = true; ///< what it does not see stays coarse; else it may turn to see it

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(DicingCamera, worldFromCamera),
                         HDS_FIELD(DicingCamera, isOrthographic),
                         HDS_FIELD(DicingCamera, isPanoramic), HDS_FIELD(DicingCamera, windowMin),
                         HDS_FIELD(DicingCamera, windowMax), HDS_FIELD(DicingCamera, imageSize),
                         HDS_FIELD(DicingCamera, nearClip), HDS_FIELD(DicingCamera, isStill));
    }
};

/// Views by prim path, of those of `prims` that have a subdivision scheme. Prototypes that are
/// placed alike share the search: it costs one matrix product per instance, and no memory. The
/// finest instance is the one on screen whose pixels are smallest, by the sphere around what is
/// placed; without any on screen, the one nearest to it.
std::map<std::string, DicingView>
FindDicingViews(const SceneDescription& scene,
                const std::vector<const std::pair<const std::string, GeometryPrim>*>& prims,
                const DicingCamera& camera);

} // namespace hds
