// SPDX-License-Identifier: Apache-2.0
// A copy of a render buffer's pixels. Row 0 is the lowest, as in render buffers.
#pragma once

#include <pxr/imaging/hd/renderBuffer.h>
#include <pxr/imaging/hd/types.h>

#include <cstdint>
#include <vector>

namespace hydraHost {

PXR_NAMESPACE_USING_DIRECTIVE

struct Image {
    int width = 0;
    int height = 0;
    HdFormat format = HdFormatInvalid;
    std::vector<std::uint8_t> bytes;

    /// A component as a float, of the 8-bit, half and float formats.
    float Float(int x, int y, int component = 0) const;
    /// A pixel of Int32.
    std::int32_t Int(int x, int y) const;

    bool operator==(const Image& other) const {
        return width == other.width && height == other.height && format == other.format &&
               bytes == other.bytes;
    }
    bool operator!=(const Image& other) const { return !(*this == other); }
};

/// Maps, copies and unmaps.
Image ReadBuffer(HdRenderBuffer* buffer);

} // namespace hydraHost
