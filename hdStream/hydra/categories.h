// SPDX-License-Identifier: Apache-2.0
// Hydra's categories: what the collections of lights hold (light and shadow linking).
#pragma once

#include <pxr/base/tf/token.h>
#include <pxr/base/vt/array.h>
#include <pxr/pxr.h>

#include <set>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// Categories as the core has them.
inline std::set<std::string> HdStreamCategories(const VtArray<TfToken>& tokens) {
    std::set<std::string> categories;
    for (const TfToken& token : tokens) {
        categories.insert(token.GetString());
    }
    return categories;
}

PXR_NAMESPACE_CLOSE_SCOPE
