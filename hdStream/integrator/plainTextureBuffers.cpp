// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/plainTextureBuffers.h"

#include "hdStream/base/error.h"
#include "hdStream/stream/residentPool.h"
#include "hdStream/texture/plainTexture.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

namespace hds {

namespace {

/// Textures decoded together: bounds the host memory.
constexpr std::size_t kBatch = 8;

/// Textures that differ in what is read of them are stored apart.
std::string PlacedKey(const MaterialTexture& texture) {
    return MaterialTextureKey(texture) + '\n' + std::to_string(texture.channels);
}

std::uint64_t Aligned(std::uint64_t bytes) {
    return (bytes + HDS_POOL_UNIT_BYTES - 1) / HDS_POOL_UNIT_BYTES * HDS_POOL_UNIT_BYTES;
}

} // namespace

PlainTextureBuffers::PlainTextureBuffers(std::shared_ptr<Device> device)
    : _device(std::move(device)) {
    _none = Buffer(_device, "no texels", 0, BufferAccess::ReadOnly);
    _records = Buffer(_device, "textures", 0, BufferAccess::ReadOnly);
}

void PlainTextureBuffers::Update(const CommittedScene& scene) {
    std::vector<std::uint32_t> missing;
    for (std::uint32_t i = 0; i < scene.textureTable.size(); ++i) {
        if (_placed.count(PlacedKey(scene.textureTable[i])) == 0) {
            missing.push_back(i);
        }
    }
    // What is new joins what is there; when that is too much, only what is used is kept.
    try {
        Add(scene, missing);
    } catch (const Error&) {
        if (missing.size() == scene.textureTable.size()) {
            throw;
        }
        _placed.clear();
        _buffers.clear();
        _usedBytes = 0;
        missing.resize(scene.textureTable.size());
        for (std::uint32_t i = 0; i < missing.size(); ++i) {
            missing[i] = i;
        }
        Add(scene, missing);
    }
    std::vector<shared::HdsTexture> records;
    for (const MaterialTexture& texture : scene.textureTable) {
        records.push_back(_placed.at(PlacedKey(texture)));
    }
    _records = UploadVector(_device, "textures", records);
}

/// Decodes and places textures of the scene, batch by batch.
void PlainTextureBuffers::Add(const CommittedScene& scene,
                              const std::vector<std::uint32_t>& missing) {
    for (std::size_t begin = 0; begin < missing.size(); begin += kBatch) {
        const std::size_t count = std::min(kBatch, missing.size() - begin);
        std::vector<PlainTexture> loaded(count);
        tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
            const MaterialTexture& texture = scene.textureTable[missing[begin + i]];
            loaded[i] = LoadPlainTexture(SourceOf(texture.file), RequestOf(texture));
        });
        std::uint64_t bytesToCome = 0;
        for (const PlainTexture& texture : loaded) {
            bytesToCome += Aligned(texture.texels.size());
        }
        for (std::size_t i = 0; i < count; ++i) {
            for (const std::string& problem : {loaded[i].error, loaded[i].warning}) {
                if (!problem.empty()) {
                    scene.images->Report(problem);
                }
            }
            Place(PlacedKey(scene.textureTable[missing[begin + i]]), loaded[i].record,
                  loaded[i].texels, bytesToCome);
            bytesToCome -= Aligned(loaded[i].texels.size());
        }
    }
}

void PlainTextureBuffers::Place(const std::string& key, shared::HdsTexture record,
                                const std::vector<std::uint8_t>& texels,
                                std::uint64_t bytesToCome) {
    const std::uint64_t bytes = Aligned(texels.size());
    if (bytes > 0) {
        if (_buffers.empty() || _usedBytes + bytes > _buffers.back().Bytes()) {
            StartBuffer(bytes, bytesToCome);
        }
        _buffers.back().Write(texels.data(), texels.size(), _usedBytes);
        record.firstLine = static_cast<std::uint32_t>(
            (_buffers.size() - 1) << HDS_POOL_BUFFER_SHIFT | _usedBytes / HDS_POOL_UNIT_BYTES);
        _usedBytes += bytes;
    }
    _placed[key] = record;
}

/// \param bytes it must hold. \param bytesToCome it should hold
void PlainTextureBuffers::StartBuffer(std::uint64_t bytes, std::uint64_t bytesToCome) {
    const std::uint64_t limit =
        std::min(kMaxPoolBufferBytes, _device->Properties().maxAllocationBytes);
    if (bytes > limit || _buffers.size() == kMaxPoolBuffers) {
        throw Error("textures: they do not fit the device's memory (" +
                    std::to_string(kMaxPoolBuffers) + " buffers of " + std::to_string(limit) +
                    " bytes)");
    }
    // At least as much again as there is, so that few are enough.
    const std::uint64_t wanted = std::clamp(std::max(bytesToCome, Bytes()), bytes, limit);
    _buffers.emplace_back(_device, "texels " + std::to_string(_buffers.size()), wanted,
                          BufferAccess::ReadOnly);
    _usedBytes = 0;
}

std::uint64_t PlainTextureBuffers::Bytes() const {
    std::uint64_t bytes = 0;
    for (const Buffer& buffer : _buffers) {
        bytes += buffer.Bytes();
    }
    return bytes;
}

unsigned PlainTextureBuffers::Bind(Kernel* kernel, unsigned first) const {
    kernel->SetBuffer(first++, _records);
    for (std::uint32_t i = 0; i < kMaxPoolBuffers; ++i) {
        kernel->SetBuffer(first++, i < _buffers.size() ? _buffers[i] : _none);
    }
    return first;
}

} // namespace hds
