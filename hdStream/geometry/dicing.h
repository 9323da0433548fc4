// SPDX-License-Identifier: Apache-2.0
// How finely a subdivision surface is cut: one rate, a power of two, per edge of the cage. A pure
// function of the mesh, the limits and a recorded dicing camera. Explained in docs/geometry.md.
#pragma once

#include "hdStream/base/fields.h"

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include <cstdint>
#include <vector>

namespace hds {

/// What a dicing camera sees, and where the object's finest instance is. The camera looks along -z.
struct DicingView {
    glm::dmat4 cameraFromObject{1.0};
    /// Where it also is: at other times of the shutter, or instances that are as near. Edges have
    /// the highest level that one of the places asks for.
    std::vector<glm::dmat4> otherPlaces;
    bool isOrthographic = false;
    bool isPanoramic = false; ///< it may see all around; borders are in radians
    /// The image's borders: at distance 1 (perspective), or of every distance (orthographic).
    glm::dvec2 windowMin{-1.0};
    glm::dvec2 windowMax{1.0};
    glm::dvec2 imageSize{0.0}; ///< pixels; 0: nothing is on screen
    double nearClip = 1e-3;    ///< distances below count as this
    /// Nothing else of the object is on screen: what lies beside the image on the way through all
    /// places, which is straight from one to the next, is coarse.
    /// Else rates follow from distances, whatever the image shows.
    bool isOnlyInstance = true;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(DicingView, cameraFromObject),
                         HDS_FIELD(DicingView, otherPlaces), HDS_FIELD(DicingView, isOrthographic),
                         HDS_FIELD(DicingView, isPanoramic), HDS_FIELD(DicingView, windowMin),
                         HDS_FIELD(DicingView, windowMax), HDS_FIELD(DicingView, imageSize),
                         HDS_FIELD(DicingView, nearClip), HDS_FIELD(DicingView, isOnlyInstance));
    }
};

/// Rates of a mesh. All edges get 2^level segments (uniform), or as many as they need on screen.
struct DicingOptions {
    bool isAdaptive = false;
    /// Uniform: of every edge. Adaptive: of the finest. At most kMaxDicingLevel.
    std::uint32_t level = 2;
    DicingView view; ///< adaptive only, as the bounds below

    double maxErrorPixels = 0.25;     ///< distance of the triangles from the limit surface
    double maxTurnDegrees = 15.0;     ///< between the normals of an edge's ends
    double maxEdgePixels = 64.0;      ///< length of a triangle's side
    double maxBumpPixels = 4.0;       ///< the same where displacement varies
    std::uint32_t offScreenLevel = 1; ///< of the finest edge of a face that is not seen

    static constexpr auto Fields() {
        return FieldList(
            HDS_FIELD(DicingOptions, isAdaptive), HDS_FIELD(DicingOptions, level),
            HDS_FIELD(DicingOptions, view), HDS_FIELD(DicingOptions, maxErrorPixels),
            HDS_FIELD(DicingOptions, maxTurnDegrees), HDS_FIELD(DicingOptions, maxEdgePixels),
            HDS_FIELD(DicingOptions, maxBumpPixels), HDS_FIELD(DicingOptions, offScreenLevel));
    }
};

/// Finest level of both modes.
constexpr std::uint32_t kMaxDicingLevel = 8;
/// Bound of adaptive dicing unless told otherwise.
constexpr std::uint32_t kAdaptiveLevel = 6;

} // namespace hds
