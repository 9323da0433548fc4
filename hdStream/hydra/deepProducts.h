// SPDX-License-Identifier: Apache-2.0
// Products that hosts leave to the renderer (render setting `delegateRenderProducts`, as husk sets
// it): of these deep pictures, which no render buffer could hold. Explained in docs/hydra.md.
#pragma once

#include "hdStream/session/renderThread.h"

#include <pxr/base/vt/value.h>
#include <pxr/pxr.h>

#include <map>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// A deep EXR to write.
struct HdStreamDeepProduct {
    std::string file;
    bool isHalf = false;                      ///< its colour
    std::map<std::string, std::string> texts; ///< of its header, and its compression
};

/// The deep ones of a value of `delegateRenderProducts`.
/// \param problems one line for each product that is left out
std::vector<HdStreamDeepProduct> HdStreamDeepProducts(const VtValue& value,
                                                      std::vector<std::string>* problems);

/// Writes the products of a session's last render. Render thread only.
/// \param settings it was rendered with. \throws hds::Error
void HdStreamWriteDeepProducts(const std::vector<HdStreamDeepProduct>& products,
                               const hds::Settings& settings, const hds::Session& session);

PXR_NAMESPACE_CLOSE_SCOPE
