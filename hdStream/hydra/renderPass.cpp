// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/renderPass.h"

#include "hdStream/hydra/aovs.h"
#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/camera.h"
#include "hdStream/hydra/framing.h"
#include "hdStream/hydra/renderBuffer.h"
#include "hdStream/hydra/renderDelegate.h"
#include "hdStream/hydra/renderParam.h"
#include "hdStream/session/session.h"

#include <pxr/base/gf/camera.h>
#include <pxr/base/tf/diagnostic.h>
#include <pxr/imaging/hd/rprimCollection.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <atomic>
#include <iterator>
#include <utility>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// The path of a new pass's own camera.
std::string NewMatrixCameraPath() {
    static std::atomic<unsigned int> count{0};
    return "/hdStreamMatrixCamera" + std::to_string(count++);
}

/// Purposes that render tags stand for, in one order whatever that of the tags; a host's own tags
/// are purposes of their own. No tags: all.
std::vector<std::string> PurposesFrom(const TfTokenVector& renderTags) {
    static const std::pair<TfToken, const char*> purposes[] = {
        {HdRenderTagTokens->geometry, "default"},
        {HdRenderTagTokens->render, "render"},
        {HdRenderTagTokens->proxy, "proxy"},
        {HdRenderTagTokens->guide, "guide"},
    };
    std::vector<std::string> result;
    for (const auto& [tag, purpose] : purposes) {
        if (renderTags.empty() ||
            std::find(renderTags.begin(), renderTags.end(), tag) != renderTags.end()) {
            result.emplace_back(purpose);
        }
    }
    const std::size_t numKnown = result.size();
    for (const TfToken& tag : renderTags) {
        const bool isKnown = std::any_of(std::begin(purposes), std::end(purposes),
                                         [&](const auto& entry) { return entry.first == tag; });
        if (!isKnown && !tag.IsEmpty()) {
            result.push_back(tag.GetString());
        }
    }
    std::sort(result.begin() + static_cast<std::ptrdiff_t>(numKnown), result.end());
    return result;
}

/// Paths of a collection, in one order; none where the root is among them.
std::vector<std::string> PathsFrom(const SdfPathVector& paths) {
    std::vector<std::string> result;
    for (const SdfPath& path : paths) {
        if (path.IsAbsoluteRootPath()) {
            return {};
        }
        result.push_back(path.GetString());
    }
    std::sort(result.begin(), result.end());
    return result;
}

std::string CullStyleName(HdCullStyle style) {
    switch (style) {
    case HdCullStyleBack:
        return "back";
    case HdCullStyleFront:
        return "front";
    case HdCullStyleBackUnlessDoubleSided:
        return "backUnlessDoubleSided";
    case HdCullStyleFrontUnlessDoubleSided:
        return "frontUnlessDoubleSided";
    default:
        return "nothing";
    }
}

/// The layers that the bindings want, each once.
std::vector<std::string> AovsFrom(const HdRenderPassAovBindingVector& bindings) {
    std::vector<std::string> names;
    for (const HdRenderPassAovBinding& binding : bindings) {
        const std::string name = HdStreamAovName(binding);
        if (HdStreamAovDescriptor(TfToken(name)).format != HdFormatInvalid &&
            std::find(names.begin(), names.end(), name) == names.end()) {
            names.push_back(name);
        }
    }
    return names;
}

/// A camera that projects as two matrices of OpenGL's kind do.
hds::CameraPrim CameraFromMatrices(const GfMatrix4d& worldToView, const GfMatrix4d& projection) {
    GfCamera source;
    source.SetFromViewAndProjectionMatrix(worldToView, projection);
    const auto aperture = static_cast<float>(GfCamera::APERTURE_UNIT);
    hds::CameraPrim camera;
    camera.worldFromCamera = HdStreamToGlm(source.GetTransform());
    camera.orthographic = source.GetProjection() == GfCamera::Orthographic;
    camera.horizontalAperture = source.GetHorizontalAperture() * aperture;
    camera.verticalAperture = source.GetVerticalAperture() * aperture;
    camera.horizontalApertureOffset = source.GetHorizontalApertureOffset() * aperture;
    camera.verticalApertureOffset = source.GetVerticalApertureOffset() * aperture;
    camera.focalLength = source.GetFocalLength() * static_cast<float>(GfCamera::FOCAL_LENGTH_UNIT);
    camera.nearClip = source.GetClippingRange().GetMin();
    camera.farClip = source.GetClippingRange().GetMax();
    return camera;
}

HdStreamRenderBuffer* BufferOf(const HdRenderPassAovBinding& binding, HdRenderIndex* index) {
    HdRenderBuffer* buffer = binding.renderBuffer;
    if (!buffer && !binding.renderBufferId.IsEmpty()) {
        buffer = static_cast<HdRenderBuffer*>(
            index->GetBprim(HdPrimTypeTokens->renderBuffer, binding.renderBufferId));
    }
    return static_cast<HdStreamRenderBuffer*>(buffer);
}

/// Pixels that the buffers of a pass cover, from their common corner.
GfVec2i BufferSize(const HdRenderPassState& state, HdRenderIndex* index) {
    GfVec2i size(0);
    for (const HdRenderPassAovBinding& binding : state.GetAovBindings()) {
        if (const HdStreamRenderBuffer* buffer = BufferOf(binding, index)) {
            size[0] = std::max(size[0], static_cast<int>(buffer->GetWidth()));
            size[1] = std::max(size[1], static_cast<int>(buffer->GetHeight()));
        }
    }
    return size;
}

} // namespace

HdStreamRenderPass::HdStreamRenderPass(HdRenderIndex* index, const HdRprimCollection& collection,
                                       HdStreamRenderDelegate* delegate)
    : HdRenderPass(index, collection), _delegate(delegate), _cameraPath(NewMatrixCameraPath()) {}

HdStreamRenderPass::~HdStreamRenderPass() {
    _delegate->ForgetAovs(this);
    if (_hasCamera) {
        _delegate->Param().Push([path = _cameraPath](hds::Session& session) { //
            session.Remove(path);
        });
    }
}

bool HdStreamRenderPass::IsConverged() const {
    return _isConverged || _delegate->HostStepSeconds() > 0.0;
}

void HdStreamRenderPass::_Execute(const HdRenderPassStateSharedPtr& state,
                                  const TfTokenVector& renderTags) {
    HdStreamRenderParam& param = _delegate->Param();
    const hds::Settings settings = MakeSettings(*state, renderTags);
    if (settings.aovs.empty() || settings.imageWidth == 0 || settings.imageHeight == 0) {
        SetConverged(*state); // Nothing is asked for.
        return;
    }
    _delegate->DumpOnce();
    Show(*state, param.Thread().SetSettings(settings));
    if (_isConverged) {
        _delegate->WriteDeepProducts(settings);
    }
}

hds::Settings HdStreamRenderPass::MakeSettings(const HdRenderPassState& state,
                                               const TfTokenVector& renderTags) {
    hds::Settings settings = _delegate->ComposeSettings();
    HdStreamApplyFraming(HdStreamFramingOf(state), BufferSize(state, GetRenderIndex()), &settings);
    settings.conformPolicy = HdStreamConformPolicy(state.GetWindowPolicy());
    settings.camera = CameraPath(state, &settings);
    settings.purposes = PurposesFrom(renderTags);
    settings.drawnPaths = PathsFrom(GetRprimCollection().GetRootPaths());
    settings.hiddenPaths = PathsFrom(GetRprimCollection().GetExcludePaths());
    settings.cullStyle = CullStyleName(state.GetCullStyle());
    settings.aovs = _delegate->UnionOfAovs(this, AovsFrom(state.GetAovBindings()));
    return settings;
}

void HdStreamRenderPass::SetConverged(const HdRenderPassState& state) {
    for (const HdRenderPassAovBinding& binding : state.GetAovBindings()) {
        if (HdStreamRenderBuffer* buffer = BufferOf(binding, GetRenderIndex())) {
            buffer->SetConverged(true);
        }
    }
    _isConverged = true;
}

std::string HdStreamRenderPass::CameraPath(const HdRenderPassState& state,
                                           hds::Settings* settings) {
    if (const HdCamera* camera = state.GetCamera()) {
        return camera->GetId().GetString();
    }
    // The projection has been fitted to the image already.
    settings->conformPolicy = HdStreamConformPolicy(CameraUtilDontConform);
    const GfMatrix4d worldToView = state.GetWorldToViewMatrix();
    const GfMatrix4d projection = state.GetProjectionMatrix();
    if (!_hasCamera || worldToView != _worldToView || projection != _projection) {
        _hasCamera = true;
        _worldToView = worldToView;
        _projection = projection;
        HdStreamRenderParam& param = _delegate->Param();
        param.Push([path = _cameraPath, camera = CameraFromMatrices(worldToView, projection)](
                       hds::Session& session) { session.SetCamera(path, camera); });
        param.Commit();
    }
    return _cameraPath;
}

void HdStreamRenderPass::Show(const HdRenderPassState& state, std::uint64_t version) {
    hds::RenderThread& thread = _delegate->Param().Thread();
    // In this order: what is newest now is at least what made it converge.
    const bool isConverged = thread.IsConverged();
    if (!_pictures || _pictures->Version() != version) {
        _pictures = std::make_shared<HdStreamPictures>(thread, version);
    }
    const std::shared_ptr<const hds::FilmImage> image = _pictures->Newest();
    if (image) {
        Report(*image);
        PrintWarnings(*image);
    }
    const GfRect2i dataWindow = HdStreamFramingOf(state).dataWindow;
    bool isMapped = false;
    for (const HdRenderPassAovBinding& binding : state.GetAovBindings()) {
        if (HdStreamRenderBuffer* buffer = BufferOf(binding, GetRenderIndex())) {
            const HdStreamShowResult result = buffer->Show(
                image, _pictures, HdStreamAovName(binding), dataWindow, binding.clearValue);
            isMapped |= result == HdStreamShowResult::Mapped;
            buffer->SetConverged(isConverged && result != HdStreamShowResult::Mapped);
        }
    }
    _isConverged = isConverged && !isMapped;
}

void HdStreamRenderPass::PrintWarnings(const hds::FilmImage& image) {
    // The scene has been prepared when it has a picture; what comes later, at the end.
    HdStreamRenderParam& param = _delegate->Param();
    const bool isNew = image.version != _warnedVersion && image.version == param.Thread().Version();
    if (isNew || image.isFinal) {
        _warnedVersion = image.version;
        param.PrintWarnings();
    }
}

void HdStreamRenderPass::Report(const hds::FilmImage& image) {
    if (image.error != _reported) {
        _reported = image.error;
        if (!image.error.empty()) {
            TF_RUNTIME_ERROR("Stream: %s", image.error.c_str());
        }
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
