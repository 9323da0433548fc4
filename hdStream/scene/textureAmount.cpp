// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/textureAmount.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hds {

namespace {

double Finite(double value) {
    return std::isfinite(value) ? value : 0.0;
}

/// Index of a texel along an axis, or -1 for the black border.
std::int64_t WrapTexel(double index, std::uint32_t size, std::uint32_t wrap) {
    const auto period = [&](double length) { return index - std::floor(index / length) * length; };
    switch (wrap) {
    case HDS_WRAP_REPEAT:
        return static_cast<std::int64_t>(period(size));
    case HDS_WRAP_MIRROR: {
        const auto folded = static_cast<std::int64_t>(period(2.0 * size));
        return folded < size ? folded : 2 * std::int64_t{size} - 1 - folded;
    }
    case HDS_WRAP_CLAMP:
        return static_cast<std::int64_t>(std::clamp(index, 0.0, size - 1.0));
    default:
        return index >= 0.0 && index < size ? static_cast<std::int64_t>(index) : -1;
    }
}

class TextureAmount : public DisplacementAmount {
public:
    TextureAmount(std::string primvar, DisplacementLookup lookup) : _lookup(std::move(lookup)) {
        if (!primvar.empty()) {
            _primvars.push_back(
                {{std::move(primvar)}, 2, {_lookup.missing[0], _lookup.missing[1]}});
        }
        const AmountRange heights = RangeOfHeights(*_lookup.image, _lookup.wrapS, _lookup.wrapT);
        const double a = Finite(Scaled(heights.low));
        const double b = Finite(Scaled(heights.high));
        _range = {std::min(a, b), std::max(a, b)};
    }

    const std::vector<AmountPrimvar>& Primvars() const override { return _primvars; }
    double At(const AmountPoint& point) const override {
        const std::array<double, 6>& m = _lookup.rows;
        const std::array<double, 4> at =
            _primvars.empty()
                ? std::array<double, 4>{_lookup.missing[0], _lookup.missing[1], 0.0, 0.0}
                : point.primvars[0];
        const double s = m[0] * at[0] + m[1] * at[1] + m[2];
        const double t = m[3] * at[0] + m[4] * at[1] + m[5];
        return Finite(Scaled(LookUpHeight(*_lookup.image, _lookup.wrapS, _lookup.wrapT, s, t)));
    }
    AmountRange Over(const AmountBox&) const override { return _range; }

private:
    double Scaled(double value) const {
        return value * static_cast<double>(_lookup.scale) + static_cast<double>(_lookup.bias);
    }

    std::vector<AmountPrimvar> _primvars;
    DisplacementLookup _lookup;
    AmountRange _range;
};

} // namespace

double LookUpHeight(const HeightImage& image, std::uint32_t wrapS, std::uint32_t wrapT, double s,
                    double t) {
    const double x = Finite(s) * image.width - 0.5;
    const double y = (1.0 - Finite(t)) * image.height - 0.5;
    const double x0 = std::floor(x);
    const double y0 = std::floor(y);
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) {
        const std::int64_t column = WrapTexel(x0 + (k & 1), image.width, wrapS);
        const std::int64_t row = WrapTexel(y0 + (k >> 1), image.height, wrapT);
        if (column >= 0 && row >= 0) {
            const double weightX = (k & 1) != 0 ? x - x0 : 1.0 - (x - x0);
            const double weightY = (k & 2) != 0 ? y - y0 : 1.0 - (y - y0);
            const auto index =
                static_cast<std::size_t>(row) * image.width + static_cast<std::size_t>(column);
            sum += weightX * weightY * static_cast<double>(image.values[index]);
        }
    }
    return sum;
}

AmountRange RangeOfHeights(const HeightImage& image, std::uint32_t wrapS, std::uint32_t wrapT) {
    const auto [low, high] = std::minmax_element(image.values.begin(), image.values.end());
    const bool hasBorder = wrapS == HDS_WRAP_BLACK || wrapT == HDS_WRAP_BLACK;
    const auto least = static_cast<double>(*low);
    const auto most = static_cast<double>(*high);
    return {hasBorder ? std::min(least, 0.0) : least, hasBorder ? std::max(most, 0.0) : most};
}

std::shared_ptr<const DisplacementAmount> MakeTextureAmount(std::string primvar,
                                                            DisplacementLookup lookup) {
    return std::make_shared<TextureAmount>(std::move(primvar), std::move(lookup));
}

} // namespace hds
