// SPDX-License-Identifier: Apache-2.0
// The render delegate: makes prims, keeps settings, controls the render thread. It only translates;
// what a scene means is decided in the core. Explained in docs/hydra.md.
#pragma once

#include "hdStream/hydra/deepProducts.h"
#include "hdStream/hydra/hostStatus.h"
#include "hdStream/hydra/materialFrames.h"
#include "hdStream/hydra/renderParam.h"
#include "hdStream/hydra/settingsBridge.h"

#include <pxr/imaging/hd/renderDelegate.h>
#include <pxr/imaging/hd/resourceRegistry.h>
#include <pxr/pxr.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// One renderer of one render index. Delegates share nothing: several may live at once, and one may
/// go while others render. Application's thread only, but for Sync of the prims it makes.
class HdStreamRenderDelegate final : public HdRenderDelegate {
public:
    explicit HdStreamRenderDelegate(const HdRenderSettingsMap& settings);
    /// Ends the render and waits for that.
    ~HdStreamRenderDelegate() override;

    HdStreamRenderParam& Param() const { return *_param; }

    /// Settings of the application and the scene, without what a render pass decides.
    hds::Settings ComposeSettings();

    /// Passes of a view are rendered at once: what they all want, each once, given what `pass`
    /// wants now. Empty: it wants nothing.
    std::vector<std::string> UnionOfAovs(const HdRenderPass* pass, std::vector<std::string> aovs);
    void ForgetAovs(const HdRenderPass* pass);

    /// Seconds for which a host waits for the render at a time (render setting `hostStepSeconds`);
    /// 0: it never waits. Its passes say that they have converged after each step: Blender hands
    /// control back to its add-on then, and only then.
    double HostStepSeconds() const { return _hostStepSeconds; }

    /// Writes the deep pictures that the host leaves to the renderer, once for each version that is
    /// rendered to its end. Waits for that. \param settings of the present version.
    void WriteDeepProducts(const hds::Settings& settings);

    /// Writes the scene to the file of HDSTREAM_DUMP_SCENE, the first time.
    void DumpOnce();

    // --- HdRenderDelegate ------------------------------------------------------------------------
    const TfTokenVector& GetSupportedRprimTypes() const override;
    /// In the order in which they are synced: materials before lights and cameras.
    const TfTokenVector& GetSupportedSprimTypes() const override;
    const TfTokenVector& GetSupportedBprimTypes() const override;
    HdRenderParam* GetRenderParam() const override { return _param.get(); }
    HdResourceRegistrySharedPtr GetResourceRegistry() const override { return _resourceRegistry; }

    void SetRenderSetting(const TfToken& key, const VtValue& value) override;
    VtValue GetRenderSetting(const TfToken& key) const override;
    HdRenderSettingDescriptorList GetRenderSettingDescriptors() const override;
    VtDictionary GetRenderStats() const override;
    HdContainerDataSourceHandle GetCapabilities() const override;

    bool IsPauseSupported() const override { return true; }
    bool IsPaused() const override;
    bool Pause() override;
    bool Resume() override;
    bool IsStopSupported() const override { return true; }
    bool IsStopped() const override;
    bool Stop(bool blocking) override;
    bool Restart() override;

    HdRenderPassSharedPtr CreateRenderPass(HdRenderIndex* index,
                                           const HdRprimCollection& collection) override;
    HdInstancer* CreateInstancer(HdSceneDelegate* delegate, const SdfPath& id) override;
    void DestroyInstancer(HdInstancer* instancer) override;
    HdRprim* CreateRprim(const TfToken& typeId, const SdfPath& id) override;
    void DestroyRprim(HdRprim* rprim) override;
    HdSprim* CreateSprim(const TfToken& typeId, const SdfPath& id) override;
    HdSprim* CreateFallbackSprim(const TfToken& typeId) override;
    void DestroySprim(HdSprim* sprim) override;
    HdBprim* CreateBprim(const TfToken& typeId, const SdfPath& id) override;
    HdBprim* CreateFallbackBprim(const TfToken& typeId) override;
    void DestroyBprim(HdBprim* bprim) override;

    /// Hands the edits of all synced prims to the render thread; returns at once.
    void CommitResources(HdChangeTracker* tracker) override;

    TfToken GetMaterialBindingPurpose() const override;
    TfTokenVector GetMaterialRenderContexts() const override;
    TfTokenVector GetRenderSettingsNamespaces() const override;
    bool IsPrimvarFilteringNeeded() const override { return false; }
    bool IsParallelSyncEnabled(const TfToken& primType) const override;
    HdAovDescriptor GetDefaultAovDescriptor(const TfToken& name) const override;
    HdCommandDescriptors GetCommandDescriptors() const override;
    bool InvokeCommand(const TfToken& command, const HdCommandArgs& arguments) override;

private:
    HdStreamSettingsBridge _settings;
    hds::Settings _composed;
    unsigned int _composedVersion = 0;      ///< of the application's settings
    unsigned int _composedSceneVersion = 0; ///< of the scene's
    bool _isComposed = false;
    bool _isDumped = false;
    std::map<const HdRenderPass*, std::vector<std::string>> _aovsByPass;
    mutable std::weak_ptr<const hds::RenderStatus> _statsOf; ///< what `_stats` are of
    mutable VtDictionary _stats;
    HdResourceRegistrySharedPtr _resourceRegistry;
    double _hostStepSeconds = 0.0;
    std::vector<HdStreamDeepProduct> _deepProducts;
    std::uint64_t _deepVersion = 0; ///< whose deep products are written; 0: none
    std::unique_ptr<HdStreamRenderParam> _param;
    HdStreamMaterialFrames _materialFrames;
    HdStreamHostStatus _hostStatus; ///< last: nobody asks while the rest goes
};

PXR_NAMESPACE_CLOSE_SCOPE
