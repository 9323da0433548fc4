// SPDX-License-Identifier: Apache-2.0
// What PoCL reads from the environment of the process.
#pragma once

namespace hds {

/// Sets it, once; what the user has set stays. Call it before there are threads: a variable that is
/// new moves the table of all, which getenv in another thread may be reading. Sessions do.
void ReadyPoclEnvironment();

} // namespace hds
