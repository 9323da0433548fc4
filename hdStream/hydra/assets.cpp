// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/assets.h"

#include "hdStream/hydra/udimSets.h"

#include <pxr/usd/ar/asset.h>
#include <pxr/usd/ar/packageUtils.h>
#include <pxr/usd/ar/resolvedPath.h>
#include <pxr/usd/ar/resolver.h>

#include <cstdio>
#include <memory>

PXR_NAMESPACE_OPEN_SCOPE

hds::AssetReference HdStreamAssetReference(const SdfAssetPath& asset) {
    hds::AssetReference reference;
    reference.authoredPath = asset.GetAssetPath();
    const std::string& resolved = asset.GetResolvedPath();
    const bool isSet = HdStreamIsUdimSet(resolved.empty() ? reference.authoredPath : resolved);
    if (isSet) { // of which the core looks what tiles there are
        reference.file =
            resolved.empty() ? HdStreamResolveUdimSet(reference.authoredPath) : resolved;
        return reference;
    }
    if (!ArIsPackageRelativePath(resolved)) {
        reference.file = resolved;
        return reference;
    }
    const std::shared_ptr<ArAsset> opened = ArGetResolver().OpenAsset(ArResolvedPath(resolved));
    if (!opened) {
        return reference;
    }
    const auto [file, offset] = opened->GetFileUnsafe();
    if (file) { // Entries of a package that are no part of a file cannot be read later.
        reference.file = ArSplitPackageRelativePathOuter(resolved).first;
        reference.offset = offset;
        reference.size = opened->GetSize();
    }
    return reference;
}

PXR_NAMESPACE_CLOSE_SCOPE
