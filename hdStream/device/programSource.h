// SPDX-License-Identifier: Apache-2.0
// What a program is compiled from, and the key of its binary in the store.
// Explained in docs/device.md.
#pragma once

#include "hdStream/device/device.h"

#include <map>
#include <memory>
#include <string>

namespace hds {

/// Defines of a program: macros of kernels/shared/features.def, sorted by name
/// ("HDS_FEATURE_CUTOUT" -> "1"). Those that are left out have the table's defaults.
using ProgramDefines = std::map<std::string, std::string>;

/// All that the binary of a program depends on, besides the device.
struct ProgramSource {
    std::string root;                        ///< names it in messages
    std::shared_ptr<const std::string> text; ///< with all includes expanded; programs share it
    std::string options; ///< of the compiler: they define those macros that the text names
    std::string key;     ///< of its binary for one device
};

/// \param root of kernels/ or, for tests, the name of `text` (which may #include kernel modules).
/// \throws Error when a source does not exist.
ProgramSource MakeProgramSource(const DeviceProperties& device, const std::string& root,
                                const ProgramDefines& defines, const std::string* text = nullptr);

} // namespace hds
