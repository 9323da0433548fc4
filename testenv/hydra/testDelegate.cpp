// SPDX-License-Identifier: Apache-2.0
// What the delegate says of itself: types, AOVs, settings, statistics, commands.
#include "hydraTest.h"

#include <pxr/base/tf/diagnosticMgr.h>
#include <pxr/base/tf/errorMark.h>
#include <pxr/base/tf/stringUtils.h>
#include <pxr/imaging/hd/renderCapabilitiesSchema.h>
#include <pxr/imaging/hd/rendererPlugin.h>
#include <pxr/imaging/hd/rendererPluginHandle.h>
#include <pxr/imaging/hd/rendererPluginRegistry.h>

#include <algorithm>
#include <cstring>
#include <set>

namespace hydraHost {

namespace {

using Delegate = HydraTest;

bool Has(const TfTokenVector& tokens, const TfToken& token) {
    return std::find(tokens.begin(), tokens.end(), token) != tokens.end();
}

TEST_F(Delegate, SupportsTheTypesOfAPathTracer) {
    Host host(EmptyScene(), Quick());
    for (const TfToken& type : {HdPrimTypeTokens->mesh, HdPrimTypeTokens->basisCurves,
                                HdPrimTypeTokens->points, TfToken("particleField")}) {
        EXPECT_TRUE(Has(host.Delegate().GetSupportedRprimTypes(), type)) << type;
    }
    const TfTokenVector& sprims = host.Delegate().GetSupportedSprimTypes();
    for (const TfToken& type :
         {HdPrimTypeTokens->camera, HdPrimTypeTokens->material, HdPrimTypeTokens->extComputation,
          HdPrimTypeTokens->domeLight, HdPrimTypeTokens->distantLight,
          HdPrimTypeTokens->sphereLight, HdPrimTypeTokens->rectLight, HdPrimTypeTokens->diskLight,
          HdPrimTypeTokens->cylinderLight}) {
        EXPECT_TRUE(Has(sprims, type)) << type;
    }
    EXPECT_TRUE(Has(host.Delegate().GetSupportedBprimTypes(), HdPrimTypeTokens->renderBuffer));
    EXPECT_TRUE(Has(host.Delegate().GetSupportedBprimTypes(), HdPrimTypeTokens->renderSettings));
}

TEST_F(Delegate, FallbackPrimsExistForAllTypes) {
    Host host(EmptyScene(), Quick());
    HdRenderDelegate& delegate = host.Delegate();
    for (const TfToken& type : delegate.GetSupportedSprimTypes()) {
        HdSprim* prim = delegate.CreateFallbackSprim(type);
        ASSERT_NE(prim, nullptr) << type;
        delegate.DestroySprim(prim);
    }
    for (const TfToken& type : delegate.GetSupportedBprimTypes()) {
        HdBprim* prim = delegate.CreateFallbackBprim(type);
        ASSERT_NE(prim, nullptr) << type;
        delegate.DestroyBprim(prim);
    }
}

TEST_F(Delegate, SaysThatItBlursMotion) {
    Host host(EmptyScene(), Quick());
    const HdRenderCapabilitiesSchema capabilities(host.Delegate().GetCapabilities());
    ASSERT_TRUE(capabilities.GetMotionBlur());
    EXPECT_TRUE(capabilities.GetMotionBlur()->GetTypedValue(0.0F));
}

TEST_F(Delegate, AsksForFullMaterialsAndUniversalNetworks) {
    Host host(EmptyScene(), Quick());
    EXPECT_EQ(host.Delegate().GetMaterialBindingPurpose(), HdTokens->full);
    EXPECT_FALSE(host.Delegate().GetMaterialRenderContexts().empty());
    EXPECT_TRUE(host.Delegate().IsParallelSyncEnabled(HdPrimTypeTokens->material));
    EXPECT_TRUE(host.Delegate().IsPauseSupported());
    EXPECT_TRUE(host.Delegate().IsStopSupported());
}

TEST_F(Delegate, AdvertisedAovsFillEveryPixel) {
    const TfTokenVector names{
        HdAovTokens->color,    HdAovTokens->depth,      HdAovTokens->cameraDepth,
        HdAovTokens->primId,   HdAovTokens->instanceId, HdAovTokens->elementId,
        HdAovTokens->normal,   HdAovTokens->Neye,       TfToken("primvars:displayColor"),
        TfToken("primvars:st")};
    std::vector<AovRequest> aovs(names.begin(), names.end());
    Host host(ThreeMeshes(), Quick(aovs));
    host.Delegate().Stop(true);
    host.Frame();
    constexpr int kSentinel = 0xCD;
    for (const TfToken& name : names) {
        EXPECT_NE(host.Delegate().GetDefaultAovDescriptor(name).format, HdFormatInvalid) << name;
        HdRenderBuffer* buffer = host.Buffer(name);
        void* pixels = buffer->Map();
        ASSERT_NE(pixels, nullptr) << name;
        std::memset(pixels, kSentinel,
                    size_t(buffer->GetWidth()) * buffer->GetHeight() *
                        HdDataSizeOfFormat(buffer->GetFormat()));
        buffer->Unmap();
    }
    host.Delegate().Restart();
    ASSERT_TRUE(host.RenderUntilConverged());
    for (const TfToken& name : names) {
        const Image image = host.Read(name);
        const size_t pixelBytes = HdDataSizeOfFormat(image.format);
        const std::vector<std::uint8_t> sentinel(pixelBytes, kSentinel);
        for (size_t pixel = 0; pixel < image.bytes.size(); pixel += pixelBytes) {
            ASSERT_NE(std::memcmp(&image.bytes[pixel], sentinel.data(), pixelBytes), 0)
                << name << " pixel " << pixel / pixelBytes;
        }
    }
}

TEST_F(Delegate, UnknownAovsAreInvalid) {
    Host host(EmptyScene(), Quick());
    for (const char* name : {"", "nonsense", "lpe:C<RD", "shader:x", "depthStencil"}) {
        EXPECT_EQ(host.Delegate().GetDefaultAovDescriptor(TfToken(name)).format, HdFormatInvalid)
            << name;
    }
}

TEST_F(Delegate, UnknownAovDoesNotStopTheOthers) {
    AovRequest unknown{TfToken("nonsense")};
    unknown.format = HdFormatFloat32Vec4;
    unknown.clearValue = VtValue(GfVec4f(0.0F));
    Host host(ThreeMeshes(), Quick({HdAovTokens->color, unknown}));
    Host plain(ThreeMeshes(), Quick());
    EXPECT_EQ(host.Render(), plain.Render());
}

TEST_F(Delegate, SettingsRoundTripAndCountVersions) {
    Host host(EmptyScene());
    HdRenderDelegate& delegate = host.Delegate();
    const HdRenderSettingDescriptorList descriptors = delegate.GetRenderSettingDescriptors();
    std::set<TfToken> keys;
    bool isAdvanced = false; // what experts try comes last and says so
    for (const HdRenderSettingDescriptor& descriptor : descriptors) {
        const bool wasAdvanced = isAdvanced;
        isAdvanced = TfStringEndsWith(descriptor.name, " (advanced)");
        EXPECT_TRUE(isAdvanced || !wasAdvanced) << descriptor.key;
        EXPECT_FALSE(descriptor.name.empty()) << descriptor.key;
        EXPECT_TRUE(keys.insert(descriptor.key).second) << descriptor.key << " twice";
        EXPECT_EQ(delegate.GetRenderSetting(descriptor.key), descriptor.defaultValue)
            << descriptor.key;
    }
    EXPECT_TRUE(isAdvanced);
    EXPECT_TRUE(keys.count(TfToken("samples")));
    EXPECT_TRUE(keys.count(TfToken("maxDepth")));
    unsigned int version = delegate.GetRenderSettingsVersion();
    host.SetSetting("samples", VtValue(7));
    EXPECT_NE(delegate.GetRenderSettingsVersion(), version);
    EXPECT_EQ(delegate.GetRenderSetting<int>(TfToken("samples"), -1), 7);
    version = delegate.GetRenderSettingsVersion();
    host.SetSetting("samples", VtValue(7));
    EXPECT_EQ(delegate.GetRenderSettingsVersion(), version) << "nothing changed";
}

TEST_F(Delegate, WrongSettingsKeepTheOldValue) {
    Host host(EmptyScene());
    HdRenderDelegate& delegate = host.Delegate();
    host.SetSetting("samples", VtValue(7));
    for (const VtValue& wrong : {VtValue(-3), VtValue(std::string("many")), VtValue(2.5),
                                 VtValue(GfVec3f(1.0F)), VtValue()}) {
        TfErrorMark mark;
        host.SetSetting("samples", wrong);
        mark.Clear();
        EXPECT_EQ(delegate.GetRenderSetting<int>(TfToken("samples"), -1), 7) << wrong;
    }
    TfErrorMark mark;
    host.SetSetting("pixelFilter", VtValue(std::string("sinc")));
    mark.Clear();
    EXPECT_NE(delegate.GetRenderSetting<std::string>(TfToken("pixelFilter"), ""), "sinc");
}

/// Counts warnings that contain a text.
class WarningCounter : public TfDiagnosticMgr::Delegate {
public:
    explicit WarningCounter(std::string text) : _text(std::move(text)) {
        TfDiagnosticMgr::GetInstance().AddDelegate(this);
    }
    ~WarningCounter() override { TfDiagnosticMgr::GetInstance().RemoveDelegate(this); }
    int Count() const { return _count; }

    void IssueError(const TfError& /*error*/) override {}
    void IssueFatalError(const TfCallContext& /*context*/, const std::string& /*text*/) override {}
    void IssueStatus(const TfStatus& /*status*/) override {}
    void IssueWarning(const TfWarning& warning) override {
        _count += TfStringContains(warning.GetCommentary(), _text) ? 1 : 0;
    }

private:
    std::string _text;
    int _count = 0;
};

TEST_F(Delegate, FormerSpellingsAreToldOnceASession) {
    const WarningCounter warnings("wide is called simd8");
    Host host(EmptyScene());
    for (const char* traversal : {"wide", "scalar", "wide"}) {
        host.SetSetting("traversal", VtValue(std::string(traversal)));
    }
    EXPECT_EQ(warnings.Count(), 1);
    EXPECT_EQ(host.Delegate().GetRenderSetting<std::string>(TfToken("traversal"), ""), "simd8");
}

TEST_F(Delegate, SettingsOfConstructionCount) {
    HostOptions options = Quick();
    options.settings[TfToken("samples")] = VtValue(3);
    Host host(ThreeMeshes(), options);
    EXPECT_EQ(host.Delegate().GetRenderSetting<int>(TfToken("samples"), -1), 3);
    ASSERT_TRUE(host.RenderUntilConverged());
    EXPECT_EQ(host.Statistic("image.samples"), 3.0);
}

TEST_F(Delegate, StatisticsHaveTheKeysOfTheDesignAndOfHydra) {
    Host host(ThreeMeshes(), Quick());
    ASSERT_TRUE(host.RenderUntilConverged());
    for (const char* key :
         {"image.width",        "image.height",    "image.samples",        "time.prepare",
          "time.compile",       "time.trace",      "time.shade",           "time.firstPixel",
          "time.render",        "time.total",      "memory.pathState",     "memory.film",
          "memory.devicePeak",  "memory.hostPeak", "geometry.meshes",      "geometry.instances",
          "geometry.triangles", "geometry.chunks", "geometry.chunksBuilt", "geometry.bytesTotal",
          "rays.camera",        "rays.shadow",     "accuracy.nanSamples",  "percentDone",
          "numCompletedSamples"}) {
        EXPECT_GE(host.Statistic(key), 0.0) << key;
    }
    EXPECT_EQ(host.Statistic("image.width"), 64.0);
    EXPECT_EQ(host.Statistic("geometry.meshes"), 3.0);
    EXPECT_EQ(host.Statistic("percentDone"), 100.0);
    EXPECT_EQ(host.Statistic("accuracy.nanSamples"), 0.0);
}

TEST_F(Delegate, CommandsWorkAndUnknownOnesDoNot) {
    const std::string folder = ::testing::TempDir() + "hydraCommands";
    HostOptions options = Quick();
    options.settings[TfToken("cacheDirectory")] = VtValue(folder); // clearCache must not meet ours
    Host host(ThreeMeshes(), options);
    const Image before = host.Render();
    const HdCommandDescriptors commands = host.Delegate().GetCommandDescriptors();
    EXPECT_FALSE(commands.empty());
    for (const HdCommandDescriptor& command : commands) {
        HdCommandArgs arguments;
        for (const HdCommandArgDescriptor& argument : command.commandArgs) {
            arguments[argument.argName] = VtValue(folder + ".txt");
        }
        EXPECT_TRUE(host.Delegate().InvokeCommand(command.commandName, arguments))
            << command.commandName;
        EXPECT_EQ(host.Render(), before) << command.commandName;
    }
    EXPECT_FALSE(host.Delegate().InvokeCommand(TfToken("nonsense")));
}

TEST_F(Delegate, PluginIsSupportedWithoutAGpu) {
    HdRendererPluginRegistry& registry = HdRendererPluginRegistry::GetInstance();
    const HdRendererPluginHandle plugin = registry.GetOrCreateRendererPlugin(RendererId());
    ASSERT_TRUE(plugin);
    EXPECT_EQ(plugin->GetDisplayName(), "Stream");
#if PXR_VERSION < 2511
    EXPECT_TRUE(plugin->IsSupported(false));
    EXPECT_TRUE(plugin->IsSupported(true));
#endif
}

} // namespace

} // namespace hydraHost
