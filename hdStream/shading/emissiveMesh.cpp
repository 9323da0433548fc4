// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/emissiveMesh.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

/// A cluster of more than two triangles is cut when it is larger than this part of the mesh...
constexpr double kMaxSize = 0.5;
/// ...and any when its triangles cover less of its box than this. A sphere covers 0.52.
constexpr double kMinCover = 0.25;
/// Parts larger than this against the whole tell nothing.
constexpr double kMinGain = 0.9;
/// A triangle is sampled at least so much against the mean of all: what its emission was guessed
/// from may have missed something bright.
constexpr double kMinEmissionShare = 1.0 / 16.0;
/// Least cosine between a normal and the axis of a cluster that counts as flat.
constexpr double kFlatCosine = 1.0 - 1e-9;
/// Flatness of all that is nearly flat: its estimate must not become 0.
constexpr double kNearlyFlat = 0.99;

struct Box {
    glm::dvec3 low{1e300};
    glm::dvec3 high{-1e300};

    void Add(const EmissiveTriangle& triangle) {
        for (const glm::dvec3& p : triangle.p) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
    }
    double Diagonal() const { return glm::length(high - low); }
    double Area() const {
        const glm::dvec3 size = high - low;
        return 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    }
};

glm::dvec3 AreaVector(const EmissiveTriangle& triangle) {
    return 0.5 * glm::cross(triangle.p[1] - triangle.p[0], triangle.p[2] - triangle.p[0]);
}

class Clusterer {
public:
    explicit Clusterer(EmissiveClusters* result) : _result(*result), _all(result->triangles) {
        _meshDiagonal = BoxOf(0, _all.size()).Diagonal();
    }

    void Split(std::size_t begin, std::size_t end) {
        const Box box = BoxOf(begin, end);
        const std::size_t middle = begin + (end - begin) / 2;
        if (end - begin > 1 && IsWorthIt(box, begin, end)) {
            SortByHalves(begin, middle, end);
            const double largest =
                std::max(BoxOf(begin, middle).Diagonal(), BoxOf(middle, end).Diagonal());
            if (largest <= kMinGain * box.Diagonal()) {
                Split(begin, middle);
                Split(middle, end);
                return;
            }
        }
        Add(box, begin, end);
    }

private:
    Box BoxOf(std::size_t begin, std::size_t end) const {
        Box box;
        for (std::size_t i = begin; i < end; ++i) {
            box.Add(_all[i]);
        }
        return box;
    }

    bool IsWorthIt(const Box& box, std::size_t begin, std::size_t end) const {
        double area = 0.0;
        for (std::size_t i = begin; i < end; ++i) {
            area += _all[i].area;
        }
        const bool isLarge = end - begin > 2 && box.Diagonal() > kMaxSize * _meshDiagonal;
        return isLarge || area < kMinCover * box.Area();
    }

    /// By centroids along the longest axis of their box; ties by primId.
    void SortByHalves(std::size_t begin, std::size_t middle, std::size_t end) {
        const auto centroid = [](const EmissiveTriangle& t) { return t.p[0] + t.p[1] + t.p[2]; };
        glm::dvec3 low(1e300);
        glm::dvec3 high(-1e300);
        for (std::size_t i = begin; i < end; ++i) {
            low = glm::min(low, centroid(_all[i]));
            high = glm::max(high, centroid(_all[i]));
        }
        const glm::dvec3 size = high - low;
        const int axis = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
        const auto at = [&](std::size_t i) { return _all.begin() + std::ptrdiff_t(i); };
        std::nth_element(at(begin), at(middle), at(end),
                         [&](const EmissiveTriangle& a, const EmissiveTriangle& b) {
                             const double ca = centroid(a)[axis];
                             const double cb = centroid(b)[axis];
                             return ca != cb ? ca < cb : a.primId < b.primId;
                         });
    }

    void Add(const Box& box, std::size_t begin, std::size_t end) {
        EmissiveCluster cluster;
        cluster.begin = begin;
        cluster.end = end;
        cluster.low = box.low;
        cluster.high = box.high;
        glm::dvec3 sum(0.0);
        for (std::size_t i = begin; i < end; ++i) {
            cluster.area += _all[i].area;
            cluster.weight += _all[i].weight;
            sum += AreaVector(_all[i]);
        }
        const double length = glm::length(sum);
        if (length > 1e-6 * cluster.area) {
            cluster.axis = sum / length;
            const bool isFlat = std::all_of(
                _all.begin() + std::ptrdiff_t(begin), _all.begin() + std::ptrdiff_t(end),
                [&](const EmissiveTriangle& t) {
                    return glm::dot(AreaVector(t), cluster.axis) >= kFlatCosine * t.area;
                });
            cluster.flatness = isFlat ? 1.0 : std::min(length / cluster.area, kNearlyFlat);
        }
        _result.clusters.push_back(cluster);
    }

    EmissiveClusters& _result;
    std::vector<EmissiveTriangle>& _all;
    double _meshDiagonal = 0.0;
};

/// Gives every triangle its weight, none of them much less than its share of the area; 0 where all
/// seem to be dark.
void Weigh(const std::vector<double>& emissions, EmissiveClusters* result) {
    double sum = 0.0;
    for (std::size_t i = 0; i < emissions.size(); ++i) {
        sum += emissions[i] * result->triangles[i].area;
    }
    const double mean = sum / result->area;
    for (std::size_t i = 0; i < emissions.size(); ++i) {
        EmissiveTriangle& triangle = result->triangles[i];
        const double emission = std::max(emissions[i], kMinEmissionShare * mean);
        triangle.weight = triangle.area * emission;
        result->weight += triangle.weight;
        result->isWeighed = result->isWeighed || std::abs(emission - mean) > 1e-6 * mean;
    }
}

} // namespace

EmissiveClusters ClusterTriangles(const EmissiveMesh& mesh) {
    EmissiveClusters result;
    std::vector<double> emissions;
    for (const EmissiveMesh::Triangle& triangle : mesh.triangles) {
        EmissiveTriangle out;
        std::copy(triangle.p, triangle.p + 3, out.p);
        out.primId = triangle.primId;
        out.source = std::size_t(&triangle - mesh.triangles.data());
        out.area = glm::length(AreaVector(out));
        if (out.area > 0.0 && std::isfinite(out.area)) {
            result.area += out.area;
            result.triangles.push_back(out);
            const bool isUsable =
                std::isfinite(triangle.meanEmission) && triangle.meanEmission > 0.0;
            emissions.push_back(isUsable ? triangle.meanEmission : 0.0);
        }
    }
    if (!result.triangles.empty()) {
        Weigh(emissions, &result);
        Clusterer(&result).Split(0, result.triangles.size());
    }
    return result;
}

} // namespace hds
