// SPDX-License-Identifier: Apache-2.0
// What a texture cache has done since it was made (docs/statistics.md).
#pragma once

#include <cstdint>

namespace hds {

/// Lines that came and went.
struct LineTraffic {
    std::uint64_t linesLoaded = 0;       ///< different ones
    std::uint64_t uniqueBytesLoaded = 0; ///< of these; lines that share a slot count once
    std::uint64_t uploadedBytes = 0;
    std::uint64_t evictions = 0;

    void Add(const LineTraffic& other) {
        linesLoaded += other.linesLoaded;
        uniqueBytesLoaded += other.uniqueBytesLoaded;
        uploadedBytes += other.uploadedBytes;
        evictions += other.evictions;
    }
};

/// Bytes, seconds and counts.
struct TextureStatistics : LineTraffic {
    LineTraffic grids; ///< the part of it that is lines of volumes
    std::uint64_t openedTextures = 0;
    std::uint64_t setConflicts = 0;   ///< lines that found all of their set in use
    std::uint64_t lookups = 0;        ///< texels read, also by items that had to come again
    std::uint64_t misses = 0;         ///< of these, those whose line was missing
    std::uint64_t fallbackTexels = 0; ///< of these, those that took a coarser mip for good
    std::uint64_t requestRounds = 0;
    std::uint64_t droppedRequests = 0; ///< for want of room in the list; they come again
    double openSeconds = 0.0;          ///< preparing textures
    double readSeconds = 0.0;          ///< of lines
    double requestSeconds = 0.0;       ///< all else

    void Count(const LineTraffic& traffic, bool isOfGrid) {
        Add(traffic);
        if (isOfGrid) {
            grids.Add(traffic);
        }
    }
};

} // namespace hds
