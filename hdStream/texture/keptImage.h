// SPDX-License-Identifier: Apache-2.0
// Codes of an image that was read, kept for a while: lines that are asked for later are made from
// them one by one, without reading the file again. Explained in docs/texturing.md, section
// "Preparing".
#pragma once

#include "hdStream/persist/pageKey.h"
#include "hdStream/texture/codeRows.h"
#include "hdStream/texture/lineStore.h"

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>

namespace hds {

/// The pixels of one file, as codes of 8 or 16 bits. Filled by one thread, then immutable and
/// thread-safe.
class KeptImage {
public:
    KeptImage(const CodeRows& rows, std::uint32_t width, std::uint32_t height);

    /// Takes the next row of codes.
    void AddRow(const void* codes);
    std::uint64_t Bytes() const { return _rows.RowBytes(_width) * _height; }

    /// Makes those lines of a texture that are being filled; the same as a MipChain makes.
    /// \param texture its layout, of the same size; not constant
    void FillLines(const shared::HdsTexture& texture, LineStore* lines) const;

private:
    class LinearRows;

    CodeRows _rows;
    std::uint32_t _width;
    std::uint32_t _height;
    std::uint32_t _nextRow = 0;
    std::unique_ptr<std::uint8_t[]> _codes; ///< [height][CodeRows::RowBytes]; rows that were added
};

/// The images that were used last, up to some bytes. Thread-safe.
class KeptImages {
public:
    explicit KeptImages(std::uint64_t maxBytes) : _maxBytes(maxBytes) {}

    /// Whether an image of so many bytes can be kept.
    bool Fits(std::uint64_t bytes) const { return bytes <= _maxBytes; }
    /// Keeps an image, in place of those that were used longest ago.
    void Add(const PageKey& key, std::shared_ptr<const KeptImage> image);
    /// \return null: it is not there (any more)
    std::shared_ptr<const KeptImage> Find(const PageKey& key);

private:
    struct Entry {
        PageKey key;
        std::shared_ptr<const KeptImage> image;
    };

    std::uint64_t _maxBytes;
    std::mutex _mutex;
    std::uint64_t _bytes = 0;
    std::list<Entry> _entries; ///< used last first; some tens
};

} // namespace hds
