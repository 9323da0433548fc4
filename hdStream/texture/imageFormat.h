// SPDX-License-Identifier: Apache-2.0
// Which of OpenImageIO's readers an image wants. A wrong extension is common, so content decides
// first. Thread-safe.
#pragma once

#include <cstdint>
#include <istream>
#include <string>

namespace hds {

/// OpenImageIO's name of the reader for a file that starts with these bytes (64 suffice), for the
/// formats that renderers meet; empty when they say nothing.
std::string FormatOfContent(const std::string& head);

/// The reader for a name's extension ("a.png", "package.usdz[textures/a.png]"); empty when there is
/// none. Looked up here because OpenImageIO itself would go on to try every reader it has, video
/// and medical ones included.
std::string FormatOfName(const std::string& name);

/// Whether the chunks of a PNG (its specification, section 5.3: length, type, data, CRC) reach IEND
/// inside the `size` bytes from `begin`. Asked because libpng prints a line of its own to stderr
/// about a file that is cut off.
bool HasPngEnd(std::istream& file, std::uint64_t begin, std::uint64_t size);

} // namespace hds
