// SPDX-License-Identifier: Apache-2.0
// The textures of a committed scene on the device: streamed or resident.
// Explained in docs/texturing.md.
#pragma once

#include "hdStream/integrator/renderOptions.h"
#include "hdStream/scene/commit.h"
#include "hdStream/texture/residentTextures.h"
#include "hdStream/texture/texturePool.h"

#include <memory>

namespace hds {

/// Kept from one version of the scene to the next. Externally synchronised.
class SceneTextures {
public:
    /// \param store keeps compiled kernels, may be null.
    SceneTextures(std::shared_ptr<Device> device, Store* store);

    /// Makes the scene's textures ready in the form that the options want: all of them, or a pool.
    /// Blocks. \throws Error when they do not fit the device, or the pool its budget.
    void Update(const CommittedScene& scene, const ResidencyOptions& residency);

    /// Statistics count from 0 again.
    void BeginStatistics();

    /// Mips that look-ups are moved by; positive: coarser.
    void SetMipBias(float bias) { _mipBias = bias; }
    float MipBias() const { return _mipBias; }

    /// Sets HDS_SCENE_TEXTURE_ARGS from `first` on; returns the next free index. Where there are no
    /// textures, kernels that look none up get tiny buffers. \param isStreaming the kernel has
    /// HDS_FEATURE_TEXTURE_STREAMING, as a scene with textures in a pool needs.
    unsigned Bind(Kernel* kernel, unsigned first, bool isStreaming) const;
    /// Bind again when this has changed.
    std::uint64_t Generation() const { return _pool ? _pool->Generation() : 0; }

    /// Null: nothing can be missing.
    TexturePool* Pool() { return _pool.get(); }
    const TexturePool* Pool() const { return _pool.get(); }
    std::uint32_t NumBuffers() const;
    /// Bytes of device memory for texels, and for what it takes to find them.
    std::uint64_t Bytes() const;
    /// The most bytes of texels that were there at a time since BeginStatistics.
    std::uint64_t PeakUsedBytes() const { return _pool ? _pool->PeakUsedBytes() : Bytes(); }
    std::uint64_t TableBytes() const;
    /// Bytes that it may take, 0: what there is.
    std::uint64_t BudgetBytes() const { return _budgetBytes; }
    /// Of a part that only volumes have; 0: they share.
    std::uint64_t VolumeBudgetBytes() const { return _volumeBudgetBytes; }
    std::uint64_t VolumePeakUsedBytes() const { return _pool ? _pool->GridPeakUsedBytes() : 0; }
    /// Bytes of lines that are never given away.
    std::uint64_t PinnedBytes() const { return _pool ? _pool->PinnedBytes() : 0; }
    TextureStatistics Statistics() const;

private:
    std::uint64_t Budget(const CommittedScene& scene, const ResidencyOptions& residency,
                         std::uint32_t numTextures) const;

    std::shared_ptr<Device> _device;
    Store* _store;
    std::unique_ptr<TexturePool> _pool; ///< one of the two, if there are textures
    std::unique_ptr<ResidentTextures> _resident;
    std::uint64_t _budgetBytes = 0;
    std::uint64_t _volumeBudgetBytes = 0;
    float _mipBias = 0.0F;
    Buffer _nothing; ///< bound where there are no textures
};

} // namespace hds
