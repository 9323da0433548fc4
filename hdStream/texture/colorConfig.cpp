// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/colorConfig.h"

#include "hdStream/base/error.h"
#include "hdStream/texture/oneLine.h"

#include <cstdlib>
#include <mutex>
#include <string>
#include <vector>

namespace OCIO = OCIO_NAMESPACE;

namespace hds {

namespace {

/// XYZ (D65) to linear Rec.709, the inverse of IEC 61966-2-1's matrix from its primaries.
constexpr double kRec709FromXyzD65[16] = {3.2409699419045226,
                                          -1.5373831775700940,
                                          -0.4986107602930034,
                                          0, //
                                          -0.9692436362808796,
                                          1.8759675015077202,
                                          0.0415550574071756,
                                          0, //
                                          0.0556300796969937,
                                          -0.2039769588889766,
                                          1.0569715142428786,
                                          0, //
                                          0,
                                          0,
                                          0,
                                          1};

OCIO::ColorSpaceRcPtr MakeSpace(const char* name, const std::vector<const char*>& aliases,
                                const char* description) {
    OCIO::ColorSpaceRcPtr space = OCIO::ColorSpace::Create();
    space->setName(name);
    for (const char* alias : aliases) {
        space->addAlias(alias);
    }
    space->setDescription(description);
    space->setBitDepth(OCIO::BIT_DEPTH_F32);
    return space;
}

/// A linear space of ACES primaries (D60), adapted to D65 by OpenColorIO's own Bradford matrix.
void AddAcesSpace(const OCIO::ConfigRcPtr& config, const char* name,
                  const std::vector<const char*>& aliases, const char* toXyzStyle) {
    OCIO::ColorSpaceRcPtr space = MakeSpace(name, aliases, "Scene linear, ACES primaries");
    OCIO::BuiltinTransformRcPtr toXyz = OCIO::BuiltinTransform::Create();
    toXyz->setStyle(toXyzStyle);
    OCIO::MatrixTransformRcPtr fromXyz = OCIO::MatrixTransform::Create();
    fromXyz->setMatrix(kRec709FromXyzD65);
    OCIO::GroupTransformRcPtr group = OCIO::GroupTransform::Create();
    group->appendTransform(toXyz);
    group->appendTransform(fromXyz);
    space->setTransform(group, OCIO::COLORSPACE_DIR_TO_REFERENCE);
    config->addColorSpace(space);
}

/// A space with Rec.709 primaries and a power law, linear near black when `offset` is not 0.
void AddPowerSpace(const OCIO::ConfigRcPtr& config, const char* name,
                   const std::vector<const char*>& aliases, double gamma, double offset) {
    OCIO::ColorSpaceRcPtr space = MakeSpace(name, aliases, "Rec.709 primaries, power law");
    OCIO::ExponentWithLinearTransformRcPtr power = OCIO::ExponentWithLinearTransform::Create();
    power->setGamma({gamma, gamma, gamma, 1.0});
    power->setOffset({offset, offset, offset, 0.0});
    power->setNegativeStyle(OCIO::NEGATIVE_MIRROR);
    space->setTransform(power, OCIO::COLORSPACE_DIR_TO_REFERENCE);
    config->addColorSpace(space);
}

/// Names are those of OpenUSD's UsdColorSpace and of the ACES configurations.
OCIO::ConstConfigRcPtr MakeBuiltInConfig() {
    OCIO::ConfigRcPtr config = OCIO::Config::Create();
    config->setVersion(2, 1);
    config->addColorSpace(
        MakeSpace("lin_rec709", {"lin_rec709_scene", "lin_srgb", "linear", "Linear Rec.709 (sRGB)"},
                  "Scene linear, Rec.709 primaries, D65: the working space"));
    AddPowerSpace(config, "srgb_texture",
                  {"srgb_rec709_scene", "srgb_rec709_display", "sRGB", "sRGB - Texture"}, 2.4,
                  0.055);
    AddPowerSpace(config, "g22_rec709", {"g22_rec709_scene", "Gamma 2.2 Rec.709 - Texture"}, 2.2,
                  0.0);
    AddPowerSpace(config, "g18_rec709", {"g18_rec709_scene", "Gamma 1.8 Rec.709 - Texture"}, 1.8,
                  0.0);
    AddAcesSpace(config, "ACEScg", {"lin_ap1", "lin_ap1_scene"},
                 "UTILITY - ACES-AP1_to_CIE-XYZ-D65_BFD");
    AddAcesSpace(config, "ACES2065-1", {"lin_ap0", "lin_ap0_scene"},
                 "UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD");
    OCIO::ColorSpaceRcPtr raw = MakeSpace("raw", {"data", "Utility - Raw"}, "Not a colour");
    raw->setIsData(true);
    config->addColorSpace(raw);
    config->setRole(OCIO::ROLE_SCENE_LINEAR, "lin_rec709");
    config->setRole(OCIO::ROLE_DEFAULT, "raw");
    config->addDisplayView("sRGB", "Standard", "srgb_texture", "");
    config->setActiveDisplays("sRGB");
    config->setActiveViews("Standard");
    config->validate();
    return config;
}

std::string EnvironmentConfig() {
    const char* value = std::getenv("OCIO");
    return value ? value : "";
}

} // namespace

bool HasUserColorConfig() {
    return !EnvironmentConfig().empty();
}

std::string ColorConfigIdentity() {
    return ColorConfig()->getCacheID();
}

OCIO::ConstConfigRcPtr ColorConfig() {
    static std::mutex mutex;
    static std::string loadedName;
    static OCIO::ConstConfigRcPtr loaded;
    const std::string name = EnvironmentConfig();
    const std::lock_guard<std::mutex> lock(mutex);
    if (loaded && loadedName == name) {
        return loaded;
    }
    try {
        loaded = name.empty() ? MakeBuiltInConfig() : OCIO::Config::CreateFromFile(name.c_str());
    } catch (const std::exception& failure) {
        throw Error("OCIO: cannot read the colour configuration '" + name +
                    "': " + OneLine(failure.what()));
    }
    loadedName = name;
    return loaded;
}

} // namespace hds
