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
        _orientations = ValuesOf(kSplatOrientations, 4, count);
        _scales = ValuesOf(kSplatScales, 3, count);
        _opacities = ValuesOf(kSplatOpacities, 1, count);
        CollectPrimvars(count);
        Measure(kVertexFloats, "no scale or orientation, or an opacity below 1/255");
    }

private:
    bool IsSeen(std::uint32_t group) const override { return ShapeOf(group).has_value(); }

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

    float OpacityOf(std::uint32_t group) const {
        const float opacity = _opacities.empty() ? 1.0F : _opacities[group];
        return std::isfinite(opacity) ? std::clamp(opacity, 0.0F, 1.0F) : 0.0F;
    }

    /// Nothing: it cannot be seen.
    std::optional<SplatShape> ShapeOf(std::uint32_t group) const {
        SplatShape shape;
        const double opacity = OpacityOf(group);
        const double cutoff = 2.0 * std::log(opacity / double{HDS_SPLAT_LEAST_ALPHA});
        if (!(cutoff > 0.0)) {
            return std::nullopt;
        }
        shape.cutoff = static_cast<float>(cutoff);
        shape.turn = {0.0F, 0.0F, 0.0F, 1.0F};
        if (!_orientations.empty()) {
            const float* from = _orientations.data() + std::size_t{4} * group;
            const glm::dvec4 turn(from[0], from[1], from[2], from[3]);
            const double length = glm::length(turn);
            if (!(length > 0.0) || !std::isfinite(length)) {
                return std::nullopt;
            }
            for (int i = 0; i < 4; ++i) {
                shape.turn[i] = static_cast<float>(turn[i] / length);
            }
        }
        std::array<float, 3> scales = {1.0F, 1.0F, 1.0F};
        if (!_scales.empty()) {
            const float* from = _scales.data() + std::size_t{3} * group;
            std::transform(from, from + 3, scales.begin(), [](float x) { return std::fabs(x); });
        }
        const float greatest = std::max({scales[0], scales[1], scales[2]});
        for (int i = 0; i < 3; ++i) {
            if (!(greatest > 0.0F) || !(scales[i] < kMaxCoordinate)) {
                return std::nullopt;
            }
            shape.inverseScales[i] = 1.0F / std::max(scales[i], kLeastPart * greatest);
        }
        return shape;
    }

    /// Half the box of the ellipsoid where it ends.
    static glm::dvec3 ReachOf(const SplatShape& shape) {
        const glm::dquat turn(shape.turn[3], shape.turn[0], shape.turn[1], shape.turn[2]);
        const glm::dmat3 axes = glm::mat3_cast(turn);
        glm::dvec3 squares(0.0);
        for (int i = 0; i < 3; ++i) {
            const glm::dvec3 axis = axes[i] / static_cast<double>(shape.inverseScales[i]);
            squares += axis * axis;
        }
        return glm::sqrt(static_cast<double>(shape.cutoff) * squares);
    }

    void Extend(std::uint32_t group, std::size_t pose, Bounds* bounds) const override {
        // Kernels measure distances in float, in units that differ from axis to axis.
        constexpr double kPart = 1.0 + 1e-4;
        const glm::dvec3 centre = CentreAt(pose, group);
        const glm::dvec3 reach = kPart * ReachOf(*ShapeOf(group));
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
    float ValueAt(std::size_t /*pose*/, std::uint32_t group) const override {
        return OpacityOf(group);
    }
    void AddShape(std::uint32_t group, ChunkGeometry* chunk) const override {
        chunk->shapes.push_back(*ShapeOf(group));
    }

    SharedSpan<float> _orientations; ///< empty: not turned
    SharedSpan<float> _scales;       ///< empty: 1
    SharedSpan<float> _opacities;    ///< empty: 1
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
