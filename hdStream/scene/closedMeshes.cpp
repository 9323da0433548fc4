// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/closedMeshes.h"

#include "hdStream/geometry/awayArrays.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

namespace hds {

namespace {

/// Distances at which points are one, over the longest edge of the mesh's box. Several: where the
/// points of a seam are as dense as one of them it joins neighbours, and one that is smaller does
/// not. The last is as fine as float is.
constexpr std::array<double, 4> kTolerances = {0x1p-22, 0x1p-18, 0x1p-14, 0x1p-10};

/// Sums of edges are kept by so many bits of their hashes at most: 32 MiB.
constexpr int kMaxBucketBits = 22;

/// Spreads what differs over all bits (the finaliser of SplitMix64).
std::uint64_t Mix(std::uint64_t bits) {
    bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
    bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
    return bits ^ (bits >> 31U);
}

/// Of three numbers; -0 is 0.
std::uint64_t HashPlace(const std::array<double, 3>& place) {
    std::uint64_t hash = 0;
    for (const double one : place) {
        const double number = one + 0.0;
        std::uint64_t bits = 0;
        std::memcpy(&bits, &number, sizeof(bits));
        hash = Mix(hash + 0x9e3779b97f4a7c15U + bits);
    }
    return hash;
}

/// Of an edge, whichever way it goes.
std::uint64_t HashEnds(std::uint64_t from, std::uint64_t to) {
    return Mix(std::min(from, to) + Mix(std::max(from, to)));
}

/// Of an edge; the other way along it has the negative. An edge of no length has 0.
std::uint64_t HashEdge(std::uint64_t from, std::uint64_t to) {
    const std::uint64_t hash = from == to ? 0 : HashEnds(from, to);
    return from < to ? hash : 0 - hash;
}

std::array<double, 3> PlaceOf(const GeometryDescription& mesh, std::int32_t point) {
    const float* const at = mesh.points.data() + 3 * std::size_t(point);
    return {at[0], at[1], at[2]};
}

/// An edge whose two sides have not as many faces.
struct LooseEdge {
    std::uint64_t hash; ///< of its ends
    std::int32_t from;
    std::int32_t to;
    bool isForward;
};

/// Tells whether a mesh is closed.
class HoleFinder {
public:
    explicit HoleFinder(const GeometryDescription& mesh)
        : _mesh(mesh), _isHole(mesh.faceVertexCounts.size()) {
        for (const std::int32_t face : mesh.holeIndices) {
            if (face >= 0 && std::size_t(face) < _isHole.size()) {
                _isHole[face] = true;
            }
        }
    }

    bool IsClosed() {
        // Edges along which faces go both ways cancel; what is left would be 0 by chance alone,
        // once in 2^64. By numbers of points first, which is cheap and enough for most.
        std::uint64_t sum = 0;
        const bool isMesh = ForEachEdge([&](std::int32_t from, std::int32_t to) {
            sum += HashEdge(std::uint64_t(from), std::uint64_t(to));
        });
        return isMesh && (sum == 0 || IsClosedByPlaces() || IsClosedByWelding());
    }

private:
    /// Calls `function` with the points of each edge of each face. \return false: a face is none.
    template <typename Function>
    bool ForEachEdge(const Function& function) const {
        const std::size_t numPoints = _mesh.points.size() / 3;
        const auto isPoint = [&](std::int32_t point) {
            return point >= 0 && std::size_t(point) < numPoints;
        };
        std::size_t begin = 0;
        for (std::size_t face = 0; face < _mesh.faceVertexCounts.size(); ++face) {
            const std::int32_t count = _mesh.faceVertexCounts[face];
            if (count < 0 || begin + std::size_t(count) > _mesh.faceVertexIndices.size()) {
                return false;
            }
            const std::int32_t* const points = _mesh.faceVertexIndices.data() + begin;
            begin += std::size_t(count);
            if (count == 0 || _isHole[face]) {
                continue;
            }
            if (!std::all_of(points, points + count, isPoint)) {
                return false;
            }
            std::int32_t from = points[count - 1];
            for (std::int32_t k = 0; k < count; ++k) {
                function(from, points[k]);
                from = points[k];
            }
        }
        return true;
    }

    std::uint64_t PlaceHash(std::int32_t point) const { return HashPlace(PlaceOf(_mesh, point)); }

    /// Points in one place are one. Else finds the loose edges, and the box.
    bool IsClosedByPlaces() {
        int bits = 4;
        while (bits < kMaxBucketBits && (std::size_t{1} << bits) < _mesh.faceVertexIndices.size()) {
            ++bits;
        }
        const int shift = 64 - bits;
        std::vector<std::uint64_t> sums(std::size_t{1} << bits); // by the hash of the ends
        ForEachEdge([&](std::int32_t from, std::int32_t to) {
            const std::uint64_t a = PlaceHash(from);
            const std::uint64_t b = PlaceHash(to);
            const std::uint64_t hash = HashEnds(a, b);
            sums[hash >> shift] += HashEdge(a, b);
            const std::array<double, 3> place = PlaceOf(_mesh, to);
            for (int i = 0; i < 3; ++i) {
                _min[i] = std::min(_min[i], place[i]);
                _max[i] = std::max(_max[i], place[i]);
            }
        });
        const auto isZero = [](std::uint64_t sum) { return sum == 0; };
        if (std::all_of(sums.begin(), sums.end(), isZero)) {
            return true;
        }
        ForEachEdge([&](std::int32_t from, std::int32_t to) {
            const std::uint64_t a = PlaceHash(from);
            const std::uint64_t b = PlaceHash(to);
            const std::uint64_t hash = HashEnds(a, b);
            if (a != b && sums[hash >> shift] != 0) {
                _loose.push_back({hash, from, to, a < b});
            }
        });
        RemoveCancelled();
        return false;
    }

    /// Others that share a sum with loose edges.
    void RemoveCancelled() {
        std::sort(_loose.begin(), _loose.end(),
                  [](const LooseEdge& a, const LooseEdge& b) { return a.hash < b.hash; });
        auto kept = _loose.begin();
        for (auto first = _loose.begin(); first != _loose.end();) {
            auto last = first;
            std::int64_t numForward = 0;
            for (; last != _loose.end() && last->hash == first->hash; ++last) {
                numForward += last->isForward ? 1 : -1;
            }
            if (numForward != 0) {
                kept = std::copy(first, last, kept);
            }
            first = last;
        }
        _loose.erase(kept, _loose.end());
    }

    /// Ends of loose edges that are near each other are one.
    bool IsClosedByWelding() {
        double size = 0.0;
        for (int i = 0; i < 3; ++i) {
            size = std::max(size, _max[i] - _min[i]);
        }
        if (!(size > 0.0) || !std::isfinite(size)) {
            return false;
        }
        // The numbers of the places of both ends of each edge, in the order in which they come.
        std::unordered_map<std::uint64_t, std::uint32_t> numbers;
        std::vector<std::array<double, 3>> places;
        std::vector<std::uint32_t> ends;
        ends.reserve(2 * _loose.size());
        for (const LooseEdge& edge : _loose) {
            for (const std::int32_t point : {edge.from, edge.to}) {
                const std::array<double, 3> place = PlaceOf(_mesh, point);
                const auto isFinite = [](double one) { return std::isfinite(one); };
                if (!std::all_of(place.begin(), place.end(), isFinite)) {
                    return false;
                }
                const auto number = static_cast<std::uint32_t>(places.size());
                const auto [found, isNew] = numbers.emplace(HashPlace(place), number);
                if (isNew) {
                    places.push_back(place);
                }
                ends.push_back(found->second);
            }
        }
        return std::any_of(kTolerances.begin(), kTolerances.end(), [&](double tolerance) {
            const std::vector<std::uint32_t> joined = Join(places, tolerance * size);
            std::uint64_t sum = 0;
            for (std::size_t i = 0; i < ends.size(); i += 2) {
                sum += HashEdge(joined[ends[i]], joined[ends[i + 1]]);
            }
            return sum == 0;
        });
    }

    /// Of each place the number of the one that it is joined to: the first that is nearer than the
    /// tolerance and joined to no other itself. So no chain of near places is one, and a hole that
    /// is larger than twice the tolerance stays one however short the edges around it are.
    std::vector<std::uint32_t> Join(const std::vector<std::array<double, 3>>& places,
                                    double tolerance) const {
        const double cell = 4.0 * tolerance;
        constexpr std::uint32_t kNone = 0xffffffffU;
        std::unordered_map<std::uint64_t, std::uint32_t> lastOfCell; ///< that is joined to no other
        std::vector<std::uint32_t> next(places.size(), kNone);       ///< in its cell, of these
        std::vector<std::uint32_t> joined(places.size());
        for (std::uint32_t i = 0; i < places.size(); ++i) {
            const std::array<double, 3>& place = places[i];
            std::array<double, 3> low{};
            std::array<double, 3> high{};
            std::array<double, 3> own{};
            for (int axis = 0; axis < 3; ++axis) {
                const double from = place[axis] - _min[axis];
                low[axis] = std::floor((from - tolerance) / cell);
                high[axis] = std::floor((from + tolerance) / cell);
                own[axis] = std::floor(from / cell);
            }
            std::uint32_t first = i;
            for (double x = low[0]; x <= high[0]; ++x) {
                for (double y = low[1]; y <= high[1]; ++y) {
                    for (double z = low[2]; z <= high[2]; ++z) {
                        const auto found = lastOfCell.find(HashPlace({x, y, z}));
                        std::uint32_t other = found != lastOfCell.end() ? found->second : kNone;
                        for (; other != kNone; other = next[other]) {
                            const double distance =
                                std::hypot(place[0] - places[other][0], place[1] - places[other][1],
                                           place[2] - places[other][2]);
                            if (distance <= tolerance && other < first) {
                                first = other;
                            }
                        }
                    }
                }
            }
            joined[i] = first;
            if (first == i) {
                const auto [head, isNew] = lastOfCell.emplace(HashPlace(own), i);
                next[i] = isNew ? kNone : std::exchange(head->second, i);
            }
        }
        return joined;
    }

    const GeometryDescription& _mesh;
    std::vector<bool> _isHole; ///< by face
    std::vector<LooseEdge> _loose;
    std::array<double, 3> _min = {kFar, kFar, kFar}; ///< of the points of faces
    std::array<double, 3> _max = {-kFar, -kFar, -kFar};

    static constexpr double kFar = std::numeric_limits<double>::max();
};

/// What IsClosed reads of geometry, in memory.
std::shared_ptr<const GeometryDescription> HoldFaces(const GeometryDescription& geometry) {
    auto held = std::make_shared<GeometryDescription>();
    held->points = geometry.points.Held();
    held->faceVertexCounts = geometry.faceVertexCounts.Held();
    held->faceVertexIndices = geometry.faceVertexIndices.Held();
    held->holeIndices = geometry.holeIndices.Held();
    return held;
}

} // namespace

bool IsClosed(const GeometryDescription& mesh) {
    return HoleFinder(mesh).IsClosed();
}

void ClosedMeshes::Ask(const std::shared_ptr<const GeometryDescription>& geometry) {
    _states.try_emplace(geometry);
}

std::shared_ptr<const void>
ClosedMeshes::Look(const std::shared_ptr<const GeometryDescription>& geometry) {
    const auto found = _states.find(geometry);
    if (found == _states.end() || found->second.isTaken.exchange(true)) {
        return nullptr;
    }
    State& state = found->second;
    try {
        auto held = HoldFaces(*geometry);
        state.isClosed = hds::IsClosed(*held);
        state.isKnown = true;
        return held;
    } catch (...) {
        state.isTaken = false; // the next commit tries again
        throw;
    }
}

void ClosedMeshes::LookAtOthers() {
    std::vector<std::shared_ptr<const GeometryDescription>> others;
    for (auto state = _states.begin(); state != _states.end();) {
        auto geometry = state->first.lock();
        const bool isGone = geometry == nullptr;
        if (!isGone && !state->second.isKnown) {
            others.push_back(std::move(geometry));
        }
        state = isGone ? _states.erase(state) : std::next(state);
    }
    tbb::parallel_for(std::size_t{0}, others.size(), [&](std::size_t i) {
        Look(others[i]);
        DropArrays(*others[i]);
    });
}

bool ClosedMeshes::IsClosed(const std::shared_ptr<const GeometryDescription>& geometry) const {
    return _states.at(geometry).isClosed;
}

} // namespace hds
