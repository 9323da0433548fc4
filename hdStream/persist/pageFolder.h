// SPDX-License-Identifier: Apache-2.0
// The segments of a folder as files: their sizes, and which of them leave for lack of room.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// Paths of the segments, sorted.
std::vector<std::string> ListSegments(const std::string& directory);

/// A path for a new segment: a name that no other process makes.
std::string NewSegmentPath(const std::string& directory);

/// Bytes of disk that the segments take.
std::uint64_t SegmentBytes(const std::string& directory);

/// Removes the least recently used segments until the others take at most `maxBytes`, but none
/// that a process uses. \return the bytes that they take then.
std::uint64_t TrimSegments(const std::string& directory, std::uint64_t maxBytes);

/// Removes all segments. Processes that use one keep what they have open until they end.
/// \return their bytes.
std::uint64_t RemoveSegments(const std::string& directory);

} // namespace hds
