// SPDX-License-Identifier: Apache-2.0
// Resident mode of textures: every line of every texture is uploaded before
// the first ray, in the order of their numbers, so that kernels need no table. Explained in
// docs/texturing.md.
#pragma once

#include "hdStream/texture/lineBuffers.h"
#include "hdStream/texture/lineProvider.h"
#include "hdStream/texture/openTextures.h"
#include "hdStream/texture/textureStatistics.h"

#include <memory>
#include <vector>

namespace hds {

/// Device memory that holds all lines of a provider's textures. Externally synchronised.
class ResidentTextures {
public:
    explicit ResidentTextures(std::shared_ptr<Device> device);

    /// Opens and uploads the textures of `provider`; no-op when they are those of the last call.
    /// Blocks. \throws Error when they do not fit the device.
    void Update(LineProvider* provider);

    /// Counts from 0 again.
    void BeginStatistics() { _statistics = {}; }
    TextureBinding Binding() const;
    std::uint32_t NumBuffers() const { return _buffers ? _buffers->NumBuffers() : 0; }
    std::uint64_t Bytes() const { return _buffers ? _buffers->Bytes() : 0; }
    std::uint64_t TableBytes() const;
    const TextureStatistics& Statistics() const { return _statistics; }

private:
    void OpenAll(LineProvider* provider);
    void UploadLines(LineProvider* provider);

    std::shared_ptr<Device> _device;
    OpenTextures _textures;
    std::vector<std::uint64_t> _ids;
    std::unique_ptr<LineBuffers> _buffers;
    Buffer _records;
    Buffer _noTable; ///< there is one in kernels' signatures
    TextureStatistics _statistics;
};

} // namespace hds
