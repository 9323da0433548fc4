// SPDX-License-Identifier: Apache-2.0
// Paths of UDIM sets that Hydra hands over as authored. OpenUSD's scene indices do not resolve
// them: no file has the token in its name. What they are relative to is the layer that authors
// them, which is looked for among those that are loaded.
#pragma once

#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// Whether a path names a set of tiles.
bool HdStreamIsUdimSet(const std::string& path);

/// The path of a set, with the token in it, as the first loaded layer means it that authors it as
/// the value of an attribute and of which there is a tile; by the order of the layers' identifiers.
/// Empty: there is none. Thread-safe.
std::string HdStreamResolveUdimSet(const std::string& authored);

PXR_NAMESPACE_CLOSE_SCOPE
