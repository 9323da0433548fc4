// SPDX-License-Identifier: Apache-2.0
// The images of one version that a render pass shows in its buffers.
#pragma once

#include "hdStream/session/renderThread.h"

#include <pxr/pxr.h>

#include <cstdint>
#include <memory>
#include <mutex>

PXR_NAMESPACE_OPEN_SCOPE

/// Whether both are of one image, also where that is gone.
bool HdStreamIsSameImage(const std::weak_ptr<const hds::FilmImage>& a,
                         const std::weak_ptr<const hds::FilmImage>& b);

/// Keeps the buffers of a pass together: the one that asks first after a frame gets what is newest
/// whenever it asks, and the others what it has got. So hosts that ask them in turns see outputs of
/// one image. Owned by the pass, for as long as it wants that version. Thread-safe.
class HdStreamPictures {
public:
    using Image = std::shared_ptr<const hds::FilmImage>;
    using WeakImage = std::weak_ptr<const hds::FilmImage>; ///< keeps no film alive

    HdStreamPictures(const hds::RenderThread& thread, std::uint64_t version)
        : _thread(&thread), _version(version) {}

    std::uint64_t Version() const { return _version; }

    /// What is newest, of whatever version; all buffers are about to show it.
    Image Newest();

    /// For a buffer that shows `shown`: what it is to show instead, of this version. \return null:
    /// nothing.
    Image After(const WeakImage& shown, const void* buffer);

private:
    const hds::RenderThread* _thread;
    const std::uint64_t _version;
    std::mutex _mutex;
    const void* _first = nullptr; ///< the buffer that has asked first since the last frame
    Image _present;               ///< what it has got; null: nothing since then
};

PXR_NAMESPACE_CLOSE_SCOPE
