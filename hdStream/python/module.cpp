// SPDX-License-Identifier: Apache-2.0
// The module `hdstream._core`: the façade of the core for Python. It binds and converts, nothing
// else; names are those of the C++ headers. Explained in docs/command-line.md.
#include "hdStream/python/bindings.h"
#include "hdStream/python/bufferSpan.h"
#include "hdStream/session/session.h"

NB_MODULE(_core, module) {
    module.doc() = "The core of hdStream.";
    // The process ends with sessions alive when the user interrupts it; that is no leak.
    nanobind::set_leak_warnings(false);
    module.attr("VERSION") = hds::kVersion;
    hds::python::BindMaterials(module);
    hds::python::BindStageArray(module);
    hds::python::BindScene(module);
    hds::python::BindImages(module);
    hds::python::BindSession(module);
    module.def("NumBuffersToRelease", &hds::python::NumBuffersToRelease,
               "Buffers dropped by other threads that the main thread has not released yet.");
}
