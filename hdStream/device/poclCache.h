// SPDX-License-Identifier: Apache-2.0
// Work-around: PoCL (3.1 to 6) reports no device, or aborts, when it cannot create its own kernel
// cache, as with a read-only home folder in a container or on a farm.
// Can go when testenv/cli's test of a read-only home passes without it.
#pragma once

namespace hds {

/// Points POCL_CACHE_DIR to a folder of ours in the temporary directory when it is not set and the
/// folder PoCL would take cannot be written. Changes the environment of the process: called once,
/// before the first OpenCL call.
void EnsurePoclCache();

} // namespace hds
