// SPDX-License-Identifier: Apache-2.0
// What tells one state of an input file from another, for keys of what is made from it.
#pragma once

#include "hdStream/base/hash.h"

#include <cstdint>
#include <string>

namespace hds {

/// Appends a file's path, size and time of modification, and the first and last bytes of a range of
/// it: an edit that keeps size and time is noticed where file formats keep what differs (headers,
/// checksums, indices). Reads at most 32 KiB. Thread-safe.
/// \param size of the range in bytes; 0: to the end of the file
/// \return false, with nothing appended, when the file cannot be read.
bool AppendFileIdentity(Hasher* hasher, const std::string& path, std::uint64_t offset,
                        std::uint64_t size);

} // namespace hds
