// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/colorConfig.h"

#include "hdStream/base/error.h"
#include "hdStream/texture/colorConfigSources.h"
#include "hdStream/texture/colorConversion.h"
#include "hdStream/texture/oneLine.h"

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>
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

/// A power law, linear near black when `offset` is not 0.
OCIO::TransformRcPtr PowerOf(double gamma, double offset) {
    OCIO::ExponentWithLinearTransformRcPtr power = OCIO::ExponentWithLinearTransform::Create();
    power->setGamma({gamma, gamma, gamma, 1.0});
    power->setOffset({offset, offset, offset, 0.0});
    power->setNegativeStyle(OCIO::NEGATIVE_MIRROR);
    return power;
}

/// A space with Rec.709 primaries and a power law.
void AddPowerSpace(const OCIO::ConfigRcPtr& config, const char* name,
                   const std::vector<const char*>& aliases, double gamma, double offset) {
    OCIO::ColorSpaceRcPtr space = MakeSpace(name, aliases, "Rec.709 primaries, power law");
    space->setTransform(PowerOf(gamma, offset), OCIO::COLORSPACE_DIR_TO_REFERENCE);
    config->addColorSpace(space);
}

/// CIE xy of red, green, blue and white.
using Primaries = std::array<double, 8>;

constexpr Primaries kRec709 = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};
constexpr Primaries kRec2020 = {0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290};
constexpr Primaries kP3 = {0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.3127, 0.3290};
constexpr Primaries kAdobe = {0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.3290};
constexpr Primaries kAp0 = {0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.0770, 0.32168, 0.33767};
constexpr Primaries kAp1 = {0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767};

/// XYZ of a linear space of the white D65, scaled to a white of Y 1.
glm::dmat3 XyzFrom(const Primaries& xy) {
    const auto column = [&](std::size_t i) {
        return glm::dvec3(xy[i] / xy[i + 1], 1.0, (1.0 - xy[i] - xy[i + 1]) / xy[i + 1]);
    };
    const glm::dmat3 unscaled(column(0), column(2), column(4));
    const glm::dvec3 scales = glm::inverse(unscaled) * column(6);
    return {unscaled[0] * scales.x, unscaled[1] * scales.y, unscaled[2] * scales.z};
}

OCIO::TransformRcPtr MatrixOf(const glm::dmat3& matrix) {
    double rows[16] = {};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            rows[4 * i + k] = matrix[k][i];
        }
    }
    rows[15] = 1.0;
    OCIO::MatrixTransformRcPtr transform = OCIO::MatrixTransform::Create();
    transform->setMatrix(rows);
    return transform;
}

/// A space of other primaries, after a power law where there is one.
void AddWideSpace(const OCIO::ConfigRcPtr& config, const char* name,
                  const std::vector<const char*>& aliases, const OCIO::TransformRcPtr& power,
                  const OCIO::TransformRcPtr& toRec709) {
    OCIO::ColorSpaceRcPtr space = MakeSpace(name, aliases, "Other primaries than Rec.709");
    OCIO::GroupTransformRcPtr group = OCIO::GroupTransform::Create();
    if (power) {
        group->appendTransform(power);
    }
    group->appendTransform(toRec709);
    space->setTransform(group, OCIO::COLORSPACE_DIR_TO_REFERENCE);
    config->addColorSpace(space);
}

/// The spaces of OpenUSD's GfColorSpaceNames that are neither of Rec.709 nor ACES2065-1 or ACEScg.
void AddWideSpaces(const OCIO::ConfigRcPtr& config) {
    const glm::dmat3 rec709 = glm::inverse(XyzFrom(kRec709));
    const auto to709 = [&](const Primaries& xy) { return MatrixOf(rec709 * XyzFrom(xy)); };
    const OCIO::TransformRcPtr srgb = PowerOf(2.4, 0.055);
    const OCIO::TransformRcPtr gamma22 = PowerOf(2.2, 0.0);
    AddWideSpace(config, "lin_rec2020", {"lin_rec2020_scene", "Linear Rec.2020"}, nullptr,
                 to709(kRec2020));
    AddWideSpace(config, "lin_p3d65",
                 {"lin_p3d65_scene", "lin_displayp3", "lin_displayp3_scene", "Linear P3-D65"},
                 nullptr, to709(kP3));
    AddWideSpace(config, "lin_adobergb", {"lin_adobergb_scene", "Linear AdobeRGB"}, nullptr,
                 to709(kAdobe));
    AddWideSpace(config, "lin_ciexyzd65", {"lin_ciexyzd65_scene"}, nullptr, MatrixOf(rec709));
    AddWideSpace(config, "srgb_displayp3",
                 {"srgb_displayp3_scene", "srgb_p3d65", "srgb_p3d65_scene"}, srgb, to709(kP3));
    AddWideSpace(config, "g22_adobergb", {"g22_adobergb_scene"}, gamma22, to709(kAdobe));
    AddWideSpace(config, "adobergb", {}, PowerOf(563.0 / 256.0, 0.0), to709(kAdobe));
    OCIO::ColorSpaceTransformRcPtr ap1 = OCIO::ColorSpaceTransform::Create();
    ap1->setSrc("ACEScg");
    ap1->setDst("lin_rec709");
    AddWideSpace(config, "srgb_ap1", {"srgb_ap1_scene", "srgb_encoded_ap1_tx"}, srgb, ap1);
    AddWideSpace(config, "g22_ap1", {"g22_ap1_scene"}, gamma22, ap1);
}

/// Names are those of OpenUSD's GfColorSpaceNames, of MaterialX and of the ACES configurations.
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
    AddPowerSpace(config, "g24_rec709", {"g24_rec709_scene"}, 2.4, 0.0);
    AddPowerSpace(config, "g18_rec709", {"g18_rec709_scene", "Gamma 1.8 Rec.709 - Texture"}, 1.8,
                  0.0);
    AddAcesSpace(config, "ACEScg", {"lin_ap1", "lin_ap1_scene"},
                 "UTILITY - ACES-AP1_to_CIE-XYZ-D65_BFD");
    AddAcesSpace(config, "ACES2065-1", {"lin_ap0", "lin_ap0_scene"},
                 "UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD");
    AddWideSpaces(config);
    OCIO::ColorSpaceRcPtr raw =
        MakeSpace("raw", {"data", "identity", "unknown", "Utility - Raw"}, "Not a colour");
    raw->setIsData(true);
    config->addColorSpace(raw);
    config->setRole(OCIO::ROLE_SCENE_LINEAR, "lin_rec709");
    config->setRole(OCIO::ROLE_DEFAULT, "raw");
    config->setRole(OCIO::ROLE_INTERCHANGE_SCENE, "ACES2065-1");
    config->addDisplayView("sRGB", "Standard", "srgb_texture", "");
    config->setActiveDisplays("sRGB");
    config->setActiveViews("Standard");
    config->validate();
    return config;
}

/// Before what a space is made of.
constexpr const char* kDefined = "primaries:";

bool IsDefined(const std::string& space) {
    return space.compare(0, std::strlen(kDefined), kDefined) == 0;
}

/// XYZ of a linear space of its own white, scaled to Y 1; primaries may have no Y.
glm::dmat3 XyzOfDefined(const Primaries& xy) {
    const auto column = [&](std::size_t i) {
        return glm::dvec3(xy[i], xy[i + 1], 1.0 - xy[i] - xy[i + 1]);
    };
    const glm::dmat3 unscaled(column(0), column(2), column(4));
    const glm::dvec3 scales = glm::inverse(unscaled) * (column(6) / xy[7]);
    return {unscaled[0] * scales.x, unscaled[1] * scales.y, unscaled[2] * scales.z};
}

/// Our configuration with a space that a stage defines. As in OpenUSD its white is not adapted.
/// \throws Error where its numbers make no space
OCIO::ConstConfigRcPtr ConfigWith(const std::string& space) {
    std::istringstream words(space.substr(std::strlen(kDefined)));
    Primaries xy{};
    std::for_each(xy.begin(), xy.end(), [&](double& value) { words >> value; });
    double gamma = 0.0;
    double bias = 0.0;
    words >> gamma >> bias;
    const glm::dmat3 toRec709 = glm::inverse(XyzFrom(kRec709)) * XyzOfDefined(xy);
    const double sum = toRec709[0][0] + toRec709[1][1] + toRec709[2][2];
    if (!words || !std::isfinite(sum) || glm::determinant(toRec709) == 0.0 || !(gamma >= 1.0) ||
        gamma > 10.0 || !(bias >= 0.0) || bias > 0.9 || (bias > 0.0 && gamma == 1.0)) {
        throw Error("the colour space defined by " + space.substr(std::strlen(kDefined)) +
                    " cannot be computed with");
    }
    OCIO::ConfigRcPtr config = BuiltInColorConfig()->createEditableCopy();
    AddWideSpace(config, space.c_str(), {}, gamma == 1.0 ? nullptr : PowerOf(gamma, bias),
                 MatrixOf(toRec709));
    return config;
}

std::string EnvironmentConfig() {
    const char* value = std::getenv("OCIO");
    return value ? value : "";
}

struct LoadedConfig {
    std::string name; ///< empty: the built-in one
    OCIO::ConstConfigRcPtr config;
    std::string identity;
};

std::mutex loadedMutex;
std::shared_ptr<const LoadedConfig> lastLoaded;

/// The configuration in force.
std::shared_ptr<const LoadedConfig> Loaded() {
    const std::string name = EnvironmentConfig();
    const std::lock_guard<std::mutex> lock(loadedMutex);
    if (lastLoaded && lastLoaded->name == name) {
        return lastLoaded;
    }
    try {
        const OCIO::ConstConfigRcPtr config =
            name.empty() ? BuiltInColorConfig() : OCIO::Config::CreateFromFile(name.c_str());
        lastLoaded = std::make_shared<const LoadedConfig>(
            LoadedConfig{name, config, IdentityOf(SourcesOf(config, name))});
    } catch (const std::exception& failure) {
        throw Error("OCIO: cannot read the colour configuration '" + name +
                    "': " + OneLine(failure.what()));
    }
    return lastLoaded;
}

bool Knows(const OCIO::ConstConfigRcPtr& config, const std::string& space) {
    return config->getColorSpace(space.c_str()) != nullptr;
}

} // namespace

OCIO::ConstConfigRcPtr BuiltInColorConfig() {
    static const OCIO::ConstConfigRcPtr config = MakeBuiltInConfig();
    return config;
}

OCIO::ConstCPUProcessorRcPtr MakeColorProcessor(const std::string& from, const std::string& to) {
    const OCIO::ConstConfigRcPtr config = ColorConfig();
    const OCIO::ConstConfigRcPtr ours = BuiltInColorConfig();
    const auto configOf = [&](const std::string& space) {
        return IsDefined(space)                              ? ConfigWith(space)
               : Knows(config, space) || !Knows(ours, space) ? config
                                                             : ours;
    };
    const OCIO::ConstConfigRcPtr source = configOf(from);
    const bool isOurs = IsDefined(from) && configOf(to) == ours;
    const OCIO::ConstConfigRcPtr target = isOurs ? source : configOf(to);
    const OCIO::ConstProcessorRcPtr processor =
        source == target
            ? source->getProcessor(from.c_str(), to.c_str())
            : OCIO::Config::GetProcessorFromConfigs(source, from.c_str(), target, to.c_str());
    return processor->getOptimizedCPUProcessor(OCIO::OPTIMIZATION_LOSSLESS);
}

std::optional<std::array<float, 8>> ChromaticitiesOf(const std::string& space) {
    static const std::map<std::string, Primaries> kLinear = {
        {"lin_rec709", kRec709},   {"ACEScg", kAp1},   {"ACES2065-1", kAp0},
        {"lin_rec2020", kRec2020}, {"lin_p3d65", kP3}, {"lin_adobergb", kAdobe}};
    const OCIO::ConstColorSpaceRcPtr known = BuiltInColorConfig()->getColorSpace(space.c_str());
    const auto found = known ? kLinear.find(known->getName()) : kLinear.end();
    if (found == kLinear.end()) {
        return std::nullopt;
    }
    std::array<float, 8> xy{};
    std::transform(found->second.begin(), found->second.end(), xy.begin(),
                   [](double value) { return static_cast<float>(value); });
    return xy;
}

bool HasUserColorConfig() {
    return !EnvironmentConfig().empty();
}

OCIO::ConstConfigRcPtr ColorConfig() {
    return Loaded()->config;
}

std::string ColorConfigIdentity() {
    return Loaded()->identity;
}

ColorConfigSources FindColorConfigSources() {
    RefreshColorConfig();
    const std::shared_ptr<const LoadedConfig> loaded = Loaded();
    return SourcesOf(loaded->config, loaded->name);
}

void RefreshColorConfig() {
    const std::lock_guard<std::mutex> lock(loadedMutex);
    if (lastLoaded && !lastLoaded->name.empty() &&
        IdentityOf(SourcesOf(lastLoaded->config, lastLoaded->name)) != lastLoaded->identity) {
        lastLoaded.reset();
        OCIO::ClearAllCaches(); // it keeps tables by the names of their files
    }
}

} // namespace hds
