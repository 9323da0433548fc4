// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/lightParameters.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/assets.h"
#include "hdStream/hydra/materialParameters.h"
#include "hdStream/hydra/renderParam.h"
#include "hdStream/hydra/scenePaths.h"

#include <pxr/base/gf/math.h>
#include <pxr/base/gf/vec3f.h>
#include <pxr/imaging/hd/collectionsSchema.h>
#include <pxr/imaging/hd/light.h>
#include <pxr/imaging/hd/lightSchema.h>
#include <pxr/imaging/hd/material.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/timeSampleArray.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/usd/sdf/assetPath.h>
#include <pxr/usd/sdf/pathExpression.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <type_traits>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr float kDistantIntensity = 50000.0F; ///< UsdLuxDistantLight's fallback; of others: 1
/// Of inputs while the shutter is open, where they change: as the other front end has them.
constexpr int kInputSteps = 8;

/// Reads parameters of one light; a missing one leaves the value as it is.
class Reader {
public:
    Reader(HdSceneDelegate* delegate, const SdfPath& id) : _delegate(delegate), _id(id) {}

    VtValue Get(const TfToken& name) const {
        return HdStreamGetLightParameter(_delegate, _id, name);
    }

    template <typename Type>
    void Read(const TfToken& name, Type* value) const {
        const VtValue found = Get(name).Cast<Type>();
        if (!found.IsEmpty()) {
            *value = found.UncheckedGet<Type>();
        }
    }

private:
    HdSceneDelegate* _delegate;
    const SdfPath& _id;
};

/// Reads the members whose parameter has their name, behind a prefix.
template <typename Struct>
void ReadFields(const Reader& reader, const std::string& prefix, Struct* result) {
    hds::ForEachField<Struct>([&](const auto& field) {
        auto& value = result->*field.member;
        using Member = std::decay_t<decltype(value)>;
        const TfToken name(prefix + field.name);
        if constexpr (std::is_arithmetic_v<Member>) {
            reader.Read(name, &value);
        } else if constexpr (std::is_same_v<Member, std::array<float, 3>>) {
            GfVec3f color(value[0], value[1], value[2]);
            reader.Read(name, &color);
            value = {color[0], color[1], color[2]};
        }
    });
}

/// Which inputs of a light the scene says, and their colour spaces by metadata: UsdImaging has both
/// as parameters of the light's network, as of a material's, while a parameter of a light has
/// UsdLux's fallback where nothing is said.
class AuthoredInputs {
public:
    AuthoredInputs(HdSceneDelegate* delegate, const SdfPath& id)
        : _resource(delegate->GetMaterialResource(id)) {
        if (_resource.IsHolding<HdMaterialNetworkMap>()) {
            const auto& networks = _resource.UncheckedGet<HdMaterialNetworkMap>().map;
            const auto found = networks.find(HdMaterialTerminalTokens->light);
            if (found != networks.end() && !found->second.nodes.empty()) {
                _parameters = &found->second.nodes.back().parameters; // the light itself
            }
        }
    }

    /// False also where the light has no network.
    bool Has(const TfToken& input) const {
        return _parameters && _parameters->find(input) != _parameters->end();
    }

    /// Empty: none is said.
    std::string SpaceOf(const TfToken& input) const {
        const TfToken name("colorSpace:" + input.GetString());
        const auto found = _parameters ? _parameters->find(name) : Parameters::const_iterator();
        if (!_parameters || found == _parameters->end()) {
            return {};
        }
        const VtValue& space = found->second;
        return space.IsHolding<TfToken>() ? space.UncheckedGet<TfToken>().GetString()
                                          : space.GetWithDefault(std::string());
    }

private:
    using Parameters = std::map<TfToken, VtValue>;

    VtValue _resource;
    const Parameters* _parameters = nullptr;
};

void ReadTexture(const Reader& reader, const AuthoredInputs& inputs, hds::LightDescription* light) {
    TfToken format(light->textureFormat);
    reader.Read(HdLightTokens->textureFormat, &format);
    light->textureFormat = format.GetString();
    SdfAssetPath file;
    reader.Read(HdLightTokens->textureFile, &file);
    if (!file.GetAssetPath().empty()) {
        light->textureFile = HdStreamAssetReference(file);
        light->textureFile.colorSpace = inputs.SpaceOf(HdLightTokens->textureFile);
    }
}

hds::LightShaping ReadShaping(const Reader& reader) {
    hds::LightShaping shaping;
    ReadFields(reader, "shaping:", &shaping);
    reader.Read(HdLightTokens->shapingConeAngle, &shaping.coneAngle);
    reader.Read(HdLightTokens->shapingConeSoftness, &shaping.coneSoftness);
    SdfAssetPath file;
    reader.Read(HdLightTokens->shapingIesFile, &file);
    if (!file.GetAssetPath().empty()) {
        shaping.iesFile = HdStreamAssetReference(file);
    }
    reader.Read(HdLightTokens->shapingIesAngleScale, &shaping.iesAngleScale);
    reader.Read(HdLightTokens->shapingIesNormalize, &shaping.iesNormalize);
    return shaping;
}

/// The group that light path expressions know a light by: of strings and tokens.
std::string ReadGroup(const Reader& reader) {
    for (const char* name : hds::kLightGroupAttributes) {
        const VtValue value = reader.Get(TfToken(name));
        const std::string group = value.IsHolding<TfToken>()
                                      ? value.UncheckedGet<TfToken>().GetString()
                                      : value.GetWithDefault(std::string());
        if (!group.empty()) {
            return group;
        }
    }
    return {};
}

/// Whether a gprim, or a volume, says that it is a light.
bool IsLight(const Reader& reader) {
    bool isLight = false;
    reader.Read(HdTokens->isLight, &isLight);
    return isLight;
}

/// Whether a light's collection is not the one that holds everything.
bool IsPartial(HdSceneDelegate* delegate, const SdfPath& id, const TfToken& collection) {
    const Reader reader(delegate, id);
    const std::string prefix = "collection:" + collection.GetString();
    bool includesRoot = true;
    reader.Read(TfToken(prefix + ":includeRoot"), &includesRoot);
    SdfPathExpression expression;
    reader.Read(TfToken(prefix + ":membershipExpression"), &expression);
    if (!includesRoot || !expression.IsEmpty()) {
        return true;
    }
    // Legacy scene delegates say no more; scene indices have collections as expressions.
    const HdSceneIndexPrim prim = delegate->GetRenderIndex().GetTerminalSceneIndex()->GetPrim(id);
    const HdPathExpressionDataSourceHandle source =
        HdCollectionsSchema::GetFromParent(prim.dataSource)
            .GetCollection(collection)
            .GetMembershipExpression();
    static const SdfPathExpression allButProperties("~//*.*"); // what includeRoot becomes
    expression = source ? source->GetTypedValue(0.0F) : SdfPathExpression::Everything();
    return expression != SdfPathExpression::Everything() && expression != allButProperties;
}

/// Legacy scene delegates make no network of shaders that are not registered, but they tell the
/// value of an attribute by its name. What the core does not know remains unsaid.
void ReadFilterByNames(HdSceneDelegate* delegate, const SdfPath& path, hds::MaterialNode* node) {
    for (const char* name : {"ri:lightFilter:shaderId", "lightFilter:shaderId", "info:id"}) {
        const VtValue value = delegate->GetLightParamValue(path, TfToken(name));
        const std::string id = value.IsHolding<TfToken>()
                                   ? value.UncheckedGet<TfToken>().GetString()
                                   : value.GetWithDefault(std::string());
        if (node->identifier.empty()) {
            node->identifier = id;
        }
    }
    for (const std::string& name : hds::LightFilterInputs()) {
        const VtValue value = delegate->GetLightParamValue(path, TfToken("inputs:" + name));
        if (auto parameter = value.IsEmpty() ? std::nullopt : HdStreamParameterFrom(value)) {
            node->parameters[name] = std::move(*parameter);
        }
    }
}

/// An input of a light that changes while the shutter is open, at a time of it.
using InputAt = std::function<VtValue(float time)>;

/// By member of a sample.
std::map<std::string, InputAt> MovingInputsOfScene(const HdRenderIndex& index, const SdfPath& id,
                                                   const hds::Shutter& shutter) {
    std::map<std::string, InputAt> inputs;
    const HdSceneIndexBaseRefPtr scene = index.GetTerminalSceneIndex();
    const HdContainerDataSourceHandle light =
        scene ? HdLightSchema::GetFromParent(scene->GetPrim(id).dataSource).GetContainer()
              : nullptr;
    if (!light) {
        return inputs;
    }
    hds::ForEachField<hds::LightSample>([&](const auto& field) {
        for (const std::string prefix : {"", "inputs:"}) {
            const auto source = HdSampledDataSource::Cast(light->Get(TfToken(prefix + field.name)));
            if (!source) {
                continue;
            }
            std::vector<HdSampledDataSource::Time> times;
            if (source->GetContributingSampleTimesForInterval(
                    static_cast<float>(shutter.open), static_cast<float>(shutter.close), &times)) {
                inputs[field.name] = [source](float time) { return source->GetValue(time); };
            }
            break; // as of the frame
        }
    });
    return inputs;
}

/// Between two samples, with the arithmetic of a stage, so that the bits are those of `hdstream
/// record`. As the first where they are of no type that inputs have.
VtValue Between(const VtValue& a, const VtValue& b, double alpha) {
    if (a.IsHolding<float>() && b.IsHolding<float>()) {
        return VtValue(GfLerp(alpha, a.UncheckedGet<float>(), b.UncheckedGet<float>()));
    }
    if (a.IsHolding<GfVec3f>() && b.IsHolding<GfVec3f>()) {
        return VtValue(GfLerp(alpha, a.UncheckedGet<GfVec3f>(), b.UncheckedGet<GfVec3f>()));
    }
    return a;
}

/// The same of a legacy scene delegate. UsdImaging's knows the samples of attributes as those of
/// primvars: the ones in its shutter's interval, and one beyond each end.
std::map<std::string, InputAt> MovingInputsOfDelegate(HdSceneDelegate* delegate, const SdfPath& id,
                                                      const hds::Shutter& shutter) {
    std::map<std::string, InputAt> inputs;
    hds::ForEachField<hds::LightSample>([&](const auto& field) {
        HdTimeSampleArray<VtValue, 4> samples;
        delegate->SamplePrimvar(id, TfToken(std::string("inputs:") + field.name),
                                static_cast<float>(shutter.open), static_cast<float>(shutter.close),
                                &samples);
        if (samples.count < 2) {
            return;
        }
        inputs[field.name] = [samples](float time) {
            const auto begin = samples.times.begin();
            const auto end = begin + static_cast<std::ptrdiff_t>(samples.count);
            const auto next = static_cast<std::size_t>(std::upper_bound(begin, end, time) - begin);
            if (next == 0 || next == samples.count) {
                return samples.values[std::min(next, samples.count - 1)]; // held
            }
            const double from = samples.times[next - 1];
            const double to = samples.times[next];
            return Between(samples.values[next - 1], samples.values[next],
                           (time - from) / (to - from));
        };
    });
    return inputs;
}

} // namespace

const TfToken kHdStreamLightSeenByCamera("hdstream:visibility:camera");

VtValue HdStreamGetLightParameter(HdSceneDelegate* delegate, const SdfPath& id,
                                  const TfToken& name) {
    VtValue value = delegate->GetLightParamValue(id, name);
    return value.IsEmpty() ? delegate->GetLightParamValue(id, TfToken("inputs:" + name.GetString()))
                           : value;
}

std::optional<hds::LightType> HdStreamFindLightType(const TfToken& typeId) {
    static const std::pair<TfToken, hds::LightType> types[] = {
        {HdPrimTypeTokens->simpleLight, hds::LightType::Distant},
        {HdPrimTypeTokens->distantLight, hds::LightType::Distant},
        {HdPrimTypeTokens->sphereLight, hds::LightType::Sphere},
        {HdPrimTypeTokens->rectLight, hds::LightType::Rect},
        {HdPrimTypeTokens->diskLight, hds::LightType::Disk},
        {HdPrimTypeTokens->cylinderLight, hds::LightType::Cylinder},
        {HdPrimTypeTokens->domeLight, hds::LightType::Dome},
    };
    for (const auto& [name, type] : types) {
        if (name == typeId) {
            return type;
        }
    }
    return {};
}

std::vector<hds::LightSample> HdStreamSampleLight(HdSceneDelegate* delegate, const SdfPath& id,
                                                  const hds::LightDescription& light,
                                                  const hds::Shutter& shutter) {
    if (!shutter.IsOpen()) {
        return {};
    }
    HdSceneDelegate* legacy = HdStreamFindLegacyDelegate(delegate, id);
    const std::map<std::string, InputAt> inputs =
        legacy ? MovingInputsOfDelegate(legacy, id, shutter)
               : MovingInputsOfScene(delegate->GetRenderIndex(), id, shutter);
    std::vector<hds::LightSample> samples;
    for (int i = 0; !inputs.empty() && i <= kInputSteps; ++i) {
        hds::LightSample sample = hds::SampleOf(light);
        sample.time = shutter.open + double(i) / kInputSteps * (shutter.close - shutter.open);
        hds::ForEachField<hds::LightSample>([&](const auto& field) {
            const auto found = inputs.find(field.name);
            if (found == inputs.end()) {
                return;
            }
            const VtValue value = found->second(static_cast<float>(sample.time));
            auto& member = sample.*field.member;
            if constexpr (std::is_same_v<std::decay_t<decltype(member)>, float>) {
                member = VtValue::Cast<float>(value).GetWithDefault(member);
            } else if constexpr (std::is_same_v<std::decay_t<decltype(member)>,
                                                std::array<float, 3>>) {
                const GfVec3f color = VtValue::Cast<GfVec3f>(value).GetWithDefault(
                    GfVec3f(member[0], member[1], member[2]));
                member = {color[0], color[1], color[2]};
            }
        });
        samples.push_back(sample);
    }
    return samples;
}

bool HdStreamLeavesTemperatureOut(HdSceneDelegate* delegate, const SdfPath& id) {
    const AuthoredInputs inputs(delegate, id);
    return inputs.Has(HdLightTokens->enableColorTemperature) &&
           !inputs.Has(HdLightTokens->colorTemperature);
}

hds::LinkCategories HdStreamReadLinks(HdSceneDelegate* delegate, const SdfPath& id) {
    const auto linkOf = [&](const TfToken& name) {
        return HdStreamGetLightParameter(delegate, id, name).GetWithDefault(TfToken()).GetString();
    };
    return {linkOf(HdTokens->lightLink), linkOf(HdTokens->shadowLink)};
}

hds::LightDescription HdStreamReadLight(HdSceneDelegate* delegate, const SdfPath& id,
                                        const TfToken& typeId, hds::LightType type) {
    const Reader reader(delegate, id);
    hds::LightDescription light;
    light.type = type;
    if (typeId == HdPrimTypeTokens->distantLight) {
        light.intensity = kDistantIntensity;
    }
    ReadFields(reader, "", &light);
    light.visibleToCamera = true; // no input of the light says it, but a render pass may
    reader.Read(kHdStreamLightSeenByCamera, &light.visibleToCamera);
    light.group = ReadGroup(reader);
    const AuthoredInputs inputs(delegate, id);
    light.colorSpace = inputs.SpaceOf(HdLightTokens->color);
    ReadTexture(reader, inputs, &light);
    light.shaping = ReadShaping(reader);
    ReadFields(reader, "shadow:", &light.shadow);
    return light;
}

std::shared_ptr<const hds::MeshLight> HdStreamReadMeshLight(HdSceneDelegate* delegate,
                                                            const SdfPath& id) {
    const Reader reader(delegate, id);
    if (!IsLight(reader)) {
        return nullptr;
    }
    auto light = std::make_shared<hds::MeshLight>();
    light->links = HdStreamReadLinks(delegate, id);
    light->light = HdStreamReadLight(delegate, id, HdPrimTypeTokens->mesh, hds::LightType::Mesh);
    TfToken mode;
    reader.Read(HdTokens->materialSyncMode, &mode);
    light->materialSyncMode = mode == "materialGlowTintsLight"
                                  ? hds::MaterialSyncMode::GlowTintsLight
                              : mode == "independent" ? hds::MaterialSyncMode::Independent
                                                      : hds::MaterialSyncMode::NoMaterialResponse;
    return light;
}

void HdStreamWarnOfNoLight(HdSceneDelegate* delegate, const SdfPath& id,
                           const std::string& scenePath, HdStreamRenderParam* param) {
    if (IsLight(Reader(delegate, id))) {
        param->Warn(SdfPath(scenePath), "LightAPI makes lights of what has faces; no light");
    }
}

std::set<std::string> HdStreamUnsupportedLightFeatures(HdSceneDelegate* delegate,
                                                       const SdfPath& id) {
    const Reader reader(delegate, id);
    std::set<std::string> features;
    const bool isMesh = delegate->GetRenderIndex().GetRprim(id) != nullptr;
    for (const SdfPath& filter : HdStreamFiltersOf(delegate, id)) {
        if (isMesh) {
            features.insert("light filter " + filter.GetString());
        }
    }
    if (!reader.Get(HdTokens->portals).GetWithDefault(SdfPathVector()).empty()) {
        features.insert("portals");
    }
    return features;
}

SdfPathVector HdStreamFiltersOf(HdSceneDelegate* delegate, const SdfPath& id) {
    return Reader(delegate, id).Get(HdTokens->filters).GetWithDefault(SdfPathVector());
}

std::vector<hds::LightFilter> HdStreamReadFilters(HdSceneDelegate* delegate, const SdfPath& id,
                                                  std::vector<std::string>* problems) {
    std::vector<hds::LightFilter> filters;
    for (const SdfPath& path : HdStreamFiltersOf(delegate, id)) {
        // Prims whose type OpenUSD does not know come from nowhere.
        if (delegate->GetRenderIndex().GetSprim(HdPrimTypeTokens->lightFilter, path) == nullptr) {
            problems->push_back("light filter " + path.GetString() +
                                " is not handed over by Hydra; left out");
            continue;
        }
        const VtValue resource = delegate->GetMaterialResource(path);
        hds::LightFilter filter;
        filter.node.path = path.GetString();
        filter.worldFromFilter = HdStreamToGlm(delegate->GetTransform(path));
        if (resource.IsHolding<HdMaterialNetworkMap>()) {
            const hds::MaterialNetwork network = HdStreamMaterialNetworkFrom(
                path, path, resource.UncheckedGet<HdMaterialNetworkMap>());
            for (const hds::MaterialNode& node : network.nodes) {
                if (node.path == filter.node.path) {
                    filter.node = node;
                }
            }
        }
        if (filter.node.identifier.empty()) {
            ReadFilterByNames(delegate, path, &filter.node);
        }
        filters.push_back(std::move(filter));
    }
    return filters;
}

bool HdStreamHidesLinks(HdSceneDelegate* delegate, const SdfPath& id) {
    const hds::LinkCategories links = HdStreamReadLinks(delegate, id);
    return (links.lightLink.empty() && IsPartial(delegate, id, HdTokens->lightLink)) ||
           (links.shadowLink.empty() && IsPartial(delegate, id, HdTokens->shadowLink));
}

PXR_NAMESPACE_CLOSE_SCOPE
