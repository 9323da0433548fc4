// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/residentTextures.h"

#include "hdStream/base/error.h"
#include "hdStream/base/timer.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace hds {

namespace {

/// Lines read and uploaded at a time: 8 MiB.
constexpr std::uint32_t kBatchLines = 16384;
/// Opened at a time, so that what does not fit is found before all is prepared.
constexpr std::size_t kBatchTextures = 64;

} // namespace

ResidentTextures::ResidentTextures(std::shared_ptr<Device> device) : _device(std::move(device)) {
    _noTable = Buffer(_device, "no texture line table", 0, BufferAccess::ReadOnly);
}

void ResidentTextures::Update(LineProvider* provider) {
    std::vector<std::uint64_t> ids;
    for (std::uint32_t texture = 0; texture < provider->NumTextures(); ++texture) {
        ids.push_back(provider->TextureId(texture));
    }
    if (_buffers && ids == _ids) {
        return;
    }
    _ids = std::move(ids);
    const Timer timer;
    _buffers = nullptr; // frees first
    OpenAll(provider);
    _statistics.openSeconds += timer.Seconds();
    _statistics.openedTextures += _ids.size();
    _buffers = std::make_unique<LineBuffers>(_device, _textures.NumLines());
    _records = Buffer();
    _records = UploadVector(_device, "textures", _textures.Records());
    UploadLines(provider);
}

void ResidentTextures::OpenAll(LineProvider* provider) {
    _textures = {};
    _textures.Update(*provider);
    std::vector<std::uint32_t> all(provider->NumTextures());
    std::iota(all.begin(), all.end(), 0U);
    for (std::size_t begin = 0; begin < all.size(); begin += kBatchTextures) {
        const std::size_t end = std::min(all.size(), begin + kBatchTextures);
        const std::vector<std::uint32_t> batch(all.begin() + static_cast<std::ptrdiff_t>(begin),
                                               all.begin() + static_cast<std::ptrdiff_t>(end));
        provider->Open(batch, true, {});
        for (const std::uint32_t texture : batch) {
            _textures.Add(*provider, texture);
        }
        const std::uint64_t numLines = _textures.NumLines();
        if (numLines > LineBuffers::MaxSlots(*_device)) {
            throw Error("textures: " + std::to_string(numLines * HDS_LINE_BYTES) +
                        " bytes of the first " + std::to_string(end) + " of " +
                        std::to_string(all.size()) +
                        " do not fit the device's memory; --residency stream needs less");
        }
    }
}

void ResidentTextures::UploadLines(LineProvider* provider) {
    const Timer timer;
    const double readBefore = _statistics.readSeconds;
    const std::uint32_t numLines = _textures.NumLines();
    std::vector<std::uint8_t> bytes(std::size_t{std::min(numLines, kBatchLines)} * HDS_LINE_BYTES);
    std::vector<LineId> lines;
    for (std::uint32_t first = 0; first < numLines; first += kBatchLines) {
        lines.clear();
        for (std::uint32_t line = first; line < std::min(numLines, first + kBatchLines); ++line) {
            lines.push_back(_textures.Find(line));
        }
        const Timer readTimer;
        provider->Read(lines, bytes.data(), {});
        _statistics.readSeconds += readTimer.Seconds();
        // Batches end where buffers do.
        static_assert(LineBuffers::kSlotsPerBuffer % kBatchLines == 0, "batches cross buffers");
        _buffers->At(first >> HDS_SLOT_BUFFER_SHIFT)
            .Write(bytes.data(), lines.size() * HDS_LINE_BYTES,
                   first % LineBuffers::kSlotsPerBuffer * HDS_LINE_BYTES);
    }
    const std::uint64_t bytesLoaded = std::uint64_t{numLines} * HDS_LINE_BYTES;
    const std::uint64_t gridBytes = provider->GridLines() * HDS_LINE_BYTES;
    _statistics.Count(
        {numLines - provider->GridLines(), bytesLoaded - gridBytes, bytesLoaded - gridBytes, 0},
        false);
    _statistics.Count({provider->GridLines(), gridBytes, gridBytes, 0}, true);
    _statistics.requestSeconds += timer.Seconds() - (_statistics.readSeconds - readBefore);
}

TextureBinding ResidentTextures::Binding() const {
    TextureBinding binding;
    binding.textures = &_records;
    binding.lineTable = &_noTable;
    _buffers->FillBinding(&binding);
    return binding;
}

std::uint64_t ResidentTextures::TableBytes() const {
    return _records.Bytes() + _noTable.Bytes() + (_buffers ? _buffers->UnusedBytes() : 0);
}

} // namespace hds
