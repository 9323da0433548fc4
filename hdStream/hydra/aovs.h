// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pxr/imaging/hd/aov.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// How Hydra is to allocate a buffer for an output: those of the core's AOV table and
/// "primvars:NAME", whose layers have the same names. Invalid for everything else, so that nothing
/// is offered that would not be filled. Thread-safe.
HdAovDescriptor HdStreamAovDescriptor(const TfToken& name);

PXR_NAMESPACE_CLOSE_SCOPE
