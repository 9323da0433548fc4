// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/renderDelegate.h"

#include "hdStream/hydra/aovs.h"
#include "hdStream/hydra/camera.h"
#include "hdStream/hydra/commands.h"
#include "hdStream/hydra/curves.h"
#include "hdStream/hydra/instancer.h"
#include "hdStream/hydra/light.h"
#include "hdStream/hydra/lightParameters.h"
#include "hdStream/hydra/material.h"
#include "hdStream/hydra/materialContexts.h"
#include "hdStream/hydra/mesh.h"
#include "hdStream/hydra/renderBuffer.h"
#include "hdStream/hydra/renderPass.h"
#include "hdStream/hydra/renderSettings.h"
#include "hdStream/hydra/renderStats.h"
#include "hdStream/hydra/sceneDump.h"
#include "hdStream/hydra/volume.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/imaging/hd/coordSys.h>
#include <pxr/imaging/hd/extComputation.h>
#include <pxr/imaging/hd/renderCapabilitiesSchema.h>
#include <pxr/imaging/hd/retainedDataSource.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <set>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

const TfToken kHostExporter("hostExporter");
const TfToken kHostStatusName("hostStatusName");
const TfToken kHostStepSeconds("hostStepSeconds");
const TfToken kDelegateRenderProducts("delegateRenderProducts"); // husk's name

bool Contains(const TfTokenVector& tokens, const TfToken& token) {
    return std::find(tokens.begin(), tokens.end(), token) != tokens.end();
}

/// Lights that are accepted, warn, and are left out.
const TfTokenVector& UnsupportedLightTypes() {
    static const TfTokenVector types{HdPrimTypeTokens->meshLight, HdPrimTypeTokens->pluginLight,
                                     HdPrimTypeTokens->lightFilter, TfToken("geometryLight"),
                                     TfToken("portalLight")};
    return types;
}

} // namespace

HdStreamRenderDelegate::HdStreamRenderDelegate(const HdRenderSettingsMap& settings)
    : _resourceRegistry(std::make_shared<HdResourceRegistry>()),
      _param(std::make_unique<HdStreamRenderParam>()), _hostStatus(_param.get()) {
    _PopulateDefaultSettings(GetRenderSettingDescriptors());
    for (const auto& [key, value] : settings) {
        SetRenderSetting(key, value);
    }
    // While the application fills the scene.
    _param->Thread().Warm(ComposeSettings());
}

HdStreamRenderDelegate::~HdStreamRenderDelegate() = default;

hds::Settings HdStreamRenderDelegate::ComposeSettings() {
    const unsigned int version = GetRenderSettingsVersion();
    const unsigned int sceneVersion = _param->SceneSettingsVersion();
    if (!_isComposed || version != _composedVersion || sceneVersion != _composedSceneVersion) {
        std::vector<std::string> problems;
        _composed = _settings.Compose(_param->SceneSettings(), &problems);
        for (const std::string& problem : problems) {
            TF_WARN("render settings of the scene: %s", problem.c_str());
        }
        _composedVersion = version;
        _composedSceneVersion = sceneVersion;
        _isComposed = true;
    }
    hds::Settings settings = _composed;
    if (settings.subdivision == "complexity" && !_settings.IsSet("refineLevel")) {
        settings.refineLevel = static_cast<std::uint32_t>(std::max(0, _param->RefineLevel()));
    }
    // usdrecord and farms say no; hosts in which someone moves the camera say nothing.
    settings.interactive =
        HdRenderDelegate::GetRenderSetting<bool>(HdRenderSettingsTokens->enableInteractive, true);
    settings.cameraMoves = settings.interactive;
    settings.deep = !_deepProducts.empty();
    return settings;
}

std::vector<std::string> HdStreamRenderDelegate::UnionOfAovs(const HdRenderPass* pass,
                                                             std::vector<std::string> aovs) {
    if (aovs.empty()) {
        _aovsByPass.erase(pass);
        return {};
    }
    _aovsByPass[pass] = std::move(aovs);
    std::set<std::string> all;
    for (const auto& [other, names] : _aovsByPass) {
        all.insert(names.begin(), names.end());
    }
    return {all.begin(), all.end()};
}

void HdStreamRenderDelegate::ForgetAovs(const HdRenderPass* pass) {
    _aovsByPass.erase(pass);
}

void HdStreamRenderDelegate::WriteDeepProducts(const hds::Settings& settings) {
    hds::RenderThread& thread = _param->Thread();
    if (_deepProducts.empty() || !thread.IsConverged()) {
        return;
    }
    const std::shared_ptr<const hds::FilmImage> image = thread.Newest();
    if (!image || !image->isFinal || !image->error.empty() || image->version != thread.Version() ||
        image->version == _deepVersion) {
        return;
    }
    _deepVersion = image->version;
    try {
        thread.Call([&](hds::Session& session) {
            HdStreamWriteDeepProducts(_deepProducts, settings, session);
        });
    } catch (const hds::Error& error) {
        TF_RUNTIME_ERROR("Stream: %s", error.what());
    }
}

void HdStreamRenderDelegate::DumpOnce() {
    if (!_isDumped && !HdStreamDumpFile().empty()) {
        HdStreamPostDump(_param.get(), HdStreamDumpFile());
    }
    _isDumped = true;
}

// --- Prims ---------------------------------------------------------------------------------------

const TfTokenVector& HdStreamRenderDelegate::GetSupportedRprimTypes() const {
    static const TfTokenVector types{HdPrimTypeTokens->mesh, HdPrimTypeTokens->basisCurves,
                                     HdPrimTypeTokens->points, HdPrimTypeTokens->volume,
                                     HdStreamParticleField()};
    return types;
}

const TfTokenVector& HdStreamRenderDelegate::GetSupportedSprimTypes() const {
    static const TfTokenVector types = [] {
        TfTokenVector result{HdPrimTypeTokens->material,    HdPrimTypeTokens->extComputation,
                             HdPrimTypeTokens->coordSys,    HdPrimTypeTokens->camera,
                             HdPrimTypeTokens->simpleLight, HdPrimTypeTokens->distantLight,
                             HdPrimTypeTokens->sphereLight, HdPrimTypeTokens->rectLight,
                             HdPrimTypeTokens->diskLight,   HdPrimTypeTokens->cylinderLight,
                             HdPrimTypeTokens->domeLight};
        result.insert(result.end(), UnsupportedLightTypes().begin(), UnsupportedLightTypes().end());
        return result;
    }();
    return types;
}

const TfTokenVector& HdStreamRenderDelegate::GetSupportedBprimTypes() const {
    static const TfTokenVector types = [] {
        TfTokenVector result{HdPrimTypeTokens->renderBuffer, HdPrimTypeTokens->renderSettings};
        result.insert(result.end(), HdStreamFieldTypes().begin(), HdStreamFieldTypes().end());
        return result;
    }();
    return types;
}

HdRprim* HdStreamRenderDelegate::CreateRprim(const TfToken& typeId, const SdfPath& id) {
    if (typeId == HdPrimTypeTokens->mesh) {
        return new HdStreamMesh(id);
    }
    if (typeId == HdPrimTypeTokens->basisCurves) {
        return new HdStreamBasisCurves(id);
    }
    if (typeId == HdPrimTypeTokens->points) {
        return new HdStreamPoints(id);
    }
    if (typeId == HdStreamParticleField()) {
        return new HdStreamSplats(id);
    }
    if (typeId == HdPrimTypeTokens->volume) {
        return new HdStreamVolume(id);
    }
    TF_CODING_ERROR("Stream makes no rprims of type %s", typeId.GetText());
    return nullptr;
}

HdSprim* HdStreamRenderDelegate::CreateSprim(const TfToken& typeId, const SdfPath& id) {
    if (typeId == HdPrimTypeTokens->material) {
        return new HdStreamMaterial(id, &_materialFrames);
    }
    if (typeId == HdPrimTypeTokens->camera) {
        return new HdStreamCamera(id);
    }
    if (typeId == HdPrimTypeTokens->extComputation) {
        return new HdExtComputation(id);
    }
    if (typeId == HdPrimTypeTokens->coordSys) {
        return new HdCoordSys(id);
    }
    if (const std::optional<hds::LightType> light = HdStreamFindLightType(typeId)) {
        return new HdStreamLight(id, typeId, *light);
    }
    if (Contains(UnsupportedLightTypes(), typeId)) {
        return new HdStreamUnsupportedLight(id, typeId);
    }
    TF_CODING_ERROR("Stream makes no sprims of type %s", typeId.GetText());
    return nullptr;
}

HdSprim* HdStreamRenderDelegate::CreateFallbackSprim(const TfToken& typeId) {
    return CreateSprim(typeId, SdfPath::EmptyPath());
}

HdBprim* HdStreamRenderDelegate::CreateBprim(const TfToken& typeId, const SdfPath& id) {
    if (typeId == HdPrimTypeTokens->renderBuffer) {
        return new HdStreamRenderBuffer(id);
    }
    if (typeId == HdPrimTypeTokens->renderSettings) {
        return new HdStreamRenderSettings(id);
    }
    if (Contains(HdStreamFieldTypes(), typeId)) {
        return new HdStreamVolumeField(id);
    }
    TF_CODING_ERROR("Stream makes no bprims of type %s", typeId.GetText());
    return nullptr;
}

HdBprim* HdStreamRenderDelegate::CreateFallbackBprim(const TfToken& typeId) {
    return CreateBprim(typeId, SdfPath::EmptyPath());
}

HdInstancer* HdStreamRenderDelegate::CreateInstancer(HdSceneDelegate* delegate, const SdfPath& id) {
    return new HdStreamInstancer(delegate, id);
}

HdRenderPassSharedPtr
HdStreamRenderDelegate::CreateRenderPass(HdRenderIndex* index,
                                         const HdRprimCollection& collection) {
    return std::make_shared<HdStreamRenderPass>(index, collection, this);
}

// Hydra has called Finalize, which queued the removal from the scene.
void HdStreamRenderDelegate::DestroyInstancer(HdInstancer* instancer) {
    delete instancer;
}

void HdStreamRenderDelegate::DestroyRprim(HdRprim* rprim) {
    delete rprim;
}

void HdStreamRenderDelegate::DestroySprim(HdSprim* sprim) {
    delete sprim;
}

void HdStreamRenderDelegate::DestroyBprim(HdBprim* bprim) {
    delete bprim;
}

void HdStreamRenderDelegate::CommitResources(HdChangeTracker*) {
    for (HdStreamMaterialFrames::Edit& edit : _materialFrames.Update()) {
        _param->Push([edit = std::move(edit)](hds::Session& session) {
            session.SetMaterial(edit.scenePath, edit.network);
        });
    }
    _param->Commit();
}

TfToken HdStreamRenderDelegate::GetMaterialBindingPurpose() const {
    return HdTokens->full;
}

TfTokenVector HdStreamRenderDelegate::GetMaterialRenderContexts() const {
    return HdStreamMaterialContexts();
}

bool HdStreamRenderDelegate::IsParallelSyncEnabled(const TfToken& primType) const {
    return primType == HdPrimTypeTokens->material || primType == HdPrimTypeTokens->camera ||
           primType == HdPrimTypeTokens->extComputation ||
           HdStreamFindLightType(primType).has_value();
}

// --- Settings, statistics, outputs ---------------------------------------------------------------

void HdStreamRenderDelegate::SetRenderSetting(const TfToken& key, const VtValue& value) {
    const std::string name = HdStreamSettingsBridge::NameOf(key);
    if (name.empty()) {
        if (key == kHostStatusName) {
            _hostStatus.SetName(value.GetWithDefault(std::string()));
        } else if (key == kDelegateRenderProducts) {
            std::vector<std::string> problems;
            _deepProducts = HdStreamDeepProducts(value, &problems);
            _deepVersion = 0;
            for (const std::string& problem : problems) {
                _param->PrintWarning("Stream: " + problem);
            }
            HdRenderDelegate::SetRenderSetting(key, value);
        } else if (key == kHostExporter) {
            _param->SetExporter(HdStreamFindExporter(value.GetWithDefault(std::string())));
        } else if (key == kHostStepSeconds) {
            _hostStepSeconds = std::clamp(value.GetWithDefault(0.0), 0.0, 1.0);
        } else {
            HdRenderDelegate::SetRenderSetting(key, value); // of other renderers, or without effect
        }
        return;
    }
    std::string problem;
    if (!_settings.Set(key, value, &problem)) {
        _param->PrintWarning("Stream: " + problem + "; the setting stays as it was");
        return;
    }
    HdRenderDelegate::SetRenderSetting(TfToken(name), _settings.Get(name));
}

VtValue HdStreamRenderDelegate::GetRenderSetting(const TfToken& key) const {
    const std::string name = HdStreamSettingsBridge::NameOf(key);
    return name.empty() ? HdRenderDelegate::GetRenderSetting(key) : _settings.Get(name);
}

HdRenderSettingDescriptorList HdStreamRenderDelegate::GetRenderSettingDescriptors() const {
    return HdStreamSettingsBridge::Descriptors();
}

TfTokenVector HdStreamRenderDelegate::GetRenderSettingsNamespaces() const {
    return {TfToken("hdstream")};
}

VtDictionary HdStreamRenderDelegate::GetRenderStats() const {
    if (_hostStepSeconds > 0.0) {
        _param->Thread().WaitUntilConverged(_hostStepSeconds);
    }
    const std::shared_ptr<const hds::RenderStatus> status = _param->Thread().Status();
    const bool isSame = !_statsOf.owner_before(status) && !status.owner_before(_statsOf);
    if (!isSame) { // Hosts ask often.
        _stats = HdStreamRenderStats(status.get());
        _statsOf = status;
    }
    return _stats;
}

HdContainerDataSourceHandle HdStreamRenderDelegate::GetCapabilities() const {
    static const HdContainerDataSourceHandle capabilities =
        HdRenderCapabilitiesSchema::Builder()
            .SetMotionBlur(HdRetainedTypedSampledDataSource<bool>::New(true))
            .Build();
    return capabilities;
}

HdAovDescriptor HdStreamRenderDelegate::GetDefaultAovDescriptor(const TfToken& name) const {
    return HdStreamAovDescriptor(name);
}

HdCommandDescriptors HdStreamRenderDelegate::GetCommandDescriptors() const {
    return HdStreamCommandDescriptors();
}

bool HdStreamRenderDelegate::InvokeCommand(const TfToken& command, const HdCommandArgs& arguments) {
    return HdStreamInvokeCommand(_param.get(), ComposeSettings().cacheDirectory, command,
                                 arguments);
}

// --- Control -------------------------------------------------------------------------------------

bool HdStreamRenderDelegate::IsPaused() const {
    return _param->Thread().IsPaused();
}

bool HdStreamRenderDelegate::Pause() {
    _param->Thread().Pause();
    return true;
}

bool HdStreamRenderDelegate::Resume() {
    _param->Thread().Resume();
    return true;
}

bool HdStreamRenderDelegate::IsStopped() const {
    return _param->Thread().IsStopped();
}

bool HdStreamRenderDelegate::Stop(bool blocking) {
    _param->Thread().Stop(blocking);
    return true;
}

bool HdStreamRenderDelegate::Restart() {
    _param->Thread().Restart();
    return true;
}

PXR_NAMESPACE_CLOSE_SCOPE
