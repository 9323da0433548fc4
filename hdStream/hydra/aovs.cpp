// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/aovs.h"

#include "hdStream/session/session.h"

#include <pxr/base/gf/vec2f.h>
#include <pxr/base/gf/vec3f.h>
#include <pxr/base/gf/vec4f.h>
#include <pxr/base/tf/diagnostic.h>

#include <mutex>
#include <optional>
#include <set>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// In OpenUSD 24.11 outputs of three floats are shown with a fourth of 1: its HdxAovInputTask reads
/// buffers of Float32Vec3 after it has freed its copy. Hosts may bind such buffers all the same.
HdAovDescriptor ThreeFloats(float clearValue) {
#if PXR_VERSION < 2502
    return {HdFormatFloat32Vec4, false, VtValue(GfVec4f(clearValue, clearValue, clearValue, 1.0F))};
#else
    return {HdFormatFloat32Vec3, false, VtValue(GfVec3f(clearValue))};
#endif
}

bool BeginsWith(const std::string& text, const std::string& prefix) {
    return text.compare(0, prefix.size(), prefix) == 0;
}

/// An entry of a binding's settings, a string or a token; empty: there is none.
std::string TextOf(const HdAovSettingsMap& settings, const char* name) {
    const auto found = settings.find(TfToken(name));
    if (found == settings.end()) {
        return {};
    }
    return found->second.IsHolding<TfToken>() ? found->second.UncheckedGet<TfToken>().GetString()
                                              : found->second.GetWithDefault(std::string());
}

/// Whether light path expressions can be read; else there is a warning, the first time.
bool IsReadable(const std::string& layer) {
    try {
        hds::CheckAovs({layer});
        return true;
    } catch (const hds::Error& error) {
        static std::mutex mutex;
        static std::set<std::string> warned;
        const std::lock_guard<std::mutex> lock(mutex);
        if (warned.insert(layer).second) {
            TF_WARN("%s; left out", error.what());
        }
        return false;
    }
}

} // namespace

std::string HdStreamAovName(const HdRenderPassAovBinding& binding) {
    const std::string own = HdStreamAovName(binding.aovName);
    const std::string source = TextOf(binding.aovSettings, "sourceName");
    const std::string type = TextOf(binding.aovSettings, "sourceType");
    // What is neither ("raw", "intrinsic") is known by its name.
    if (!source.empty() && (type == "lpe" || type == "primvar")) {
        const std::string prefix = type == "lpe" ? hds::kLightPathPrefix : hds::kPrimvarAovPrefix;
        return BeginsWith(source, prefix) ? source : prefix + source;
    }
    const std::string known = hds::AovOfSource(source);
    return hds::HasAov(own) || known.empty() ? own : known;
}

std::string HdStreamAovName(const TfToken& name) {
    static const std::string kPrefix = "primvars_";
    const std::string& text = name.GetString();
    return text.compare(0, kPrefix.size(), kPrefix) == 0 ? "primvars:" + text.substr(kPrefix.size())
                                                         : text;
}

HdAovDescriptor HdStreamAovDescriptor(const TfToken& name) {
    const std::string layer = HdStreamAovName(name);
    const HdParsedAovToken parsed{TfToken(layer)};
    if (parsed.isPrimvar) {
        return ThreeFloats(0.0F);
    }
    if (BeginsWith(layer, hds::kLightPathPrefix) || BeginsWith(layer, hds::kLightGroupPrefix)) {
        return IsReadable(layer) ? ThreeFloats(0.0F) : HdAovDescriptor();
    }
    if (BeginsWith(layer, hds::kVariancePrefix)) {
        return hds::HasAov(layer) && IsReadable(layer)
                   ? HdAovDescriptor{HdFormatFloat32, false, VtValue(0.0F)}
                   : HdAovDescriptor();
    }
    const hds::AovInfo* info = hds::FindAov(layer);
    const std::optional<hds::MatteAov> matte = hds::ParseMatteAov(layer);
    if (!info || (matte && !matte->layer)) { // a Cryptomatte is several buffers: ask for its layers
        return {};
    }
    if (info->isInteger) {
        return {HdFormatInt32, false, VtValue(static_cast<int>(info->clearId))};
    }
    switch (info->NumChannels()) {
    case 1:
        return {HdFormatFloat32, false, VtValue(info->clearValue)};
    case 2:
        return {HdFormatFloat32Vec2, false, VtValue(GfVec2f(info->clearValue))};
    case 3:
        return ThreeFloats(info->clearValue);
    case 4:
        return {HdFormatFloat32Vec4, false, VtValue(GfVec4f(info->clearValue))};
    default:
        return {};
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
