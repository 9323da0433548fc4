// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/splatSource.h"

#include "hdStream/geometry/particleSource.h"
#include "kernels/shared/geometry.h"
#include "kernels/shared/splat.h"

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

namespace hds {
namespace {

/// The least scale is this part of the greatest: floats can invert no thinner ones.
constexpr float kLeastPart = 1e-4F;

/// Floats of a shape and its centre in a page.
constexpr std::size_t kVertexFloats = 12;

const Primvar* FindPrimvar(const GeometryDescription& splats, const char* name) {
    const auto found = std::find_if(splats.primvars.begin(), splats.primvars.end(),
                                    [&](const Primvar& primvar) { return primvar.name == name; });
    return found == splats.primvars.end() ? nullptr : &*found;
}

class SplatSource final : public ParticleSource {
public:
    SplatSource(std::shared_ptr<const GeometryDescription> splats, const std::string& primPath,
                Warnings& warnings)
        : ParticleSource(std::move(splats), HDS_PRIMITIVE_SPLATS, "splats", primPath, warnings) {
        if (!CanNumber()) {
            return;
        }
        const std::size_t count = Count();
        _orientations = PosesOf(kSplatOrientations, 4, count, &ShutterKey::orientations);
        _scales = PosesOf(kSplatScales, 3, count, &ShutterKey::scales);
        _opacities = PosesOf(kSplatOpacities, 1, count, &ShutterKey::opacities);
        _shapesMove = _orientations.size() + _scales.size() + _opacities.size() > 3;
        _kind |= _shapesMove ? HDS_PRIMITIVE_SHAPES_MOVE : 0U;
        CollectPrimvars(count);
        Measure(kVertexFloats, _shapesMove ? kVertexFloats : 4,
                "no scale or orientation, or an opacity below 1/255");
    }

private:
    using Poses = std::vector<SharedSpan<float>>; ///< one: in all poses

    bool IsSeen(std::uint32_t group) const override {
        float opacity = 0.0F;
        float size = 0.0F;
        for (std::size_t pose = 0; pose < NumShapes(); ++pose) {
            const std::optional<SplatShape> shape = ShapeOf(pose, group);
            if (!shape) {
                return false;
            }
            opacity = std::max(opacity, OpacityOf(pose, group));
            size = std::max({size, shape->sizes[0], shape->sizes[1], shape->sizes[2]});
        }
        return size > 0.0F && CutoffOf(opacity) > 0.0;
    }

    /// Poses in which shapes may differ.
    std::size_t NumShapes() const { return _shapesMove ? NumPoses() : 1; }

    static const SharedSpan<float>& At(const Poses& poses, std::size_t pose) {
        return poses[std::min(pose, poses.size() - 1)];
    }

    /// The primvar, and in later poses what the keys have.
    Poses PosesOf(const char* name, std::uint32_t numComponents, std::size_t count,
                  SharedSpan<float> ShutterKey::*member) {
        Poses poses{ValuesOf(name, numComponents, count)};
        for (const ShutterKey& key : _particles->keys) {
            if (!poses[0].empty() && (key.*member).size() == poses[0].size()) {
                poses.push_back(key.*member);
            }
        }
        return poses;
    }

    /// Values of a primvar of all splats; empty, where there is no such primvar, or too few values,
    /// with a line: the schema's fallback.
    SharedSpan<float> ValuesOf(const char* name, std::uint32_t numComponents, std::size_t count) {
        const Primvar* primvar = FindPrimvar(*_particles, name);
        if (primvar == nullptr || primvar->values.empty()) {
            return {};
        }
        if (primvar->numComponents != numComponents || !primvar->indices.empty() ||
            primvar->values.size() < count * numComponents) {
            _log.Warn(std::string(name) + " ignored: they need " + std::to_string(count) + " x " +
                      std::to_string(numComponents) + " numbers, have " +
                      std::to_string(primvar->values.size() / primvar->numComponents) + " x " +
                      std::to_string(primvar->numComponents));
            return {};
        }
        return primvar->values;
    }

    /// What pages hold: the coefficients alone.
    void CollectPrimvars(std::size_t count) {
        const std::optional<std::uint32_t> degree = SplatDegree(*_particles);
        if (!degree) {
            _log.Warn(std::string(kSplatDegree) + " is none from 0 to 3: the splats are grey");
            return;
        }
        const std::uint32_t numTuples = (*degree + 1) * (*degree + 1);
        GeometryAttribute harmonics;
        harmonics.name = kSplatHarmonics;
        harmonics.interpolation = Interpolation::Vertex;
        harmonics.numComponents = 3;
        harmonics.numTuples = numTuples;
        harmonics.values = ValuesOf(kSplatHarmonics, 3, count * numTuples);
        if (!harmonics.values.empty()) {
            _attributes.push_back({harmonics.name, harmonics.numComponents});
            _values.push_back(std::move(harmonics));
        }
    }

    float OpacityOf(std::size_t pose, std::uint32_t group) const {
        const SharedSpan<float>& opacities = At(_opacities, pose);
        const float opacity = opacities.empty() ? 1.0F : opacities[group];
        return std::isfinite(opacity) ? std::clamp(opacity, 0.0F, 1.0F) : 0.0F;
    }

    static double CutoffOf(double opacity) {
        return 2.0 * std::log(opacity / double{HDS_SPLAT_LEAST_ALPHA});
    }

    /// With scales as they are. Nothing: it is not drawn.
    std::optional<SplatShape> ShapeOf(std::size_t pose, std::uint32_t group) const {
        SplatShape shape;
        shape.cutoff = std::max(0.0F, static_cast<float>(CutoffOf(OpacityOf(pose, group))));
        shape.turn = {0.0F, 0.0F, 0.0F, 1.0F};
        if (const SharedSpan<float>& orientations = At(_orientations, pose);
            !orientations.empty()) {
            const float* from = orientations.data() + std::size_t{4} * group;
            const glm::dvec4 turn(from[0], from[1], from[2], from[3]);
            const double length = glm::length(turn);
            if (!(length > 0.0) || !std::isfinite(length)) {
                return std::nullopt;
            }
            for (int i = 0; i < 4; ++i) {
                shape.turn[i] = static_cast<float>(turn[i] / length);
            }
        }
        shape.sizes = {1.0F, 1.0F, 1.0F};
        if (const SharedSpan<float>& scales = At(_scales, pose); !scales.empty()) {
            const float* from = scales.data() + std::size_t{3} * group;
            std::transform(from, from + 3, shape.sizes.begin(),
                           [](float x) { return std::fabs(x); });
        }
        const float greatest = std::max({shape.sizes[0], shape.sizes[1], shape.sizes[2]});
        for (float& size : shape.sizes) {
            if (!(size < kMaxCoordinate)) {
                return std::nullopt;
            }
            size = std::max(size, kLeastPart * greatest);
        }
        return shape;
    }

    static glm::dquat TurnOf(const SplatShape& shape) {
        return {shape.turn[3], shape.turn[0], shape.turn[1], shape.turn[2]};
    }

    /// Half the box of the ellipsoid within its standard deviations.
    static glm::dvec3 ReachOf(const glm::dquat& turn, const glm::dvec3& sizes) {
        const glm::dmat3 axes = glm::mat3_cast(turn);
        glm::dvec3 squares(0.0);
        for (int i = 0; i < 3; ++i) {
            const glm::dvec3 axis = axes[i] * sizes[i];
            squares += axis * axis;
        }
        return glm::sqrt(squares);
    }

    /// Half a box that holds the ellipsoid, where it ends, in two poses and on the way. It is the
    /// length of a vector for each axis of the box that goes along a circle of at most the greatest
    /// deviation: on arcs of h radians, its length is at most that of the chord's longer end and
    /// h^2 / 8 of that radius.
    static glm::dvec3 ReachBetween(const SplatShape& a, const SplatShape& b) {
        constexpr int kNumArcs = 4;
        const glm::dquat from = TurnOf(a);
        glm::dquat to = TurnOf(b);
        to = glm::dot(from, to) < 0.0 ? -to : to;
        glm::dvec3 sizes(0.0);
        for (int i = 0; i < 3; ++i) {
            sizes[i] = std::max(a.sizes[i], b.sizes[i]);
        }
        glm::dvec3 reach(0.0);
        const bool turns = a.turn != b.turn;
        for (int i = 0; i <= (turns ? kNumArcs : 0); ++i) {
            reach = glm::max(reach, ReachOf(glm::slerp(from, to, i * (1.0 / kNumArcs)), sizes));
        }
        if (turns) {
            const double arc = 2.0 * std::acos(std::min(1.0, glm::dot(from, to))) / kNumArcs;
            reach += arc * arc / 8.0 * std::max({sizes[0], sizes[1], sizes[2]});
        }
        return std::sqrt(double{std::max(a.cutoff, b.cutoff)}) * reach;
    }

    /// Half the box of a pose, so that the boxes between those of two poses hold what is between.
    glm::dvec3 ReachAt(std::size_t pose, std::uint32_t group) const {
        if (!_shapesMove) {
            const SplatShape shape = *ShapeOf(0, group);
            return ReachBetween(shape, shape);
        }
        const SplatShape shape = *ShapeOf(pose, group);
        glm::dvec3 reach(0.0);
        for (const std::size_t other : {pose - 1, pose + 1}) {
            if (other < NumPoses()) {
                reach = glm::max(reach, ReachBetween(shape, *ShapeOf(other, group)));
            }
        }
        return reach;
    }

    void Extend(std::uint32_t group, std::size_t pose, Bounds* bounds) const override {
        // Kernels measure distances in float, in units that differ from axis to axis.
        constexpr double kPart = 1.0 + 1e-4;
        const glm::dvec3 centre = CentreAt(pose, group);
        const glm::dvec3 reach = kPart * ReachAt(pose, group);
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 along(0.0);
            along[axis] = reach[axis];
            Bounds ends;
            ExtendBySolid(centre - along, 0.0, &ends);
            ExtendBySolid(centre + along, 0.0, &ends);
            bounds->min[axis] = std::min(bounds->min[axis], ends.min[axis]);
            bounds->max[axis] = std::max(bounds->max[axis], ends.max[axis]);
        }
    }
    float ValueAt(std::size_t pose, std::uint32_t group) const override {
        return OpacityOf(pose, group);
    }
    void AddShape(std::uint32_t group, ChunkGeometry* chunk) const override {
        SplatShape shape = *ShapeOf(0, group);
        if (!_shapesMove) {
            for (float& size : shape.sizes) {
                size = 1.0F / size;
            }
        }
        chunk->shapes.push_back(shape);
        for (std::size_t pose = 1; _shapesMove && pose < NumPoses(); ++pose) {
            SplatShape later = *ShapeOf(pose, group);
            if (glm::dot(TurnOf(shape), TurnOf(later)) < 0.0) { // kernels go straight
                std::transform(later.turn.begin(), later.turn.end(), later.turn.begin(),
                               std::negate<>());
            }
            chunk->keys[pose - 1].shapes.push_back(later);
            shape = later;
        }
    }

    Poses _orientations; ///< empty arrays: not turned
    Poses _scales;       ///< empty arrays: 1
    Poses _opacities;    ///< empty arrays: 1
    bool _shapesMove = false;
};

} // namespace

std::optional<std::uint32_t> SplatDegree(const GeometryDescription& splats) {
    const Primvar* degree = FindPrimvar(splats, kSplatDegree);
    if (degree == nullptr || degree->values.empty()) {
        return HDS_SPLAT_MAX_DEGREE;
    }
    const float value = degree->values[0];
    if (!(value >= 0.0F && value <= static_cast<float>(HDS_SPLAT_MAX_DEGREE))) {
        return std::nullopt;
    }
    return static_cast<std::uint32_t>(value);
}

std::shared_ptr<const ChunkSource>
MakeSplatSource(std::shared_ptr<const GeometryDescription> splats, const std::string& primPath,
                Warnings& warnings) {
    return std::make_shared<const SplatSource>(std::move(splats), primPath, warnings);
}

} // namespace hds
