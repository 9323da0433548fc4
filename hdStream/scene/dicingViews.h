// SPDX-License-Identifier: Apache-2.0
// What a recorded dicing camera sees of each subdivided mesh: the view of its finest instance.
// Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/dicing.h"
#include "hdStream/scene/sceneDescription.h"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace hds {

/// Steps of the shutter at whose ends what moves is looked at.
constexpr std::size_t kDicingSteps = 8;

/// The camera that rates are chosen for. It stays when the render's camera moves, until the scene
/// is diced again.
struct DicingCamera {
    glm::dmat4 worldFromCamera{1.0};
    /// The same at the ends of kDicingSteps equal steps of the shutter; empty: it rests.
    std::vector<glm::dmat4> path;
    bool isOrthographic = false;
    bool isPanoramic = false;
    glm::dvec2 windowMin{-1.0}; ///< as DicingView's
    glm::dvec2 windowMax{1.0};
    glm::dvec2 imageSize{0.0}; ///< pixels
    double nearClip = 1e-3;
    bool isStill = true; ///< what it does not see stays coarse; else it may turn to see it

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(DicingCamera, worldFromCamera), HDS_FIELD(DicingCamera, path),
                         HDS_FIELD(DicingCamera, isOrthographic),
                         HDS_FIELD(DicingCamera, isPanoramic), HDS_FIELD(DicingCamera, windowMin),
                         HDS_FIELD(DicingCamera, windowMax), HDS_FIELD(DicingCamera, imageSize),
                         HDS_FIELD(DicingCamera, nearClip), HDS_FIELD(DicingCamera, isStill));
    }
};

using GeometryEntry = std::pair<const std::string, GeometryPrim>;
/// How far displacement moves a prim's points at most, in object space.
using DisplacementReach = std::function<double(const GeometryEntry&)>;

/// Views by prim path, of those of `prims` that have a subdivision scheme. Prototypes that are
/// placed alike share the search: where nothing moves it costs one matrix product per instance, and
/// no memory. The finest instance of a prim is the one on screen whose pixels are smallest, by the
/// sphere around the prim; without any on screen, the one nearest to it. What moves is looked at
/// where it is at steps of the shutter. \param reachOf is asked of what is instanced; null: nothing
/// is displaced.
std::map<std::string, DicingView> FindDicingViews(const SceneDescription& scene,
                                                  const std::vector<const GeometryEntry*>& prims,
                                                  const DicingCamera& camera,
                                                  const Shutter& shutter = {},
                                                  const DisplacementReach& reachOf = nullptr);

} // namespace hds
