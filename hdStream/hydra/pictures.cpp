// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/pictures.h"

PXR_NAMESPACE_OPEN_SCOPE

bool HdStreamIsSameImage(const std::weak_ptr<const hds::FilmImage>& a,
                         const std::weak_ptr<const hds::FilmImage>& b) {
    return !a.owner_before(b) && !b.owner_before(a);
}

HdStreamPictures::Image HdStreamPictures::Newest() {
    const std::lock_guard<std::mutex> lock(_mutex);
    _first = nullptr;
    _present.reset();
    return _thread->Newest();
}

HdStreamPictures::Image HdStreamPictures::After(const WeakImage& shown, const void* buffer) {
    const std::lock_guard<std::mutex> lock(_mutex);
    _first = _first != nullptr ? _first : buffer;
    if (buffer == _first) {
        const Image newest = _thread->Newest();
        if (newest && newest->version == _version) {
            _present = newest;
        } else if (newest && newest->version > _version) {
            _present.reset(); // no other of this version comes, and buffers keep what they show
        }
    }
    return HdStreamIsSameImage(shown, _present) ? nullptr : _present;
}

PXR_NAMESPACE_CLOSE_SCOPE
