// SPDX-License-Identifier: Apache-2.0
// The render pass: tells the render thread what to render and shows what it has published. Waits
// for it only while that writes files that hosts leave to the renderer.
#pragma once

#include "hdStream/hydra/pictures.h"
#include "hdStream/session/renderThread.h"

#include <pxr/base/gf/matrix4d.h>
#include <pxr/imaging/hd/renderPass.h>
#include <pxr/imaging/hd/renderPassState.h>
#include <pxr/pxr.h>

#include <memory>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderDelegate;

/// A pass over what its collection holds. Application's thread only.
class HdStreamRenderPass final : public HdRenderPass {
public:
    HdStreamRenderPass(HdRenderIndex* index, const HdRprimCollection& collection,
                       HdStreamRenderDelegate* delegate);
    ~HdStreamRenderPass() override;

    /// True once the final image, or an error, was shown in the bound buffers; after each step of a
    /// host that takes steps.
    bool IsConverged() const override;

protected:
    void _Execute(const HdRenderPassStateSharedPtr& state,
                  const TfTokenVector& renderTags) override;

private:
    hds::Settings MakeSettings(const HdRenderPassState& state, const TfTokenVector& renderTags);
    /// The scene path of the pass's camera; one made of its matrices when it has none.
    std::string CameraPath(const HdRenderPassState& state, hds::Settings* settings);
    /// Shows what is newest. \param version that is asked for.
    void Show(const HdRenderPassState& state, std::uint64_t version);
    /// What is bound will not change.
    void SetConverged(const HdRenderPassState& state);
    /// Reports an image's error, once while it lasts.
    void Report(const hds::FilmImage& image);
    /// Prints the warnings of a version once it has a picture, and the late ones at its end.
    void PrintWarnings(const hds::FilmImage& image);

    HdStreamRenderDelegate* _delegate;
    const std::string _cameraPath; ///< of the camera made of matrices
    bool _hasCamera = false;       ///< it was made
    GfMatrix4d _worldToView{0.0};
    GfMatrix4d _projection{0.0};
    std::string _reported;                       ///< the error that was reported last
    std::uint64_t _warnedVersion = 0;            ///< whose warnings were printed
    std::shared_ptr<HdStreamPictures> _pictures; ///< that buffers show
    bool _isConverged = false;
};

PXR_NAMESPACE_CLOSE_SCOPE
