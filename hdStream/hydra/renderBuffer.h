// SPDX-License-Identifier: Apache-2.0
// Render buffers: host memory that is filled from published images, when a pass is executed and
// when the host resolves a buffer. The render thread never writes to them, so a buffer may be
// reallocated or go at any time.
#pragma once

#include "hdStream/session/renderThread.h"
#include "hdStream/session/session.h"

#include <pxr/base/gf/rect2i.h>
#include <pxr/imaging/hd/renderBuffer.h>
#include <pxr/pxr.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

struct HdStreamPixel;
class HdStreamPictures;

/// What became of showing an image in a buffer.
enum class HdStreamShowResult {
    Shown,   ///< the buffer has the image's layer, now or already
    Missing, ///< the image has no layer of that name and size: the buffer has clear values
    Mapped,  ///< somebody reads the buffer; it is as it was
};

/// A render buffer. Map, Unmap, Resolve and the queries are thread-safe; all else is the
/// application's thread only.
class HdStreamRenderBuffer final : public HdRenderBuffer {
public:
    explicit HdStreamRenderBuffer(const SdfPath& id);
    ~HdStreamRenderBuffer() override;

    /// Any format of Hydra. Starts anew whenever dimensions or format change; the contents are
    /// zeros until the next Show.
    bool Allocate(const GfVec3i& dimensions, HdFormat format, bool multiSampled) override;
    unsigned int GetWidth() const override { return _width; }
    unsigned int GetHeight() const override { return _height; }
    unsigned int GetDepth() const override { return 1; }
    HdFormat GetFormat() const override { return _format; }
    bool IsMultiSampled() const override { return false; }

    /// The pixels, rows from bottom to top; valid until as many calls of Unmap. While a buffer is
    /// mapped its contents stay as they are.
    void* Map() override;
    void Unmap() override;
    bool IsMapped() const override { return _numMappers.load() != 0; }
    /// Shows what the pass has got since, of the version that it was executed for; hosts that look
    /// between two frames need not wait for the next one. Nothing while mapped.
    void Resolve() override;
    bool IsConverged() const override { return _isConverged.load(); }
    void SetConverged(bool isConverged) { _isConverged.store(isConverged); }

    /// Shows a published image's layer.
    /// \param image whatever is newest; null: nothing is rendered yet
    /// \param pictures what Resolve asks from here on, while the pass keeps it
    /// \param aovName name of the layer
    /// \param dataWindow where the image lies in the buffer, in pixels, y down
    /// \param clearValue of the binding; empty: the one before holds
    HdStreamShowResult Show(const std::shared_ptr<const hds::FilmImage>& image,
                            const std::shared_ptr<HdStreamPictures>& pictures,
                            const std::string& aovName, const GfRect2i& dataWindow,
                            const VtValue& clearValue);

protected:
    void _Deallocate() override;

private:
    struct Shown; ///< what the contents were made from
    /// Precondition: locked, not mapped.
    void ShowLayer(const std::shared_ptr<const hds::FilmImage>& image,
                   const hds::ImageLayer* layer);
    void Write(const hds::ImageLayer* layer, const GfRect2i& dataWindow, bool isColor,
               const HdStreamPixel& clear);

    unsigned int _width = 0;
    unsigned int _height = 0;
    HdFormat _format = HdFormatInvalid;
    std::vector<unsigned char> _pixels;
    std::unique_ptr<Shown> _shown;
    std::mutex _mutex; ///< between Map, Resolve and Show
    std::atomic<int> _numMappers{0};
    std::atomic<bool> _isConverged{false};
};

PXR_NAMESPACE_CLOSE_SCOPE
