// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/lightParameters.h"

#include "hdStream/hydra/assets.h"

#include <pxr/base/gf/vec3f.h>
#include <pxr/imaging/hd/light.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/usd/sdf/assetPath.h>

#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr float kDistantIntensity = 50000.0F; ///< UsdLuxDistantLight's fallback; of others: 1

/// Reads parameters of one light; a missing one leaves the value as it is.
class Reader {
public:
    Reader(HdSceneDelegate* delegate, const SdfPath& id) : _delegate(delegate), _id(id) {}

    VtValue Get(const TfToken& name) const { return _delegate->GetLightParamValue(_id, name); }

    template <typename Type>
    void Read(const TfToken& name, Type* value) const {
        const VtValue found = Get(name).Cast<Type>();
        if (!found.IsEmpty()) {
            *value = found.UncheckedGet<Type>();
        }
    }

    /// True when the parameter has a value, and not that one.
    template <typename Type>
    bool Differs(const TfToken& name, const Type& idle) const {
        Type value = idle;
        Read(name, &value);
        return value != idle;
    }

private:
    HdSceneDelegate* _delegate;
    const SdfPath& _id;
};

void ReadShape(const Reader& reader, hds::LightDescription* light) {
    static const TfToken treatAsPoint("treatAsPoint");
    static const TfToken treatAsLine("treatAsLine");
    reader.Read(HdLightTokens->angle, &light->angle);
    reader.Read(HdLightTokens->radius, &light->radius);
    reader.Read(HdLightTokens->width, &light->width);
    reader.Read(HdLightTokens->height, &light->height);
    reader.Read(HdLightTokens->length, &light->length);
    reader.Read(treatAsPoint, &light->treatAsPoint);
    reader.Read(treatAsLine, &light->treatAsLine);
}

void ReadTexture(const Reader& reader, hds::LightDescription* light) {
    TfToken format(light->textureFormat);
    reader.Read(HdLightTokens->textureFormat, &format);
    light->textureFormat = format.GetString();
    SdfAssetPath file;
    reader.Read(HdLightTokens->textureFile, &file);
    if (!file.GetAssetPath().empty()) {
        light->textureFile = HdStreamAssetReference(file);
    }
}

} // namespace

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

hds::LightDescription HdStreamReadLight(HdSceneDelegate* delegate, const SdfPath& id,
                                        const TfToken& typeId, hds::LightType type) {
    const Reader reader(delegate, id);
    hds::LightDescription light;
    light.type = type;
    if (typeId == HdPrimTypeTokens->distantLight) {
        light.intensity = kDistantIntensity;
    }
    reader.Read(HdLightTokens->intensity, &light.intensity);
    reader.Read(HdLightTokens->exposure, &light.exposure);
    reader.Read(HdLightTokens->diffuse, &light.diffuse);
    reader.Read(HdLightTokens->specular, &light.specular);
    reader.Read(HdLightTokens->normalize, &light.normalize);
    GfVec3f color(light.color[0], light.color[1], light.color[2]);
    reader.Read(HdLightTokens->color, &color);
    light.color = {color[0], color[1], color[2]};
    reader.Read(HdLightTokens->enableColorTemperature, &light.enableColorTemperature);
    reader.Read(HdLightTokens->colorTemperature, &light.colorTemperature);
    ReadShape(reader, &light);
    ReadTexture(reader, &light);
    return light;
}

std::set<std::string> HdStreamUnsupportedLightFeatures(HdSceneDelegate* delegate, const SdfPath& id,
                                                       hds::LightType type) {
    const Reader reader(delegate, id);
    std::set<std::string> features;
    // A cone of 90 degrees is all of a flat light, and one of 180 of any other.
    const bool isFlat = type == hds::LightType::Rect || type == hds::LightType::Disk;
    const float idleAngle = isFlat ? 90.0F : 180.0F;
    float angle = idleAngle;
    reader.Read(HdLightTokens->shapingConeAngle, &angle);
    SdfAssetPath profile;
    reader.Read(HdLightTokens->shapingIesFile, &profile);
    if (angle < idleAngle || !profile.GetAssetPath().empty() ||
        reader.Differs(HdLightTokens->shapingFocus, 0.0F)) {
        features.insert("shaping");
    }
    if (reader.Differs(HdLightTokens->shadowEnable, true) ||
        reader.Differs(HdLightTokens->shadowColor, GfVec3f(0.0F)) ||
        reader.Differs(HdLightTokens->shadowDistance, -1.0F)) {
        features.insert("shadow");
    }
    if (!reader.Get(HdTokens->filters).GetWithDefault(SdfPathVector()).empty()) {
        features.insert("light filters");
    }
    if (!reader.Get(HdTokens->portals).GetWithDefault(SdfPathVector()).empty()) {
        features.insert("portals");
    }
    if (reader.Differs(HdTokens->lightLink, TfToken()) ||
        reader.Differs(HdTokens->shadowLink, TfToken())) {
        features.insert("light linking");
    }
    return features;
}

PXR_NAMESPACE_CLOSE_SCOPE
