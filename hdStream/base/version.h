// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace hds {

/// Version of the program, as files and statistics name it. CMakeLists.txt and pyproject.toml agree
/// (testenv/unit/base/testVersion.cpp).
constexpr const char* kVersion = "0.1.0";

} // namespace hds
