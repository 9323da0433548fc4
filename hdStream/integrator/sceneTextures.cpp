// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/sceneTextures.h"

#include "hdStream/integrator/residencyPlan.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace hds {

namespace {

/// A look-up reads four texels of each of two mips.
constexpr std::uint32_t kLinesPerLookup = 8;
/// A collision in a volume reads a voxel of its density, of its temperature, and of each channel of
/// its emission.
constexpr std::uint32_t kLinesPerCollision = 5;
/// And where it moves one of each part of its velocity.
constexpr std::uint32_t kLinesPerMove = HDS_VELOCITY_GRIDS;

} // namespace

SceneTextures::SceneTextures(std::shared_ptr<Device> device, Store* store)
    : _device(std::move(device)), _store(store), _nothing(_device, "no textures", 0) {}

void SceneTextures::Update(const CommittedScene& scene, const ResidencyOptions& residency) {
    const bool isNeeded = scene.lines->NumTextures() > 0;
    const bool isResident = isNeeded && residency.mode == ResidencyMode::Resident;
    const bool isStreamed = isNeeded && !isResident;
    // Frees what is not wanted any more first.
    if (!isResident) {
        _resident = nullptr;
    }
    if (!isStreamed) {
        _pool = nullptr;
    }
    const bool hasVolumes = !scene.volumes.volumes.empty();
    _volumeBudgetBytes = isStreamed && hasVolumes
                             ? VolumeBudget(residency, scene.lines->GridLines() * HDS_LINE_BYTES)
                             : 0;
    _budgetBytes = isStreamed ? Budget(scene, residency,
                                       _volumeBudgetBytes > 0 ? scene.lines->FirstGrid()
                                                              : scene.lines->NumTextures())
                              : 0;
    if (isResident) {
        if (!_resident) {
            _resident = std::make_unique<ResidentTextures>(_device);
        }
        _resident->Update(scene.lines.get());
    } else if (isStreamed) {
        if (!_pool) {
            _pool = std::make_unique<TexturePool>(_device, _store);
        }
        _pool->Update(scene.lines.get(), _budgetBytes,
                      kLinesPerLookup * std::max(1U, scene.maxLookups),
                      {_volumeBudgetBytes, (hasVolumes ? kLinesPerCollision : 0U) +
                                               (scene.volumes.haveVelocities ? kLinesPerMove : 0U) +
                                               scene.volumes.linesOfTerms});
    }
}

void SceneTextures::BeginStatistics() {
    if (_pool) {
        _pool->BeginStatistics();
    }
    if (_resident) {
        _resident->BeginStatistics();
    }
}

/// Bytes of a pool for the first `numTextures` textures.
std::uint64_t SceneTextures::Budget(const CommittedScene& scene, const ResidencyOptions& residency,
                                    std::uint32_t numTextures) const {
    std::uint64_t totalBytes = 0;
    if (residency.textureBudgetShare > 0.0) {
        // Only what has been opened says how much it is.
        std::vector<std::uint32_t> all(numTextures);
        std::iota(all.begin(), all.end(), 0U);
        scene.lines->Open(all, false, {});
        for (const std::uint32_t texture : all) {
            totalBytes += std::uint64_t{scene.lines->Record(texture).numLines} * HDS_LINE_BYTES;
        }
    }
    return TextureBudget(residency, totalBytes, _device->Properties().memoryBytes);
}

unsigned SceneTextures::Bind(Kernel* kernel, unsigned first, bool isStreaming) const {
    kernel->SetBytes(first++, &_mipBias, sizeof(_mipBias));
    TextureBinding binding;
    if (_resident) {
        binding = _resident->Binding();
    } else if (_pool) {
        binding = _pool->Binding();
    } else {
        binding.textures = binding.lineTable = &_nothing;
        binding.pools.fill(&_nothing);
        if (isStreaming) {
            binding.requests = binding.stamps = binding.waiting = &_nothing;
        }
    }
    return binding.Bind(kernel, first);
}

std::uint32_t SceneTextures::NumBuffers() const {
    return _resident ? _resident->NumBuffers() : _pool ? _pool->NumBuffers() : 0;
}

std::uint64_t SceneTextures::Bytes() const {
    return _resident ? _resident->Bytes() : _pool ? _pool->Bytes() : 0;
}

std::uint64_t SceneTextures::TableBytes() const {
    return _resident ? _resident->TableBytes() : _pool ? _pool->TableBytes() : 0;
}

TextureStatistics SceneTextures::Statistics() const {
    return _resident ? _resident->Statistics() : _pool ? _pool->Statistics() : TextureStatistics{};
}

} // namespace hds
