// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/primvars.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cmath>
#include <functional>
#include <memory>

namespace hds {

namespace {

/// Number of entries of a span for which isBad holds; parallel.
template <typename T, typename IsBad>
std::size_t CountIf(const SharedSpan<T>& values, IsBad isBad) {
    using Range = tbb::blocked_range<std::size_t>;
    return tbb::parallel_reduce(
        Range(0, values.size(), 65536), std::size_t(0),
        [&](const Range& range, std::size_t count) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                count += isBad(values[i]) ? 1 : 0;
            }
            return count;
        },
        std::plus<>());
}

/// The first `size` entries of a span, sharing its owner.
SharedSpan<float> FirstOf(const SharedSpan<float>& values, std::size_t size) {
    return {values.data(), size, std::make_shared<const SharedSpan<float>>(values)};
}

} // namespace

std::size_t NumElements(Interpolation interpolation, const TopologySize& size) {
    switch (interpolation) {
    case Interpolation::Uniform:
        return size.numFaces;
    case Interpolation::Varying:
        return size.hasJoints ? size.numJoints : size.numPoints;
    case Interpolation::Vertex:
        return size.numPoints;
    case Interpolation::FaceVarying:
        return size.numCorners;
    case Interpolation::Constant:
    case Interpolation::Instance:
        break;
    }
    return 1;
}

std::optional<GeometryAttribute> ValidatePrimvar(const Primvar& primvar, const TopologySize& size,
                                                 const std::string& primPath, Warnings& warnings) {
    const std::string label = "primvar \"" + primvar.name + "\"";
    const auto ignore = [&](const std::string& reason) {
        warnings.Add(primPath, label + " ignored: " + reason);
        return std::nullopt;
    };
    const std::size_t numComponents = primvar.numComponents;
    if (numComponents < 1 || numComponents > 4) {
        return ignore(std::to_string(numComponents) + " components, 1 to 4 are supported");
    }
    if (primvar.values.size() % numComponents != 0) {
        return ignore(std::to_string(primvar.values.size()) + " floats are not a multiple of " +
                      std::to_string(numComponents));
    }
    const std::size_t numValues = primvar.values.size() / numComponents;
    const bool isIndexed = !primvar.indices.empty();
    const std::size_t numGiven = isIndexed ? primvar.indices.size() : numValues;
    const std::size_t numNeeded = NumElements(primvar.interpolation, size);
    const bool isConstant = primvar.interpolation == Interpolation::Constant;
    if (isConstant ? numGiven == 0 : numGiven != numNeeded) {
        return ignore(std::string(TextOf(primvar.interpolation)) + " needs " +
                      std::to_string(numNeeded) + " values, has " + std::to_string(numGiven));
    }
    const std::size_t numBadIndices = CountIf(primvar.indices, [&](std::int32_t index) {
        return index < 0 || static_cast<std::size_t>(index) >= numValues;
    });
    if (numBadIndices > 0) {
        return ignore(std::to_string(numBadIndices) + " indices out of range");
    }

    GeometryAttribute attribute;
    attribute.name = primvar.name;
    attribute.interpolation = primvar.interpolation == Interpolation::Varying && !size.hasJoints
                                  ? Interpolation::Vertex
                                  : primvar.interpolation;
    attribute.numComponents = primvar.numComponents;
    attribute.values = primvar.values;
    attribute.indices = primvar.indices;
    if (isConstant && numGiven > 1) {
        warnings.Add(primPath, label + ": constant with " + std::to_string(numGiven) +
                                   " values, the first is used");
        if (isIndexed) {
            const float* first = ValueOf(attribute, 0);
            attribute.values = std::vector<float>(first, first + numComponents);
            attribute.indices = {};
        } else {
            attribute.values = FirstOf(primvar.values, numComponents);
        }
    }
    return attribute;
}

void WarnNotFinite(const GeometryAttribute& attribute, const std::string& primPath,
                   Warnings& warnings) {
    const std::size_t numNotFinite =
        CountIf(attribute.values, [](float value) { return !std::isfinite(value); });
    if (numNotFinite > 0) {
        warnings.Add(primPath, "primvar \"" + attribute.name +
                                   "\": " + std::to_string(numNotFinite) +
                                   " floats are not finite, read as 0");
    }
}

} // namespace hds
