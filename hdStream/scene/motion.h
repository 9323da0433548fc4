// SPDX-License-Identifier: Apache-2.0
// Transforms over the time in which the shutter is open, and their keys for the device.
// Explained in docs/motionBlur.md.
#pragma once

#include "hdStream/geometry/triangleMesh.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/shading/emissiveMesh.h"

#include <functional>
#include <vector>

namespace hds {

/// The transform between samples: rotation, stretch and translation are interpolated apart; before
/// the first and after the last sample it is theirs. \pre samples are not empty.
glm::dmat4 InterpolateTransform(const std::vector<TransformSample>& samples, double time);

/// What of the samples lies in the shutter's interval, with interpolated ones at its ends; nothing
/// when the transform is the same at all of them.
std::vector<TransformSample> SamplesWithin(const std::vector<TransformSample>& samples,
                                           const Shutter& shutter);

/// A transform that may change while the shutter is open.
class MovingTransform {
public:
    /// One at rest.
    MovingTransform(const glm::dmat4& transform) : _transform(transform) {} // NOLINT: converts

    /// \param atFrame the transform at the frame, which also holds when it does not move.
    MovingTransform(const glm::dmat4& atFrame, const std::vector<TransformSample>& samples,
                    const Shutter& shutter);

    bool Moves() const { return static_cast<bool>(_at); }
    const glm::dmat4& AtFrame() const { return _transform; }

    /// \param time 0: the shutter opens, 1: it closes.
    glm::dmat4 At(double time) const { return _at ? _at(time) : _transform; }

    /// The directions that it gives: without its translation and its size, where it has one.
    MovingTransform Directions() const;

    /// outer * inner at each time.
    friend MovingTransform operator*(const MovingTransform& outer, const MovingTransform& inner);

private:
    glm::dmat4 _transform;
    std::function<glm::dmat4(double)> _at; ///< null: at rest
};

/// Matrices at equal distances in time, from the opening of the shutter to its closing, that are
/// linear between each other to within a small part of the way that the box goes: at least two, at
/// most HDS_MAX_MOTION_SEGMENTS + 1.
std::vector<glm::dmat4> MakeMotionKeys(const MovingTransform& transform, const Bounds& bounds);

/// The rotation of each pose against rest, as LightKey has it, each by the shorter way from the one
/// before. \param[out] isRigid whether the poses differ by nothing else in their linear parts.
/// \pre all are usable.
std::vector<glm::dvec4> TurnsOf(const std::vector<glm::dmat4>& poses, const glm::dmat4& rest,
                                bool* isRigid);

/// The keys of a light, relative to where it is at the frame; empty when it rests. What is not
/// rigid of its motion is left out. \param[out] isRigid whether nothing was.
std::vector<LightKey> MakeLightKeys(const MovingTransform& worldFromLight, bool* isRigid);

/// Whether the camera's pose changes.
bool MovesOver(const CameraPrim& camera, const Shutter& shutter);

/// The lens and the film that the camera has for the frame, as a sample.
LensSample LensOfFrame(const CameraPrim& camera);

/// The lens and the film at a time, in frames from the frame: linear between samples.
LensSample LensAt(const CameraPrim& camera, double time);

/// Whether the lens or the film changes while the shutter is open.
bool LensChangesOver(const CameraPrim& camera, const Shutter& shutter);

/// The keys of a camera's pose.
std::vector<glm::dmat4> MakeCameraKeys(const CameraPrim& camera, const Shutter& shutter);

} // namespace hds
