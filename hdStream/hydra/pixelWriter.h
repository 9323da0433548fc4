// SPDX-License-Identifier: Apache-2.0
// Pixels of the core's layers in the formats of Hydra's render buffers.
#pragma once

#include <pxr/imaging/hd/types.h>
#include <pxr/pxr.h>

#include <array>
#include <cstddef>
#include <cstdint>

PXR_NAMESPACE_OPEN_SCOPE

/// A pixel before conversion: floats, or one integer.
struct HdStreamPixel {
    std::array<float, 4> values{};
    std::int32_t id = 0;
    bool isInteger = false;
};

/// True for the formats that HdStreamWritePixel knows.
bool HdStreamIsWritableFormat(HdFormat format);

/// Writes pixels one after the other. Components beyond the format's are dropped; normalised
/// formats clamp, integer ones round. An integer in a format of four bytes keeps its bits (picking
/// reads them so). Precondition: the format is writable.
void HdStreamWritePixels(HdFormat format, const HdStreamPixel* pixels, std::size_t count,
                         void* target);

PXR_NAMESPACE_CLOSE_SCOPE
