// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/pixelWriter.h"

#include <pxr/base/gf/half.h>
#include <pxr/base/tf/diagnostic.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// The nearest value that the type holds; NaN becomes 0.
template <typename Item>
Item Round(float value) {
    if (std::isnan(value)) {
        return 0;
    }
    const double low = std::numeric_limits<Item>::lowest();
    const double high = std::numeric_limits<Item>::max();
    return static_cast<Item>(std::clamp(std::nearbyint(static_cast<double>(value)), low, high));
}

template <typename Item, bool isNormalised>
Item Convert(const HdStreamPixel& pixel, std::size_t component) {
    if (pixel.isInteger && component == 0) {
        if constexpr (std::is_integral_v<Item> && !isNormalised) {
            return static_cast<Item>(std::clamp<std::int64_t>(
                pixel.id, std::numeric_limits<Item>::lowest(), std::numeric_limits<Item>::max()));
        }
    }
    const float value = pixel.isInteger ? (component == 0 ? static_cast<float>(pixel.id) : 0.0F)
                                        : pixel.values[component];
    if constexpr (isNormalised) {
        const float scale = static_cast<float>(std::numeric_limits<Item>::max());
        const float low = std::is_signed_v<Item> ? -1.0F : 0.0F;
        return Round<Item>(std::clamp(std::isnan(value) ? 0.0F : value, low, 1.0F) * scale);
    } else if constexpr (std::is_integral_v<Item>) {
        return Round<Item>(value);
    } else {
        return static_cast<Item>(value);
    }
}

template <typename Item, bool isNormalised>
void Write(const HdStreamPixel* pixels, std::size_t count, std::size_t numComponents,
           void* target) {
    auto* items = static_cast<Item*>(target);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t c = 0; c < numComponents; ++c) {
            *items++ = Convert<Item, isNormalised>(pixels[i], c);
        }
    }
}

void WriteBits(const HdStreamPixel* pixels, std::size_t count, void* target) {
    auto* bytes = static_cast<unsigned char*>(target);
    for (std::size_t i = 0; i < count; ++i, bytes += sizeof(std::int32_t)) {
        std::memcpy(bytes, &pixels[i].id, sizeof(std::int32_t));
    }
}

void WriteDepthStencil(const HdStreamPixel* pixels, std::size_t count, void* target) {
    auto* bytes = static_cast<unsigned char*>(target);
    const std::size_t stride = HdDataSizeOfFormat(HdFormatFloat32UInt8);
    for (std::size_t i = 0; i < count; ++i, bytes += stride) {
        std::memset(bytes, 0, stride);
        std::memcpy(bytes, pixels[i].values.data(), sizeof(float));
    }
}

} // namespace

bool HdStreamIsWritableFormat(HdFormat format) {
    return format > HdFormatInvalid && format < HdFormatCount;
}

void HdStreamWritePixels(HdFormat format, const HdStreamPixel* pixels, std::size_t count,
                         void* target) {
    if (count == 0) {
        return;
    }
    if (format == HdFormatFloat32UInt8) {
        WriteDepthStencil(pixels, count, target);
        return;
    }
    const std::size_t numComponents = HdGetComponentCount(format);
    switch (HdGetComponentFormat(format)) {
    case HdFormatUNorm8:
        if (pixels->isInteger && numComponents == 4) {
            WriteBits(pixels, count, target);
        } else {
            Write<std::uint8_t, true>(pixels, count, numComponents, target);
        }
        break;
    case HdFormatSNorm8:
        Write<std::int8_t, true>(pixels, count, numComponents, target);
        break;
    case HdFormatFloat16:
        Write<GfHalf, false>(pixels, count, numComponents, target);
        break;
    case HdFormatFloat32:
        Write<float, false>(pixels, count, numComponents, target);
        break;
    case HdFormatInt16:
        Write<std::int16_t, false>(pixels, count, numComponents, target);
        break;
    case HdFormatUInt16:
        Write<std::uint16_t, false>(pixels, count, numComponents, target);
        break;
    case HdFormatInt32:
        Write<std::int32_t, false>(pixels, count, numComponents, target);
        break;
    default:
        TF_CODING_ERROR("format %d of a render buffer is not known", static_cast<int>(format));
        break;
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
