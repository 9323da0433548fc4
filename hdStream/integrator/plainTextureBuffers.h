// SPDX-License-Identifier: Apache-2.0
// The textures of a committed scene in device memory, whole and uncompressed, and their place in
// the kernels' signatures: what the cache is measured against (HDS_TEXTURE_PLAIN). Explained in
// docs/texturing.md.
#pragma once

#include "hdStream/device/program.h"
#include "hdStream/scene/commit.h"
#include "kernels/shared/texture.h"

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// Kept from one version of the scene to the next: a texture is decoded once. Externally
/// synchronised.
class PlainTextureBuffers {
public:
    explicit PlainTextureBuffers(std::shared_ptr<Device> device);

    /// Decodes and uploads what is new, on all cores; images that cannot be decoded are reported
    /// and give their nodes' fallbacks. Blocks. \throws Error when they do not fit the device.
    void Update(const CommittedScene& scene);

    /// Sets HDS_TEXTURE_ARGS from `first` on; returns the next free index.
    unsigned Bind(Kernel* kernel, unsigned first) const;

    std::uint32_t NumBuffers() const { return static_cast<std::uint32_t>(_buffers.size()); }
    std::uint64_t Bytes() const; ///< of texels

private:
    void Add(const CommittedScene& scene, const std::vector<std::uint32_t>& missing);
    void Place(const std::string& key, shared::HdsTexture record,
               const std::vector<std::uint8_t>& texels, std::uint64_t bytesToCome);
    void StartBuffer(std::uint64_t bytes, std::uint64_t bytesToCome);

    std::shared_ptr<Device> _device;
    Buffer _records;
    Buffer _none; ///< stands for buffers that are not there
    std::vector<Buffer> _buffers;
    std::uint64_t _usedBytes = 0;                      ///< of the last buffer
    std::map<std::string, shared::HdsTexture> _placed; ///< by image, colour space and channels
};

} // namespace hds
