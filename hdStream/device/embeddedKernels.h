// SPDX-License-Identifier: Apache-2.0
// The table of kernel sources that cmake/embedKernels.py compiles into the library.
#pragma once

#include <cstddef>

namespace hds {

/// One file of kernels/; `path` is relative to that folder, `bytes` is followed by a zero.
struct EmbeddedKernel {
    const char* path;
    const unsigned char* bytes;
    std::size_t size;
};

const EmbeddedKernel* EmbeddedKernels();
std::size_t NumEmbeddedKernels();

} // namespace hds
