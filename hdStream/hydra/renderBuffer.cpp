// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/renderBuffer.h"

#include "hdStream/hydra/floatValues.h"
#include "hdStream/hydra/pictures.h"
#include "hdStream/hydra/pixelWriter.h"
#include "hdStream/session/session.h"

#include <pxr/base/gf/vec3i.h>
#include <pxr/base/tf/diagnostic.h>

#include <algorithm>
#include <cstring>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

const hds::ImageLayer* FindLayer(const hds::FilmImage& image, const std::string& name,
                                 const GfRect2i& window) {
    for (const hds::ImageLayer& layer : image.layers) {
        if (layer.name == name) {
            const bool fits = static_cast<int>(layer.width) == window.GetWidth() &&
                              static_cast<int>(layer.height) == window.GetHeight();
            return fits ? &layer : nullptr;
        }
    }
    return nullptr;
}

/// What a pixel is where nothing is rendered: the binding's clear value, else the AOV's own.
HdStreamPixel ClearPixel(const std::string& aovName, const VtValue& clearValue) {
    const hds::AovInfo* info = hds::FindAov(aovName);
    HdStreamPixel pixel;
    pixel.isInteger = info && info->isInteger;
    pixel.id = info ? info->clearId : 0;
    if (info && !info->isColor) {
        pixel.values.fill(info->clearValue);
    }
    if (clearValue.IsHolding<int>()) {
        pixel.id = clearValue.UncheckedGet<int>();
    } else if (const std::optional<HdStreamFloatRows> rows = HdStreamGetFloatRows(clearValue)) {
        std::copy_n(rows->values.begin(), rows->numComponents, pixel.values.begin());
    }
    return pixel;
}

/// A pixel of a layer; colour is composited over the clear colour, both premultiplied.
HdStreamPixel PixelOf(const hds::ImageLayer& layer, std::size_t index, bool isColor,
                      const HdStreamPixel& clear) {
    HdStreamPixel pixel;
    if (layer.isInteger) {
        pixel.isInteger = true;
        pixel.id = layer.ids[index];
        return pixel;
    }
    const std::size_t numChannels = layer.channels.size();
    pixel.values[3] = 1.0F;
    std::copy_n(layer.values.data() + index * numChannels, std::min<std::size_t>(numChannels, 4),
                pixel.values.begin());
    if (isColor) {
        const float uncovered = 1.0F - pixel.values[3];
        for (std::size_t c = 0; c < 4; ++c) {
            pixel.values[c] += uncovered * clear.values[c];
        }
    }
    return pixel;
}

/// True when the layer's rows are the buffer's, byte for byte.
bool IsCopied(const hds::ImageLayer& layer, HdFormat format, bool isColor,
              const HdStreamPixel& clear) {
    if (layer.isInteger) {
        return format == HdFormatInt32;
    }
    const bool isSameFormat = HdGetComponentFormat(format) == HdFormatFloat32 &&
                              HdGetComponentCount(format) == layer.channels.size();
    return isSameFormat && (!isColor || clear.values == decltype(clear.values){});
}

/// Bytes [first, last) of a row of the layer.
void CopyRow(const hds::ImageLayer& layer, std::size_t y, std::size_t first, std::size_t last,
             unsigned char* target) {
    const std::size_t channels = layer.isInteger ? 1 : layer.channels.size();
    const std::size_t begin = (y * layer.width + first) * channels;
    const std::size_t count = (last - first) * channels;
    if (layer.isInteger) {
        std::memcpy(target, layer.ids.data() + begin, count * sizeof(std::int32_t));
    } else {
        std::memcpy(target, layer.values.data() + begin, count * sizeof(float));
    }
}

/// Bytes [first, last) of a row of a colour layer over the clear colour; floats in and out.
void CompositeRow(const hds::ImageLayer& layer, std::size_t y, std::size_t first, std::size_t last,
                  const HdStreamPixel& clear, unsigned char* target) {
    const float* source = layer.values.data() + (y * layer.width + first) * 4;
    auto* pixels = reinterpret_cast<float*>(target);
    for (std::size_t i = 0; i < 4 * (last - first); i += 4) {
        const float uncovered = 1.0F - source[i + 3];
        for (std::size_t c = 0; c < 4; ++c) {
            pixels[i + c] = source[i + c] + uncovered * clear.values[c];
        }
    }
}

} // namespace

/// The image is held weakly, so that a buffer nobody looks at keeps no film alive.
struct HdStreamRenderBuffer::Shown {
    std::weak_ptr<const hds::FilmImage> image;
    bool isNothing = true; ///< no image, or one without the layer
    std::string aovName;
    GfRect2i dataWindow;
    VtValue clearValue;
    std::weak_ptr<HdStreamPictures> pictures; ///< where later images come from

    bool IsImage(const std::shared_ptr<const hds::FilmImage>& other) const {
        return other && !isNothing && HdStreamIsSameImage(image, other);
    }
};

HdStreamRenderBuffer::HdStreamRenderBuffer(const SdfPath& id) : HdRenderBuffer(id) {}

HdStreamRenderBuffer::~HdStreamRenderBuffer() = default;

bool HdStreamRenderBuffer::Allocate(const GfVec3i& dimensions, HdFormat format, bool) {
    if (dimensions[0] < 0 || dimensions[1] < 0 || dimensions[2] != 1 ||
        !HdStreamIsWritableFormat(format)) {
        TF_WARN("%s: a render buffer of %d x %d x %d pixels of format %d cannot be allocated",
                GetId().GetText(), dimensions[0], dimensions[1], dimensions[2],
                static_cast<int>(format));
        return false;
    }
    const std::lock_guard<std::mutex> lock(_mutex);
    _Deallocate();
    _width = static_cast<unsigned int>(dimensions[0]);
    _height = static_cast<unsigned int>(dimensions[1]);
    _format = format;
    _pixels.assign(std::size_t{_width} * _height * HdDataSizeOfFormat(format), 0);
    return true;
}

void HdStreamRenderBuffer::_Deallocate() {
    _width = 0;
    _height = 0;
    _format = HdFormatInvalid;
    _pixels = {};
    _shown.reset();
    _numMappers.store(0);
    _isConverged.store(false);
}

void* HdStreamRenderBuffer::Map() {
    const std::lock_guard<std::mutex> lock(_mutex);
    if (_pixels.empty()) {
        return nullptr;
    }
    ++_numMappers;
    return _pixels.data();
}

void HdStreamRenderBuffer::Unmap() {
    const std::lock_guard<std::mutex> lock(_mutex);
    if (_numMappers.load() > 0) {
        --_numMappers;
    }
}

void HdStreamRenderBuffer::Resolve() {
    const std::lock_guard<std::mutex> lock(_mutex);
    const std::shared_ptr<HdStreamPictures> pictures = _shown ? _shown->pictures.lock() : nullptr;
    if (!pictures || _numMappers.load() > 0) {
        return;
    }
    if (const std::shared_ptr<const hds::FilmImage> image = pictures->After(_shown->image, this)) {
        // One without the layer is the pass's affair.
        if (const hds::ImageLayer* layer = FindLayer(*image, _shown->aovName, _shown->dataWindow)) {
            ShowLayer(image, layer);
        }
    }
}

HdStreamShowResult HdStreamRenderBuffer::Show(const std::shared_ptr<const hds::FilmImage>& image,
                                              const std::shared_ptr<HdStreamPictures>& pictures,
                                              const std::string& aovName,
                                              const GfRect2i& dataWindow,
                                              const VtValue& clearValue) {
    const std::lock_guard<std::mutex> lock(_mutex);
    const hds::ImageLayer* layer = image ? FindLayer(*image, aovName, dataWindow) : nullptr;
    const HdStreamShowResult result =
        layer ? HdStreamShowResult::Shown : HdStreamShowResult::Missing;
    const VtValue& clear = clearValue.IsEmpty() && _shown ? _shown->clearValue : clearValue;
    const bool isSame = _shown && _shown->aovName == aovName && _shown->dataWindow == dataWindow &&
                        _shown->clearValue == clear &&
                        (layer ? _shown->IsImage(image) : _shown->isNothing);
    if (isSame) {
        _shown->pictures = pictures;
        return result;
    }
    if (_numMappers.load() > 0) {
        return HdStreamShowResult::Mapped;
    }
    auto shown = std::make_unique<Shown>();
    shown->aovName = aovName;
    shown->dataWindow = dataWindow;
    shown->clearValue = clear;
    shown->pictures = pictures;
    _shown = std::move(shown);
    ShowLayer(image, layer);
    return result;
}

void HdStreamRenderBuffer::ShowLayer(const std::shared_ptr<const hds::FilmImage>& image,
                                     const hds::ImageLayer* layer) {
    const hds::AovInfo* info = hds::FindAov(_shown->aovName);
    const bool isComposited = info && info->isColor && info->NumChannels() == 4;
    Write(layer, _shown->dataWindow, isComposited, ClearPixel(_shown->aovName, _shown->clearValue));
    _shown->isNothing = layer == nullptr;
    _shown->image = image;
}

void HdStreamRenderBuffer::Write(const hds::ImageLayer* layer, const GfRect2i& dataWindow,
                                 bool isColor, const HdStreamPixel& clear) {
    const std::size_t pixelBytes = HdDataSizeOfFormat(_format);
    const std::size_t rowBytes = _width * pixelBytes;
    std::vector<HdStreamPixel> row(_width, clear);
    const bool isCopied = layer && IsCopied(*layer, _format, isColor, clear);
    const bool isComposited = layer && isColor && _format == HdFormatFloat32Vec4;
    const int width = static_cast<int>(_width);
    const int begin = std::clamp(dataWindow.GetMinX(), 0, width);
    const int end = std::clamp(dataWindow.GetMaxX() + 1, begin, width);
    for (unsigned int y = 0; y < _height; ++y) {
        const int imageY = static_cast<int>(y) - dataWindow.GetMinY();
        const bool isInside =
            layer && begin < end && imageY >= 0 && imageY < static_cast<int>(layer->height);
        // Images go from top to bottom, Hydra's buffers from bottom to top.
        unsigned char* target = _pixels.data() + (_height - 1 - y) * rowBytes;
        if (isInside && (isCopied || isComposited)) {
            if (begin > 0 || end < width) {
                HdStreamWritePixels(_format, row.data(), row.size(), target); // still clear
            }
            const auto first = static_cast<std::size_t>(begin - dataWindow.GetMinX());
            const auto last = static_cast<std::size_t>(end - dataWindow.GetMinX());
            unsigned char* inside = target + static_cast<std::size_t>(begin) * pixelBytes;
            if (isCopied) {
                CopyRow(*layer, static_cast<std::size_t>(imageY), first, last, inside);
            } else {
                CompositeRow(*layer, static_cast<std::size_t>(imageY), first, last, clear, inside);
            }
            continue;
        }
        for (unsigned int x = 0; x < _width; ++x) {
            const int imageX = static_cast<int>(x) - dataWindow.GetMinX();
            if (isInside && imageX >= 0 && imageX < static_cast<int>(layer->width)) {
                const std::size_t index = static_cast<std::size_t>(imageY) * layer->width +
                                          static_cast<std::size_t>(imageX);
                row[x] = PixelOf(*layer, index, isColor, clear);
            } else {
                row[x] = clear;
            }
        }
        HdStreamWritePixels(_format, row.data(), row.size(), target);
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
