// SPDX-License-Identifier: Apache-2.0
// The render contexts that materials are asked for in. Explained in docs/materials.md.
#pragma once

#include <pxr/base/tf/token.h>
#include <pxr/pxr.h>

#include <cstddef>

PXR_NAMESPACE_OPEN_SCOPE

/// Best first, without those that this thread skips. Thread-safe.
///
/// Scene delegates ask the render delegate for them whenever a network is asked for, and hand over
/// that of the first that the material has, whether its surface is drawn or not.
TfTokenVector HdStreamMaterialContexts();

/// While it lives its thread asks for the networks of later contexts. One at a time.
class HdStreamLaterMaterialContexts {
public:
    /// \param numSkipped of the best
    explicit HdStreamLaterMaterialContexts(std::size_t numSkipped);
    ~HdStreamLaterMaterialContexts();
    HdStreamLaterMaterialContexts(const HdStreamLaterMaterialContexts&) = delete;
    HdStreamLaterMaterialContexts& operator=(const HdStreamLaterMaterialContexts&) = delete;
};

PXR_NAMESPACE_CLOSE_SCOPE
