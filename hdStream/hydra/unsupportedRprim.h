// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pxr/imaging/hd/rprim.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// A geometric prim that the core does not draw yet (curves, points). It is accepted, so that hosts
/// do not report it as unknown, warns once when it would be visible, and is left out.
class HdStreamUnsupportedRprim final : public HdRprim {
public:
    HdStreamUnsupportedRprim(const SdfPath& id, const TfToken& typeId);

    HdDirtyBits GetInitialDirtyBitsMask() const override;
    void Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
              const TfToken& reprToken) override;
    const TfTokenVector& GetBuiltinPrimvarNames() const override;

protected:
    HdDirtyBits _PropagateDirtyBits(HdDirtyBits bits) const override;
    void _InitRepr(const TfToken& reprToken, HdDirtyBits* dirtyBits) override;

private:
    TfToken _typeId;
    bool _hasWarned = false;
};

PXR_NAMESPACE_CLOSE_SCOPE
