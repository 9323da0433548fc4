// SPDX-License-Identifier: Apache-2.0
// A texture ready to be streamed: its record and any of its lines. Made by TexturePreparer.
// Explained in docs/texturing.md.
#pragma once

#include "hdStream/texture/imageReader.h"
#include "hdStream/texture/lineStore.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace hds {

/// All of a prepared texture but its lines.
struct TextureDescription {
    shared::HdsTexture record{};    ///< firstLine is 0
    std::string error;              ///< one line that names the file; then flags says MISSING
    std::string warning;            ///< one line, e.g. a colour space nobody knows; often empty
    ImageInfo info;                 ///< of the file
    std::uint64_t numNonFinite = 0; ///< values that were NaN or infinite and were replaced
    std::uint64_t numClamped = 0;   ///< values beyond the stored format's range after decoding
    std::map<std::uint32_t, std::uint32_t> repeats; ///< see CanonicalLine
};

/// Thread-safe.
class PreparedTexture {
public:
    /// Makes the lines again when some are found damaged. Empty: they cannot be made any more.
    using Restore = std::function<std::shared_ptr<const LineStore>()>;

    PreparedTexture(TextureDescription description, std::shared_ptr<const LineStore> lines,
                    Restore restore);

    const TextureDescription& Description() const { return _description; }
    const shared::HdsTexture& Record() const { return _description.record; }
    bool Ok() const { return _description.error.empty(); }
    std::uint32_t NumLines() const { return _description.record.numLines; }

    /// The first line with the content of this one, as far as lines of equal blocks (parts of one
    /// colour) go: who keeps canonical lines only keeps each of them once.
    std::uint32_t CanonicalLine(std::uint32_t line) const;

    /// Copies a line. Damaged lines are made again from the file, which blocks for as long as that
    /// takes. \return false when that fails (the file is gone, or is another one now): the line is
    /// zeros then, which decode to black.
    bool ReadLine(std::uint32_t line, TextureLine* out) const;
    /// The same for as many lines as `out` has, from `first` on.
    void ReadLines(std::uint32_t first, std::vector<TextureLine>* out) const;

    /// A mip as linear RGBA floats [height][width][4], rows from the top; for light tables and
    /// displacement, which need all of it. \return empty when a line cannot be read.
    std::vector<float> DecodeMip(std::uint32_t mip) const;

    /// Bytes of host memory of lines that are in no persistent store.
    std::uint64_t HostBytes() const;

private:
    std::shared_ptr<const LineStore> Lines() const;

    TextureDescription _description;
    Restore _restore;
    mutable std::mutex _mutex;
    mutable std::shared_ptr<const LineStore> _lines; ///< never null
    mutable bool _isLost = false;                    ///< restoring failed: it is not tried again
};

} // namespace hds
