// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/displacement.h"

#include "hdStream/geometry/primvars.h"

#include <algorithm>
#include <cmath>

namespace hds {
namespace {

double Finite(double value) {
    return std::isfinite(value) ? value : 0.0;
}

class ConstantAmount : public DisplacementAmount {
public:
    explicit ConstantAmount(double amount) : _amount(Finite(amount)) {}
    const std::string& Primvar() const override { return _primvar; }
    std::uint32_t NumComponents() const override { return 0; }
    double At(const double*) const override { return _amount; }
    AmountRange Over(const double*, const double*) const override { return {_amount, _amount}; }
    double Fallback() const override { return _amount; }

private:
    std::string _primvar;
    double _amount;
};

class PrimvarAmount : public DisplacementAmount {
public:
    PrimvarAmount(std::string primvar, double fallback)
        : _primvar(std::move(primvar)), _fallback(Finite(fallback)) {}
    const std::string& Primvar() const override { return _primvar; }
    std::uint32_t NumComponents() const override { return 1; }
    double At(const double* value) const override { return value[0]; }
    AmountRange Over(const double* low, const double* high) const override {
        return {low[0], high[0]};
    }
    double Fallback() const override { return _fallback; }

private:
    std::string _primvar;
    double _fallback;
};

/// The amount of an element of its primvar.
double AmountAt(const BoundAmount& bound, const std::vector<GeometryAttribute>& attributes,
                std::size_t element) {
    if (bound.amount == nullptr) {
        return bound.constant;
    }
    const GeometryAttribute& attribute = attributes[bound.attribute];
    const float* from = ValueOf(attribute, element);
    double value[4] = {};
    std::transform(from, from + attribute.numComponents, value, Finite);
    return bound.amount->At(value);
}

AmountRange RangeOver(const DisplacementAmount& amount, const GeometryAttribute& attribute) {
    double low[4] = {1e300, 1e300, 1e300, 1e300};
    double high[4] = {-1e300, -1e300, -1e300, -1e300};
    for (std::size_t i = 0; i < attribute.values.size(); ++i) {
        const double value = Finite(attribute.values[i]);
        const std::size_t c = i % attribute.numComponents;
        low[c] = std::min(low[c], value);
        high[c] = std::max(high[c], value);
    }
    return amount.Over(low, high);
}

} // namespace

std::shared_ptr<const DisplacementAmount> MakeConstantAmount(double amount) {
    return std::make_shared<ConstantAmount>(amount);
}

std::shared_ptr<const DisplacementAmount> MakePrimvarAmount(std::string primvar, double fallback) {
    return std::make_shared<PrimvarAmount>(std::move(primvar), fallback);
}

std::vector<BoundAmount> BindAmounts(const Displacement& displacement,
                                     const std::vector<GeometryAttribute>& attributes) {
    std::vector<BoundAmount> result;
    for (const auto& amount : displacement) {
        BoundAmount& bound = result.emplace_back();
        if (!amount) {
            continue;
        }
        bound.constant = amount->Fallback();
        const auto found = std::find_if(attributes.begin(), attributes.end(),
                                        [&](const GeometryAttribute& attribute) {
                                            return attribute.name == amount->Primvar();
                                        });
        if (found != attributes.end() && !found->values.empty() && amount->NumComponents() > 0 &&
            found->numComponents >= amount->NumComponents()) {
            bound.amount = amount.get();
            bound.attribute = std::size_t(found - attributes.begin());
        }
    }
    return result;
}

AmountRange RangeOf(const std::vector<BoundAmount>& amounts,
                    const std::vector<GeometryAttribute>& attributes, bool hasOthers) {
    if (amounts.empty()) {
        return {};
    }
    AmountRange range{1e300, -1e300};
    const auto add = [&](const AmountRange& other) {
        range.low = std::min(range.low, other.low);
        range.high = std::max(range.high, other.high);
    };
    for (const BoundAmount& bound : amounts) {
        add(bound.amount == nullptr ? AmountRange{bound.constant, bound.constant}
                                    : RangeOver(*bound.amount, attributes[bound.attribute]));
    }
    if (hasOthers) {
        add({});
    }
    return range;
}

std::vector<float> PointAmounts(const GeometryDescription& mesh,
                                const std::vector<std::uint32_t>& entries,
                                const std::vector<GeometryAttribute>& attributes,
                                const Displacement& displacement) {
    const std::vector<BoundAmount> amounts = BindAmounts(displacement, attributes);
    const std::size_t numPoints = mesh.points.size() / 3;
    std::vector<double> sums(numPoints);
    std::vector<std::uint32_t> counts(numPoints);
    std::size_t corner = 0;
    for (std::size_t face = 0; face < mesh.faceVertexCounts.size(); ++face) {
        const std::uint32_t entry = entries.empty() ? 0 : entries[face];
        const auto end = corner + std::size_t(std::max(mesh.faceVertexCounts[face], 0));
        for (; corner < end && corner < mesh.faceVertexIndices.size(); ++corner) {
            const std::int32_t point = mesh.faceVertexIndices[corner];
            if (point < 0 || std::size_t(point) >= numPoints) {
                continue;
            }
            ++counts[point];
            if (entry >= amounts.size()) {
                continue;
            }
            const BoundAmount& bound = amounts[entry];
            std::size_t element = 0;
            if (bound.amount != nullptr) {
                const Interpolation interpolation = attributes[bound.attribute].interpolation;
                element = interpolation == Interpolation::Uniform       ? face
                          : interpolation == Interpolation::FaceVarying ? corner
                          : interpolation == Interpolation::Constant    ? 0
                                                                        : std::size_t(point);
            }
            sums[point] += AmountAt(bound, attributes, element);
        }
        corner = end;
    }
    std::vector<float> result(numPoints);
    for (std::size_t point = 0; point < numPoints; ++point) {
        result[point] = counts[point] > 0 ? float(sums[point] / counts[point]) : 0.0F;
    }
    return result;
}

} // namespace hds
