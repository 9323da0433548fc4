// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/sceneCentre.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

/// How far from the origin a scene may lie, in half diagonals, before it is recentred.
constexpr double kMaxRelativeDistance = 4.0;
/// The same for most of a scene, where a few strays keep the origin inside of its bounds: from here
/// on floats have fewer than 14 bits left for what is in it.
constexpr double kMaxDistanceOfMost = 1024.0;
constexpr std::size_t kFewestPieces = 4;        ///< one of which may be a stray
constexpr std::size_t kMostInstances = 1 << 14; ///< of an instancer that are pieces

/// How many of so many pieces are three of four.
std::size_t MostOf(std::size_t count) {
    return (3 * count + 3) / 4;
}

/// Where things are, and how large.
class Pieces {
public:
    void Add(const std::vector<Reach>& pieces) {
        for (const Reach& piece : pieces) {
            if (!piece.IsEmpty()) {
                _middles.push_back(piece.Middle());
                _radii.push_back(piece.HalfDiagonal());
            }
        }
    }

    /// A ball of the medians of places that three of four pieces lie in. \return whether it is far
    /// from the origin.
    bool FindFar(glm::dvec3* middle, double* radius) const {
        if (_middles.size() < kFewestPieces || !MayBeFar()) {
            return false;
        }
        std::vector<double> values(_middles.size());
        for (int axis = 0; axis < 3; ++axis) {
            std::transform(_middles.begin(), _middles.end(), values.begin(),
                           [axis](const glm::dvec3& point) { return point[axis]; });
            (*middle)[axis] = Least(&values, values.size() / 2);
        }
        for (std::size_t i = 0; i < values.size(); ++i) {
            values[i] = glm::length(_middles[i] - *middle) + _radii[i];
        }
        *radius = Least(&values, MostOf(values.size()) - 1);
        return *radius > 0.0 && glm::length(*middle) > kMaxDistanceOfMost * *radius;
    }

private:
    /// Whether three of four pieces are far from the origin for their own size, as those of a ball
    /// that is far are.
    bool MayBeFar() const {
        std::size_t left = _middles.size() - MostOf(_middles.size());
        for (std::size_t i = 0; i < _middles.size(); ++i) {
            const bool isFar = glm::length(_middles[i]) > (kMaxDistanceOfMost - 2.0) * _radii[i];
            if (!isFar && left-- == 0) {
                return false;
            }
        }
        return true;
    }

    /// The one that so many are not above, besides itself.
    static double Least(std::vector<double>* values, std::size_t number) {
        const auto place = values->begin() + static_cast<std::ptrdiff_t>(number);
        std::nth_element(values->begin(), place, values->end());
        return *place;
    }

    std::vector<glm::dvec3> _middles;
    std::vector<double> _radii;
};

/// Rounded to a power of two of the scene's size, so that subtracting it loses no bits of nearby
/// positions that are themselves round.
glm::dvec3 Rounded(const glm::dvec3& middle, double halfDiagonal) {
    const double step = halfDiagonal > 0.0 ? std::exp2(std::floor(std::log2(halfDiagonal))) : 0.0;
    return step > 0.0 ? glm::round(middle / step) * step : middle;
}

} // namespace

void Reach::Extend(const glm::dvec3& point) {
    if (std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z)) {
        min = glm::min(min, point);
        max = glm::max(max, point);
    }
}

Reach ReachOfLeaf(const DrawnLeaf& leaf) {
    Reach reach;
    const Placement& placement = leaf.Prim().placement;
    if (!placement.instancerPath.empty()) {
        return reach;
    }
    const LeafObject& object = leaf.object;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 point((corner & 1) != 0 ? object.bounds.max.x : object.bounds.min.x,
                               (corner & 2) != 0 ? object.bounds.max.y : object.bounds.min.y,
                               (corner & 4) != 0 ? object.bounds.max.z : object.bounds.min.z);
        reach.Extend(
            glm::dvec3(placement.worldFromObject * glm::dvec4(object.origin + point, 1.0)));
    }
    return reach;
}

Reach ReachBesideLeaves(const SceneDescription& scene, std::vector<Reach>* pieces) {
    Reach reach;
    for (const auto& [path, volume] : scene.volumes) {
        if (volume.placement.instancerPath.empty() && volume.placement.visible) {
            reach.Extend(glm::dvec3(volume.placement.worldFromObject[3]));
        }
    }
    for (const auto& [path, instancer] : scene.instancers) {
        if (!instancer.placement.instancerPath.empty() || !instancer.placement.visible) {
            continue;
        }
        const std::size_t count = instancer.instanceTransforms.Size();
        const std::size_t step = 1 + count / kMostInstances;
        for (std::size_t i = 0; i < count; ++i) {
            Reach place;
            place.Extend(glm::dvec3(
                (instancer.placement.worldFromObject * instancer.instanceTransforms.At(i))[3]));
            reach.Extend(place);
            if (i % step == 0) {
                pieces->push_back(place);
            }
        }
    }
    return reach;
}

glm::dvec3 CentreOfReach(const Reach& all, const std::vector<Reach>& leaves,
                         const std::vector<Reach>& others) {
    if (all.IsEmpty()) {
        return glm::dvec3(0.0);
    }
    if (glm::length(all.Middle()) > kMaxRelativeDistance * all.HalfDiagonal()) {
        return Rounded(all.Middle(), all.HalfDiagonal());
    }
    Pieces pieces;
    pieces.Add(leaves);
    pieces.Add(others);
    glm::dvec3 middle(0.0);
    double radius = 0.0;
    return pieces.FindFar(&middle, &radius) ? Rounded(middle, radius) : glm::dvec3(0.0);
}

glm::dvec3 ChooseSceneCentre(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves) {
    std::vector<Reach> ofLeaves;
    std::vector<Reach> ofOthers;
    Reach all = ReachBesideLeaves(scene, &ofOthers);
    ofLeaves.reserve(leaves.size());
    for (const DrawnLeaf& leaf : leaves) {
        ofLeaves.push_back(ReachOfLeaf(leaf));
        all.Extend(ofLeaves.back());
    }
    return CentreOfReach(all, ofLeaves, ofOthers);
}

} // namespace hds
