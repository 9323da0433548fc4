// SPDX-License-Identifier: Apache-2.0
// A texture ready to be streamed: its record and any of its lines. Made by TexturePreparer.
// Explained in docs/texturing.md.
#pragma once

#include "hdStream/texture/imageReader.h"
#include "hdStream/texture/lineStore.h"

#include <atomic>
#include <cstdint>
#include <functional>
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
};

/// Thread-safe.
class PreparedTexture {
public:
    /// Makes lines, and others with them, that are not there: they were not asked for until now, or
    /// they were found damaged. \return all lines, or null: they cannot be made any more
    using Make =
        std::function<std::shared_ptr<const LineStore>(const std::vector<std::uint32_t>& lines)>;

    /// \param make empty: all lines are there, and none can be made again
    PreparedTexture(TextureDescription description, std::shared_ptr<const LineStore> lines,
                    Make make);

    const TextureDescription& Description() const { return _description; }
    const shared::HdsTexture& Record() const { return _description.record; }
    bool Ok() const { return _description.error.empty(); }
    std::uint32_t NumLines() const { return _description.record.numLines; }

    /// Whether a line can be read without making it.
    bool HasLine(std::uint32_t line) const { return Lines()->Has(line); }
    /// Copies a line if it can be read without making it. \return whether it can
    bool FindLine(std::uint32_t line, TextureLine* out) const { return Lines()->Read(line, out); }

    /// Makes those of some lines that are not there, as ReadLine does one by one.
    void MakeLines(const std::vector<std::uint32_t>& lines) const;

    /// Copies a line. What is not there is made from the file, which blocks for as long as that
    /// takes. \return false when that fails (the file is gone, or is another one now): the line is
    /// zeros then, which decode to black.
    bool ReadLine(std::uint32_t line, TextureLine* out) const;
    /// The same for lines [first, first + count).
    void ReadLines(std::uint32_t first, std::uint32_t count, TextureLine* out) const;

    /// A mip as linear RGBA floats [height][width][4], rows from the top; for light tables and
    /// displacement, which need all of it. \return empty when a line cannot be read.
    std::vector<float> DecodeMip(std::uint32_t mip) const;

    /// Bytes of host memory of lines that are in no persistent store.
    std::uint64_t HostBytes() const;

private:
    std::shared_ptr<const LineStore> Lines() const;

    TextureDescription _description;
    Make _make;
    mutable std::mutex _making; ///< held while lines are made; taken before the other
    mutable std::mutex _mutex;
    mutable std::shared_ptr<const LineStore> _lines; ///< never null
    mutable bool _isLost = false;                    ///< making one failed: it is not tried again
};

} // namespace hds
