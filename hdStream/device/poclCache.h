// SPDX-License-Identifier: Apache-2.0
// What PoCL reads from the environment of the process.
#pragma once

namespace hds {

/// Sets it, once; what the user has set stays. Call it before there are threads: a variable that is
/// new moves the table of all, which getenv in another thread may be reading. Sessions do.
void ReadyPoclEnvironment();

/// Work-around: PoCL (3.1 to 6) reports no device, or aborts, when it cannot create its own kernel
/// cache, as with a read-only home folder in a container or on a farm. Points POCL_CACHE_DIR to a
/// folder of ours in the temporary directory when it is not set and the folder PoCL would take
/// cannot be written. Can go when testenv/cli's test of a read-only home passes without it.
void EnsurePoclCache();

/// PoCL compiles a kernel for work-groups of any size when it hands out a binary, and once more for
/// each size, and for large and small ranges, when it is launched. From here on it launches what is
/// in the binary. The bits are the same, and so is the time of our kernels (docs/device.md).
void ShareWorkGroupSizes();

/// PoCL sets the variable by which hwloc loads no plug-ins whenever it looks for devices. From here
/// on it is there already.
void SetHwlocPlugins();

} // namespace hds
