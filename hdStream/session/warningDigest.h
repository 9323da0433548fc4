// SPDX-License-Identifier: Apache-2.0
// Many warnings as the few lines that a person reads. The statistics keep each one.
#pragma once

#include <string>
#include <vector>

namespace hds {

/// One line a kind: "/A, /B, /C and 37 more: TEXT". Warnings "PRIM: TEXT" are of one kind when
/// their texts differ in nothing but numbers and paths of prims; then that of the first prim stands
/// for all, with "(or alike)" behind it. What is alone of its kind, and what names no prim, stays
/// as it is. Sorted, so that the result does not depend on the order of `lines`.
std::vector<std::string> DigestWarnings(std::vector<std::string> lines);

} // namespace hds
