// SPDX-License-Identifier: Apache-2.0
// Kernel sources: they are embedded, and includes are expanded by us, so that the hash of the text
// is the whole truth and compiler messages name our files. HDSTREAM_KERNEL_DIR=<dir> reads them
// from a folder instead (for work on kernels). Explained in docs/device.md.
#pragma once

#include <string>

namespace hds {

/// The complete text of a root with all includes expanded once, in order, with #line directives.
/// \param root path below kernels/ ("integrator/shade.cl"), or the text itself when `text` is
/// given. \throws Error that names the including file when an include does not exist.
std::string ExpandKernelSource(const std::string& root, const std::string* text = nullptr);

/// A compiler's messages, where lines of the whole text ("<kernel>:18260:15", as drivers say that
/// do not heed #line) are named by our files instead ("math/wideEnd.clh:7:15").
/// \param text as of ExpandKernelSource.
std::string NameKernelLines(const std::string& log, const std::string& text);

/// Sources cannot change while the process runs.
bool AreKernelsEmbedded();

/// Of all kernel sources as programs read them: pictures of equal scenes and settings have equal
/// bits on a device only where it is equal. \throws Error when a source is missing.
std::string KernelSourceHash();

} // namespace hds
