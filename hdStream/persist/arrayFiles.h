// SPDX-License-Identifier: Apache-2.0
// The files that arrays of a scene are mapped from. What is written into such a file changes the
// arrays of whoever holds them, without a word. Explained in docs/memory-budgets.md.
#pragma once

#include "hdStream/base/arraySource.h"

#include <string>
#include <vector>

namespace hds {

/// Knows how the files of array sources were when their arrays were read first. Thread-safe.
class ArrayFiles {
public:
    /// Remembers files as they are now; those that cannot be looked at are left out.
    static void Watch(const ArraySource* source, const std::vector<std::string>& paths);
    static void Forget(const ArraySource* source);
    /// \throws Error that names the file, where one has been written into since. One that was
    /// deleted, or replaced by another of its name, stays mapped as it was.
    static void Check(const ArraySource* source);
};

} // namespace hds
