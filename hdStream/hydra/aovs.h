// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pxr/imaging/hd/aov.h>
#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// The name of the core's layer for an output of Hydra's: the same, but for "primvars_NAME", which
/// stands for "primvars:NAME" where a host makes names of prims from those of outputs, as Blender.
std::string HdStreamAovName(const TfToken& name);

/// \overload of a binding, whose settings may say more: of a render var's sourceType "lpe" or
/// "primvar" its sourceName counts, of others where the name is none of ours.
std::string HdStreamAovName(const HdRenderPassAovBinding& binding);

/// How Hydra is to allocate a buffer for an output: those of the core's AOV table, "primvars:NAME",
/// "lpe:EXPRESSION" and "lightGroup:NAME". Invalid for everything else, so that nothing is offered
/// that would not be filled; an expression that cannot be read is warned of, once. Thread-safe.
HdAovDescriptor HdStreamAovDescriptor(const TfToken& name);

PXR_NAMESPACE_CLOSE_SCOPE
