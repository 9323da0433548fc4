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
    TextureAmount(std::string primvar, DisplacementLookup lookup)
        : _primvar(std::move(primvar)), _lookup(std::move(lookup)) {
        const std::vector<float>& values = _lookup.image->values;
        const auto [low, high] = std::minmax_element(values.begin(), values.end());
        double least = *low;
        double most = *high;
        if (_lookup.wrapS == HDS_WRAP_BLACK || _lookup.wrapT == HDS_WRAP_BLACK) {
            least = std::min(least, 0.0);
            most = std::max(most, 0.0);
        }
        const double a = Finite(Scaled(least));
        const double b = Finite(Scaled(most));
        _range = {std::min(a, b), std::max(a, b)};
    }

    const std::string& Primvar() const override { return _primvar; }
    std::uint32_t NumComponents() const override { return _primvar.empty() ? 0 : 2; }
    double At(const double* value) const override {
        const std::array<double, 6>& m = _lookup.rows;
        const double s = Finite(m[0] * value[0] + m[1] * value[1] + m[2]);
        const double t = Finite(m[3] * value[0] + m[4] * value[1] + m[5]);
        return Finite(Scaled(Bilinear(s, t)));
    }
    AmountRange Over(const double*, const double*) const override { return _range; }
    double Fallback() const override {
        const double missing[2] = {_lookup.missing[0], _lookup.missing[1]};
        return At(missing);
    }

private:
    double Scaled(double value) const {
        return value * static_cast<double>(_lookup.scale) + static_cast<double>(_lookup.bias);
    }

    double Bilinear(double s, double t) const {
        const HeightImage& image = *_lookup.image;
        const double x = s * image.width - 0.5;
        const double y = (1.0 - t) * image.height - 0.5;
        const double x0 = std::floor(x);
        const double y0 = std::floor(y);
        double sum = 0.0;
        for (int k = 0; k < 4; ++k) {
            const std::int64_t column = WrapTexel(x0 + (k & 1), image.width, _lookup.wrapS);
            const std::int64_t row = WrapTexel(y0 + (k >> 1), image.height, _lookup.wrapT);
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

    std::string _primvar;
    DisplacementLookup _lookup;
    AmountRange _range;
};

} // namespace

std::shared_ptr<const DisplacementAmount> MakeTextureAmount(std::string primvar,
                                                            DisplacementLookup lookup) {
    return std::make_shared<TextureAmount>(std::move(primvar), std::move(lookup));
}

} // namespace hds
