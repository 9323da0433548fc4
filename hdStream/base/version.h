// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace hds {

/// Version of the program, as files and statistics name it: the only place where it is written.
/// CMakeLists.txt and pyproject.toml read this line.
constexpr const char* kVersion = "0.1.0";

} // namespace hds
