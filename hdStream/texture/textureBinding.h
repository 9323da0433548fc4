// SPDX-License-Identifier: Apache-2.0
// Textures in a kernel's signature (HDS_TEXTURE_ARGS of kernels/texture/cache.clh).
#pragma once

#include "hdStream/device/program.h"
#include "kernels/shared/textureCache.h"

#include <array>
#include <cstdint>

namespace hds {

/// The buffers of textures, whichever mode owns them. Unused ones are tiny but valid.
struct TextureBinding {
    const Buffer* textures = nullptr;
    const Buffer* lineTable = nullptr;
    std::array<const Buffer*, HDS_SLOT_MAX_BUFFERS> pools{};
    const Buffer* requests = nullptr; ///< null: all lines are there
    const Buffer* stamps = nullptr;   ///< null: all lines are there
    const Buffer* waiting = nullptr;  ///< null: all lines are there

    /// Sets the arguments from `first` on; returns the next free index.
    unsigned Bind(Kernel* kernel, unsigned first) const {
        kernel->SetBuffer(first++, *textures);
        kernel->SetBuffer(first++, *lineTable);
        for (const Buffer* pool : pools) {
            kernel->SetBuffer(first++, *pool);
        }
        if (requests != nullptr) {
            kernel->SetBuffer(first++, *requests);
            kernel->SetBuffer(first++, *stamps);
            kernel->SetBuffer(first++, *waiting);
        }
        return first;
    }
};

} // namespace hds
