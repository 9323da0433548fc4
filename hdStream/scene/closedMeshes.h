// SPDX-License-Identifier: Apache-2.0
// Whether meshes that a medium fills have an inside. Explained in docs/volumes.md.
#pragma once

#include "hdStream/geometry/geometryDescription.h"

#include <atomic>
#include <map>
#include <memory>

namespace hds {

/// Whether the faces close up: each edge has as many faces on one side as on the other. Points in
/// one place are one. Where that is not enough, ends of the edges that are left over are one if
/// they are closer than a thousandth of the mesh, or than some smaller distance: seams whose points
/// differ by rounding, and holes that are as small, do not count.
bool IsClosed(const GeometryDescription& mesh);

/// Which meshes are closed, by the identity of their geometry: each is looked at once while it is
/// in the scene.
class ClosedMeshes {
public:
    /// Geometry is to be looked at, unless it has been. Forgets none. Externally synchronised.
    void Ask(const std::shared_ptr<const GeometryDescription>& geometry);

    /// Looks at geometry that was asked for, unless that has been done or another thread does it.
    /// Thread-safe. \return what keeps the arrays that were read for it; null: none were.
    /// \throws Error where they cannot be read again.
    std::shared_ptr<const void> Look(const std::shared_ptr<const GeometryDescription>& geometry);

    /// Looks at all that was asked for and has not been looked at, on all cores, and forgets what
    /// is gone. Externally synchronised. \throws Error as Look
    void LookAtOthers();

    /// Whether geometry is closed. \pre it was asked for, and LookAtOthers called since then.
    bool IsClosed(const std::shared_ptr<const GeometryDescription>& geometry) const;

private:
    struct State {
        std::atomic<bool> isTaken{false};
        bool isKnown = false;
        bool isClosed = false;
    };

    std::map<std::weak_ptr<const GeometryDescription>, State, std::owner_less<>> _states;
};

} // namespace hds
