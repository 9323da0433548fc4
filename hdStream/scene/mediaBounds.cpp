// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/mediaBounds.h"

#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

namespace hds {

namespace {

/// By point, the first of those in its place.
std::vector<std::int32_t> WeldPoints(const SharedSpan<float>& points) {
    const std::size_t numPoints = points.size() / 3;
    const auto place = [&](std::int32_t point) {
        const float* p = points.data() + 3 * std::size_t(point);
        return std::make_tuple(p[0], p[1], p[2]);
    };
    std::vector<std::int32_t> order(numPoints);
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::int32_t a, std::int32_t b) { return place(a) < place(b); });
    std::vector<std::int32_t> first(numPoints);
    for (std::size_t i = 0; i < numPoints; ++i) {
        const bool isNew = i == 0 || place(order[i]) != place(order[i - 1]);
        first[order[i]] = isNew ? order[i] : first[order[i - 1]];
    }
    return first;
}

} // namespace

bool IsClosed(const GeometryDescription& mesh) {
    const std::vector<std::int32_t> first = WeldPoints(mesh.points);
    const auto numPoints = static_cast<std::int32_t>(first.size());
    // An edge and which way faces go along it; those of both ways cancel.
    std::vector<std::pair<std::pair<std::int32_t, std::int32_t>, int>> edges;
    edges.reserve(mesh.faceVertexIndices.size());
    std::vector<bool> isHole(mesh.faceVertexCounts.size());
    for (const std::int32_t face : mesh.holeIndices) {
        if (face >= 0 && std::size_t(face) < isHole.size()) {
            isHole[face] = true;
        }
    }
    std::size_t begin = 0;
    for (std::size_t face = 0; face < mesh.faceVertexCounts.size(); ++face) {
        const std::int32_t count = mesh.faceVertexCounts[face];
        if (count < 0 || begin + std::size_t(count) > mesh.faceVertexIndices.size()) {
            return false;
        }
        for (std::int32_t k = 0; k < count && !isHole[face]; ++k) {
            const std::int32_t a = mesh.faceVertexIndices[begin + k];
            const std::int32_t b = mesh.faceVertexIndices[begin + (k + 1) % count];
            if (a < 0 || b < 0 || a >= numPoints || b >= numPoints) {
                return false;
            }
            const std::int32_t from = first[a];
            const std::int32_t to = first[b];
            if (from != to) {
                edges.push_back({{std::min(from, to), std::max(from, to)}, from < to ? 1 : -1});
            }
        }
        begin += std::size_t(count);
    }
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 0; i < edges.size();) {
        int sum = 0;
        const auto edge = edges[i].first;
        for (; i < edges.size() && edges[i].first == edge; ++i) {
            sum += edges[i].second;
        }
        if (sum != 0) {
            return false;
        }
    }
    return true;
}

std::optional<float> DielectricPriority(const std::vector<Primvar>& primvars) {
    for (const char* name :
         {"hdstream:dielectricPriority", "ri:attributes:trace:intersectpriority"}) {
        const auto found = std::find_if(primvars.begin(), primvars.end(),
                                        [&](const Primvar& one) { return one.name == name; });
        if (found != primvars.end() && found->interpolation == Interpolation::Constant &&
            found->values.size() == 1) {
            return found->values[0];
        }
    }
    return std::nullopt;
}

MediaBounds FindMediaBounds(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
                            glm::dvec3 centre) {
    MediaBounds box;
    for (const DrawnLeaf& leaf : leaves) {
        const LeafObject& object = leaf.object;
        if ((object.flags & HDS_INSTANCE_MEDIUM) == 0) {
            continue;
        }
        ForEachPlacement(scene, leaf.Prim().placement, [&](const glm::dmat4& worldFromObject) {
            for (int corner = 0; corner < 8; ++corner) {
                glm::dvec3 at = object.origin;
                for (int i = 0; i < 3; ++i) {
                    at[i] += static_cast<double>((corner >> i & 1) != 0 ? object.bounds.max[i]
                                                                        : object.bounds.min[i]);
                }
                const glm::dvec3 world = glm::dvec3(worldFromObject * glm::dvec4(at, 1.0)) - centre;
                box.min = glm::min(box.min, world);
                box.max = glm::max(box.max, world);
            }
        });
    }
    return box;
}

} // namespace hds
