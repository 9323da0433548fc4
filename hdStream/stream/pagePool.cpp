// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/pagePool.h"

#include <utility>

namespace hds {

PagePool::PagePool(std::shared_ptr<Device> device, std::string label)
    : _device(std::move(device)), _label(std::move(label)) {
    for (Buffer& buffer : _buffers) {
        buffer = Buffer(_device, _label + " pool", 0, BufferAccess::ReadOnly);
    }
    _addresses = Buffer(_device, _label + " addresses", 0, BufferAccess::ReadOnly);
}

} // namespace hds
