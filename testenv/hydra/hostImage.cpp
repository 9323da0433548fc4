// SPDX-License-Identifier: Apache-2.0
// Pixels of render buffers, decoded.
#include "hostImage.h"

#include <pxr/base/gf/half.h>
#include <pxr/base/tf/diagnostic.h>

#include <cstring>

namespace hydraHost {

float Image::Float(int x, int y, int component) const {
    const std::uint8_t* pixel =
        bytes.data() + (size_t(y) * size_t(width) + size_t(x)) * HdDataSizeOfFormat(format);
    switch (HdGetComponentFormat(format)) {
    case HdFormatUNorm8:
        return float(pixel[component]) / 255.0F;
    case HdFormatFloat16: {
        GfHalf value;
        std::memcpy(&value, pixel + size_t(component) * sizeof(value), sizeof(value));
        return value;
    }
    case HdFormatFloat32: {
        float value = 0.0F;
        std::memcpy(&value, pixel + size_t(component) * sizeof(value), sizeof(value));
        return value;
    }
    default:
        TF_CODING_ERROR("not a format of floats: %d", int(format));
        return 0.0F;
    }
}

std::int32_t Image::Int(int x, int y) const {
    std::int32_t value = 0;
    if (TF_VERIFY(format == HdFormatInt32)) {
        std::memcpy(&value, bytes.data() + (size_t(y) * size_t(width) + size_t(x)) * sizeof(value),
                    sizeof(value));
    }
    return value;
}

Image ReadBuffer(HdRenderBuffer* buffer) {
    Image image;
    image.width = int(buffer->GetWidth());
    image.height = int(buffer->GetHeight());
    image.format = buffer->GetFormat();
    const size_t numBytes =
        size_t(image.width) * size_t(image.height) * HdDataSizeOfFormat(image.format);
    if (const auto* pixels = static_cast<const std::uint8_t*>(buffer->Map())) {
        image.bytes.assign(pixels, pixels + numBytes);
    }
    buffer->Unmap();
    return image;
}

} // namespace hydraHost
