// SPDX-License-Identifier: Apache-2.0
// Edits of what lights are linked to, where hosts run scene indices: OpenUSD's
// HdsiLightLinkingSceneIndex, which this one comes before, reads an expression that it has freed
// when one is replaced by another (25.02: _Cache::ProcessCollection; testenv/hydra/
// test_lightEdits.py tells when this can go).
#pragma once

#include <pxr/imaging/hd/filteringSceneIndex.h>
#include <pxr/pxr.h>
#include <pxr/usd/sdf/path.h>
#include <pxr/usd/sdf/pathExpression.h>

#include <map>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// Removes a light whose links are replaced, and adds it again; otherwise its input. Keeps the
/// expressions of lights that link.
class HdStreamLinkSceneIndex final : public HdSingleInputFilteringSceneIndexBase {
public:
    static HdSceneIndexBaseRefPtr New(const HdSceneIndexBaseRefPtr& inputScene);

    HdSceneIndexPrim GetPrim(const SdfPath& path) const override;
    SdfPathVector GetChildPrimPaths(const SdfPath& path) const override;

protected:
    explicit HdStreamLinkSceneIndex(const HdSceneIndexBaseRefPtr& inputScene);

    void _PrimsAdded(const HdSceneIndexBase& sender,
                     const HdSceneIndexObserver::AddedPrimEntries& entries) override;
    void _PrimsRemoved(const HdSceneIndexBase& sender,
                       const HdSceneIndexObserver::RemovedPrimEntries& entries) override;
    void _PrimsDirtied(const HdSceneIndexBase& sender,
                       const HdSceneIndexObserver::DirtiedPrimEntries& entries) override;

private:
    using Expressions = std::vector<SdfPathExpression>;

    /// Keeps a light's expressions. \return true when it had others.
    bool Replace(const SdfPath& path);

    std::map<SdfPath, Expressions> _expressions; ///< of lights with some
};

PXR_NAMESPACE_CLOSE_SCOPE
