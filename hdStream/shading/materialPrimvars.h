// SPDX-License-Identifier: Apache-2.0
// What a material looks for on a prim: primvars that nothing looks for are no part of pages.
// Explained in docs/geometry.md.
#pragma once

#include "hdStream/shading/materialCompiler.h"

#include <set>
#include <string>

namespace hds {

/// The names of the primvars that a material may read, also where it falls back from one to
/// another, and those that displace.
std::set<std::string> PrimvarsOf(const CompiledMaterial& material);

} // namespace hds
