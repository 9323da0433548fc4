// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/dicingViews.h"

#include "hdStream/geometry/subdivSource.h"
#include "hdStream/scene/placements.h"

#include "kernels/shared/geometry.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace hds {

namespace {

using GeometryEntry = std::pair<const std::string, GeometryPrim>;

/// Instancers that place each other in a circle place nothing.
constexpr int kMaxChain = 64;

struct Sphere {
    glm::dvec3 centre{0.0};
    double radius = -1.0; ///< negative: empty
};

/// Around the box of the mesh's points, in the space of its prototype.
Sphere SphereOf(const GeometryPrim& prim) {
    glm::dvec3 low(1e300);
    glm::dvec3 high(-1e300);
    const SharedSpan<float> points = prim.geometry->points.Held();
    for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
        const glm::dvec3 p(points[i], points[i + 1], points[i + 2]);
        if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
    }
    if (low.x > high.x) {
        return {};
    }
    const glm::dmat4& matrix = prim.placement.worldFromObject;
    const glm::dmat3 linear(matrix);
    // The lengths of a matrix's columns bound it: |M x| <= sqrt(sum of squares) |x|.
    const double scale = std::sqrt(glm::dot(linear[0], linear[0]) + glm::dot(linear[1], linear[1]) +
                                   glm::dot(linear[2], linear[2]));
    return {glm::dvec3(matrix * glm::dvec4(0.5 * (low + high), 1.0)),
            0.5 * glm::length(high - low) * scale};
}

void Extend(Sphere& sphere, const Sphere& other) {
    if (other.radius < 0.0) {
        return;
    }
    if (sphere.radius < 0.0) {
        sphere = other;
        return;
    }
    sphere.radius =
        std::max(sphere.radius, glm::length(other.centre - sphere.centre) + other.radius);
}

/// Calls visit(worldFromPrototype) for each instance that a placement names, parents first; once,
/// with the identity, for what is not instanced.
void ForEachInstance(const SceneDescription& scene, const Placement& placement, int chain,
                     const std::function<void(const glm::dmat4&)>& visit) {
    if (placement.instancerPath.empty()) {
        visit(glm::dmat4(1.0));
        return;
    }
    const auto found = scene.instancers.find(placement.instancerPath);
    if (found == scene.instancers.end() || !found->second.placement.visible || chain >= kMaxChain) {
        return;
    }
    int length = 0;
    if (chain == 0 && NumPlacements(scene, placement, &length) > kMostPlacements &&
        length > HDS_MAX_GROUP_DEPTH) {
        return; // not drawn, of which scene/hierarchy warns
    }
    const InstancerPrim& instancer = found->second;
    const std::size_t limit = instancer.instanceTransforms.Size();
    ForEachInstance(scene, instancer.placement, chain + 1, [&](const glm::dmat4& parent) {
        const glm::dmat4 worldFromInstancer = parent * instancer.placement.worldFromObject;
        for (const std::int32_t index : placement.instances) {
            if (index >= 0 && std::size_t(index) < limit) {
                visit(worldFromInstancer * instancer.instanceTransforms.At(std::size_t(index)));
            }
        }
    });
}

/// How fine an instance is, and whether the image shows it.
struct Fineness {
    bool isOnScreen = false;
    double pixels = -1.0; ///< of a unit length of the prototype, at its nearest

    bool operator<(const Fineness& other) const {
        return isOnScreen != other.isOnScreen ? other.isOnScreen : pixels < other.pixels;
    }
};

Fineness Rate(const glm::dmat4& cameraFromPrototype, const Sphere& sphere,
              const DicingCamera& camera) {
    const glm::dmat3 linear(cameraFromPrototype);
    const double square = std::max({glm::dot(linear[0], linear[0]), glm::dot(linear[1], linear[1]),
                                    glm::dot(linear[2], linear[2])});
    const double scale = std::sqrt(square);
    // Columns bound a matrix up to the square root of their number.
    const double radius = std::max(sphere.radius, 0.0) * scale * std::sqrt(3.0);
    const auto centre = glm::dvec3(cameraFromPrototype * glm::dvec4(sphere.centre, 1.0));
    const double distance = camera.isPanoramic ? glm::length(centre) : -centre.z;
    const double nearest = std::max(distance - radius, camera.nearClip);
    Fineness result;
    result.pixels = camera.isOrthographic ? scale : scale / nearest;
    result.isOnScreen = camera.isPanoramic || centre.z - radius <= 0.0;
    for (int axis = 0; axis < 2 && result.isOnScreen && !camera.isPanoramic; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            const double border = side < 0.0 ? camera.windowMin[axis] : camera.windowMax[axis];
            // Outside of the border's plane, through the eye unless orthographic.
            const double depth = camera.isOrthographic ? 1.0 : -centre.z;
            const double length = camera.isOrthographic ? 1.0 : std::sqrt(1.0 + border * border);
            if (side * (centre[axis] - border * depth) / length > radius) {
                result.isOnScreen = false;
            }
        }
    }
    return result;
}

/// Prims with the same instances.
struct Group {
    const Placement* placement = nullptr;
    std::vector<const GeometryEntry*> prims;
};

DicingView ViewOf(const DicingCamera& camera) {
    DicingView view;
    view.isOrthographic = camera.isOrthographic;
    view.isPanoramic = camera.isPanoramic;
    view.windowMin = camera.windowMin;
    view.windowMax = camera.windowMax;
    view.imageSize = camera.imageSize;
    view.nearClip = camera.nearClip;
    return view;
}

} // namespace

std::map<std::string, DicingView> FindDicingViews(const SceneDescription& scene,
                                                  const std::vector<const GeometryEntry*>& prims,
                                                  const DicingCamera& camera) {
    std::map<std::pair<std::string, const std::int32_t*>, std::size_t> index;
    std::vector<Group> groups;
    for (const GeometryEntry* entry : prims) {
        const GeometryPrim& prim = entry->second;
        if (!IsSubdivisionScheme(prim.geometry->subdivisionScheme)) {
            continue;
        }
        const Placement& placement = prim.placement;
        // What is not instanced is a group of its own: its matrix is a placement of one.
        if (placement.instancerPath.empty()) {
            groups.push_back({&placement, {entry}});
            continue;
        }
        const auto [found, isNew] = index.emplace(
            std::make_pair(placement.instancerPath, placement.instances.data()), groups.size());
        if (isNew) {
            groups.push_back({&placement, {}});
        }
        groups[found->second].prims.push_back(entry);
    }
    const glm::dmat4 cameraFromWorld = glm::inverse(camera.worldFromCamera);
    std::vector<std::vector<DicingView>> views(groups.size());
    tbb::parallel_for(std::size_t{0}, groups.size(), [&](std::size_t i) {
        Sphere sphere;
        for (const GeometryEntry* entry : groups[i].prims) {
            Extend(sphere, SphereOf(entry->second));
        }
        Fineness finest;
        glm::dmat4 worldFromPrototype(1.0);
        std::size_t numOnScreen = 0;
        ForEachInstance(scene, *groups[i].placement, 0, [&](const glm::dmat4& instance) {
            const Fineness fineness = Rate(cameraFromWorld * instance, sphere, camera);
            numOnScreen += fineness.isOnScreen ? 1 : 0;
            if (finest < fineness) {
                finest = fineness;
                worldFromPrototype = instance;
            }
        });
        for (const GeometryEntry* entry : groups[i].prims) {
            DicingView view = ViewOf(camera);
            view.isOnlyInstance = camera.isStill && numOnScreen <= 1;
            view.cameraFromObject =
                cameraFromWorld * worldFromPrototype * entry->second.placement.worldFromObject;
            views[i].push_back(view);
        }
    });
    std::map<std::string, DicingView> result;
    for (std::size_t i = 0; i < groups.size(); ++i) {
        for (std::size_t k = 0; k < groups[i].prims.size(); ++k) {
            result[groups[i].prims[k]->first] = views[i][k];
        }
    }
    return result;
}

} // namespace hds
