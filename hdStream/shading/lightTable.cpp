// SPDX-License-Identifier: Apache-2.0
// Builds the tables of kernels/light from UsdLux lights and emissive meshes.
#include "hdStream/shading/lightTableBuilder.h"

#include "hdStream/shading/lightPlacement.h"
#include "hdStream/shading/lightShaping.h"
#include "hdStream/shading/lightTree.h"
#include "hdStream/shading/lightUnits.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace hds {

namespace {

/// What is brighter cannot be summed over lights, areas and bounces in floats.
constexpr double kMaxRadiance = 1e30;
/// Of a light: sums over lights stay finite. Only ratios matter.
constexpr double kMaxStrength = 1e28;
std::uint32_t TypeOf(LightType type) {
    switch (type) {
    case LightType::Distant:
        return HDS_LIGHT_DISTANT;
    case LightType::Sphere:
        return HDS_LIGHT_SPHERE;
    case LightType::Rect:
        return HDS_LIGHT_RECT;
    case LightType::Disk:
        return HDS_LIGHT_DISK;
    case LightType::Cylinder:
        return HDS_LIGHT_CYLINDER;
    case LightType::Mesh:
        return HDS_LIGHT_MESH;
    case LightType::Dome:
        break;
    }
    return HDS_LIGHT_DOME;
}

} // namespace

bool IsShadowPlain(const LightShadow& shadow) {
    return shadow.enable && shadow.distance < 0.0F &&
           shadow.color == std::array<float, 3>{0.0F, 0.0F, 0.0F};
}

bool IsUsableRadiance(const glm::dvec3& radiance) {
    return glm::all(glm::lessThanEqual(radiance, glm::dvec3(kMaxRadiance))); // false for NaN
}

double PowerOf(const LightDescription& light, bool isPoint, const glm::dvec3& radiance,
               double area) {
    if (light.type == LightType::Distant) {
        return Luminance(radiance) * DistantIrradiance(DistantHalfAngle(light));
    }
    if (light.type == LightType::Dome) {
        return kLightPi * Luminance(radiance);
    }
    return isPoint ? Luminance(radiance) * 4.0 * kLightPi : Luminance(radiance) * kLightPi * area;
}

shared::HdsLight PlainLight() {
    shared::HdsLight light{};
    light.treePlace = HDS_NONE;
    light.shapingBase = HDS_NONE;
    light.controlBase = HDS_NONE;
    light.lightLink = HDS_NONE;
    light.shadowLink = HDS_NONE;
    return light;
}

/// A bit for each link set, of each category.
void LightTableBuilder::AddLinks() {
    for (const std::vector<bool>& category : _input.links.categories) {
        _linkBases.push_back(std::uint32_t(_table.cdf.size()));
        std::vector<std::uint32_t> words((_input.links.numSets + 31) / 32);
        for (std::size_t set = 0; set < category.size(); ++set) {
            words[set / 32] |= category[set] ? 1U << (set % 32) : 0U;
        }
        for (const std::uint32_t word : words) {
            _table.cdf.push_back(shared::FloatOfBits(word));
        }
    }
}

/// \param[in,out] power grows by the peak of the shaping, against which kernels estimate it
void LightTableBuilder::AddShaping(const PlacedLight& placed, shared::HdsLight* light,
                                   double* power) {
    LightDescription description = placed.light;
    float& coneAngle = description.shaping.coneAngle;
    if (std::isnan(coneAngle)) {
        _warnings.Add(placed.name, "light's shaping:cone:angle is not a number; it has no cone");
        coneAngle = LightShaping().coneAngle;
    }
    if (IsUnshaped(description)) {
        return;
    }
    const AssetReference& file = description.shaping.iesFile;
    const std::shared_ptr<const IesProfile> profile =
        file.authoredPath.empty() || !_input.loadProfile ? nullptr : _input.loadProfile(file);
    const shared::HdsLightShaping shaping =
        AppendShaping(description, placed.worldFromLight, profile.get(), &_table.cdf);
    light->shapingBase = std::uint32_t(_table.cdf.size() - sizeof(shaping) / sizeof(_table.cdf[0]));
    *power *= shaping.peak;
    _table.hasShaping = true;
}

/// Where a light is while the shutter is open.
void LightTableBuilder::AddKeys(const std::vector<LightKey>& lightKeys,
                                shared::HdsLightControls* controls) {
    if (lightKeys.empty()) {
        return;
    }
    std::vector<shared::HdsLightKey> keys;
    for (const LightKey& key : lightKeys) {
        shared::HdsLightKey row{};
        for (int i = 0; i < 4; ++i) {
            row.turn[i] = float(key.turn[i]);
        }
        for (int i = 0; i < 3; ++i) {
            row.offset[i] = float(key.offset[i]);
        }
        keys.push_back(row);
    }
    controls->motionBase = std::uint32_t(_table.cdf.size());
    controls->motionSegments = std::uint32_t(keys.size() - 1);
    const std::size_t bytes = keys.size() * sizeof(keys[0]);
    _table.cdf.resize(_table.cdf.size() + bytes / sizeof(_table.cdf[0]));
    std::memcpy(&_table.cdf[controls->motionBase], keys.data(), bytes);
    _table.hasMotion = true;
}

void LightTableBuilder::AddFilters(const PlacedLight& placed, shared::HdsLightControls* controls,
                                   double* power) {
    if (placed.filters.empty()) {
        return;
    }
    double peak = 1.0;
    controls->numFilters =
        AppendFilters(placed.filters, _input.loadFilterImage, _warnings, &_table.cdf, &peak);
    controls->filterBase =
        std::uint32_t(_table.cdf.size() - controls->numFilters * sizeof(shared::HdsLightFilter) /
                                              sizeof(_table.cdf[0]));
    *power *= peak;
    _table.hasFilters = _table.hasFilters || controls->numFilters > 0;
}

void LightTableBuilder::AppendControls(const shared::HdsLightControls& controls,
                                       shared::HdsLight* light) {
    light->controlBase = std::uint32_t(_table.cdf.size());
    _table.cdf.resize(_table.cdf.size() + sizeof(controls) / sizeof(_table.cdf[0]));
    std::memcpy(&_table.cdf[light->controlBase], &controls, sizeof(controls));
    _table.hasControls = true;
}

/// \param basePower that of PowerOf. \param[in,out] power grows by the peak of the filters
void LightTableBuilder::AddControls(const PlacedLight& placed, double basePower,
                                    shared::HdsLight* light, double* power) {
    const LightDescription& description = placed.light;
    light->lightLink = LinkOf(placed.lightLink);
    light->shadowLink = LinkOf(placed.shadowLink);
    if (IsSampledAlone(placed)) {
        light->flags |= HDS_LIGHT_SAMPLED;
    }
    shared::HdsLightControls controls = LightControls(description);
    AddFilters(placed, &controls, power);
    if (!IsShadowPlain(description.shadow) || description.diffuse != 1.0F ||
        description.specular != 1.0F || !placed.keys.empty() || !placed.cells.empty() ||
        controls.numFilters > 0) {
        AddKeys(placed.keys, &controls);
        if (!placed.cells.empty()) {
            AddCells(placed, *power / basePower, light, power, &controls);
        }
        AppendControls(controls, light);
    }
    _table.hasControls =
        _table.hasControls || light->lightLink != HDS_NONE || light->shadowLink != HDS_NONE;
}

/// The portals of a dome, as rects of radiance 1, and the sums over its image. To be called after
/// AddImage.
void LightTableBuilder::AddPortals(const PlacedLight& placed, shared::HdsLight* light) {
    std::vector<shared::HdsLight> portals;
    for (const LightPortal& portal : placed.portals) {
        LightDescription description;
        description.type = LightType::Rect;
        description.width = portal.width;
        description.height = portal.height;
        shared::HdsLight rect = PlainLight();
        rect.type = HDS_LIGHT_RECT;
        if (PlaceLight(description, portal.worldFromPortal, &rect)) {
            rect.strength = 0.25F * rect.area;
            portals.push_back(rect);
        } else {
            _warnings.Add(placed.name, "a portal has a singular transform or no size; left out");
        }
    }
    if (!portals.empty()) {
        const auto sumsBase = std::uint32_t(_table.cdf.size());
        if ((light->flags & HDS_LIGHT_TEXTURED) != 0U) {
            const std::vector<std::uint32_t> sums =
                SumCells(&_table.cdf[light->cdfBase], light->dataSize[0], light->dataSize[1]);
            _table.cdf.resize(_table.cdf.size() + sums.size());
            std::memcpy(&_table.cdf[sumsBase], sums.data(), sums.size() * sizeof(sums[0]));
        }
        light->treePlace = std::uint32_t(_table.cdf.size());
        _table.cdf.push_back(shared::FloatOfBits(std::uint32_t(portals.size())));
        _table.cdf.push_back(shared::FloatOfBits(sumsBase));
        const std::size_t first = _table.cdf.size();
        const std::size_t size = portals.size() * sizeof(portals[0]);
        _table.cdf.resize(first + size / sizeof(_table.cdf[0]));
        std::memcpy(&_table.cdf[first], portals.data(), size);
        _table.hasPortals = true;
    }
}

void LightTableBuilder::WarnIgnored(const PlacedLight& placed) {
    const LightDescription& light = placed.light;
    if (light.type == LightType::Dome && !light.textureFile.authoredPath.empty() &&
        light.textureFormat != "automatic" && light.textureFormat != "latlong") {
        _warnings.Add(placed.name, "dome texture format " + light.textureFormat +
                                       " is not supported; read as latlong");
    }
}

glm::dvec3 RadianceOf(const LightDescription& description, const shared::HdsLight& light) {
    const glm::dvec3 emission = glm::max(LightEmission(description), glm::dvec3(0.0));
    if (description.type == LightType::Distant) {
        const double irradiance = DistantIrradiance(DistantHalfAngle(description));
        return description.normalize ? emission / irradiance : emission;
    }
    if (description.type == LightType::Sphere && (light.flags & HDS_LIGHT_POINT) != 0) {
        /* A sphere's intensity is its radiance times its projected area, a quarter of its area. */
        return emission * (description.normalize ? 0.25 : 0.25 * light.area);
    }
    const bool isNormalized = description.type != LightType::Dome && description.normalize;
    return isNormalized ? emission / double(light.area) : emission;
}

/// RadianceOf. False: negative or not finite (with a warning), or black.
bool LightTableBuilder::Radiance(const PlacedLight& placed, const shared::HdsLight& light,
                                 glm::dvec3* radiance) {
    *radiance = RadianceOf(placed.light, light);
    if (!IsUsableRadiance(*radiance) ||
        (Luminance(*radiance) <= 0.0 && Luminance(LightEmission(placed.light)) < 0.0)) {
        _warnings.Add(placed.name, "light's emission is not between 0 and 1e30; left out");
        return false;
    }
    return Luminance(*radiance) > 0.0;
}

/// False: cannot be read, the light stays untextured. \param meanLuminance of the image, as the
/// light's power has it
bool LightTableBuilder::AddImage(const PlacedLight& placed, shared::HdsLight* light,
                                 double* meanLuminance) {
    const AssetReference& file = placed.light.textureFile;
    const bool isDome = light->type == HDS_LIGHT_DOME;
    const LightTexture texture = _input.loadImage ? _input.loadImage(file) : LightTexture();
    if (!texture.image) {
        _warnings.Add(placed.name, "cannot read " + file.authoredPath + "; " +
                                       (isDome ? "dome" : "light") + " is untextured");
        return false;
    }
    const LightImage& image = *texture.image;
    const bool leavesMean = !IsSampledAlone(placed) && placed.portals.empty();
    const LightImageTable distribution =
        isDome ? BuildLatLongTable(image, leavesMean) : BuildFlatTable(image);
    light->flags |= HDS_LIGHT_TEXTURED;
    light->dataBase = texture.index;
    light->dataSize[0] = distribution.width;
    light->dataSize[1] = distribution.numRows;
    light->params[3] = float(image.mip);
    light->cdfBase = std::uint32_t(_table.cdf.size());
    ++_table.numImages;
    _table.cdf.insert(_table.cdf.end(), distribution.cdf.begin(), distribution.cdf.end());
    *meanLuminance = distribution.meanLuminance;
    return true;
}

void SetEmission(const glm::dvec3& radiance, double power, shared::HdsLight* light) {
    for (int i = 0; i < 3; ++i) {
        light->radiance[i] = float(radiance[i]);
    }
    const bool isFar = light->boundRadius >= HDS_LIGHT_FAR;
    light->strength = float(std::min(isFar ? power : power / (4.0 * kLightPi), kMaxStrength));
}

void LightTableBuilder::Push(shared::HdsLight light, const glm::dvec3& radiance, double power) {
    SetEmission(radiance, power, &light);
    _table.lights.push_back(light);
}

/// The number of a light's group; 0: it is in none.
std::uint32_t LightTableBuilder::GroupOf(const PlacedLight& placed) {
    const std::string& group = placed.light.group;
    if (group.empty()) {
        return 0;
    }
    const auto found = std::find(_table.groups.begin(), _table.groups.end(), group);
    const auto number = static_cast<std::uint32_t>(found - _table.groups.begin()) + 1;
    if (number > HDS_MAX_LIGHT_GROUPS) {
        _warnings.Add(placed.name, "there are too many groups of lights; in none");
        return 0;
    }
    if (found == _table.groups.end()) {
        _table.groups.push_back(group);
    }
    return number;
}

void LightTableBuilder::AddLight(const PlacedLight& authored) {
    PlacedLight placed = authored;
    ApplyFilterMultipliers(placed.filters, _warnings, &placed.light);
    for (LightCell& cell : placed.cells) {
        Warnings same; // as those of the light
        ApplyFilterMultipliers(placed.filters, same, &cell.light);
    }
    const LightDescription& description = placed.light;
    WarnIgnored(placed);
    shared::HdsLight light = PlainLight();
    light.type = TypeOf(description.type);
    light.flags = description.visibleToCamera ? HDS_LIGHT_VISIBLE : 0U;
    const bool isPoint =
        (description.type == LightType::Sphere && description.treatAsPoint) ||
        (description.type == LightType::Distant && !(DistantHalfAngle(description) > 0.0));
    light.flags |= isPoint ? HDS_LIGHT_POINT : 0U;
    light.flags |= GroupOf(placed) << HDS_LIGHT_GROUP_SHIFT;
    // One that has no extent at the frame is as it is when it has some.
    bool isPlaced = PlaceLight(description, placed.worldFromLight, &light);
    for (auto cell = placed.cells.begin(); !isPlaced && cell != placed.cells.end(); ++cell) {
        isPlaced = PlaceLight(description, cell->worldFromLight, &light);
    }
    if (!isPlaced) {
        _warnings.Add(placed.name, "light has a singular transform or no size; left out");
        return;
    }
    glm::dvec3 radiance;
    if (!Radiance(placed, light, &radiance)) {
        return;
    }
    const bool isTextured = !description.textureFile.authoredPath.empty();
    const double basePower = PowerOf(description, isPoint, radiance, light.area);
    double meanLuminance = 1.0;
    if (isTextured && (light.type == HDS_LIGHT_DOME || light.type == HDS_LIGHT_RECT)) {
        AddImage(placed, &light, &meanLuminance);
    }
    if (light.type == HDS_LIGHT_DOME) {
        AddPortals(placed, &light);
    }
    double power = basePower * meanLuminance;
    AddShaping(placed, &light, &power);
    AddControls(placed, basePower, &light, &power);
    if (power > 0.0) {
        Push(light, radiance, power);
    }
}

/// Puts lights at infinity first, as selection wants them, and builds the tree over the others.
LightTable LightTableBuilder::Finish() {
    std::vector<std::uint32_t> order(_table.lights.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_partition(order.begin(), order.end(), [&](std::uint32_t i) {
        return _table.lights[i].boundRadius >= HDS_LIGHT_FAR;
    });
    std::vector<shared::HdsLight> lights;
    std::vector<std::uint32_t> newIndex(order.size());
    for (const std::uint32_t old : order) {
        newIndex[old] = std::uint32_t(lights.size());
        lights.push_back(_table.lights[old]);
    }
    _table.lights = std::move(lights);
    for (shared::HdsLightTriangle& triangle : _table.triangles) {
        triangle.light = newIndex[triangle.light];
    }
    for (const std::uint32_t base : _table.tableByMesh) {
        const std::uint32_t light = base == HDS_NONE ? HDS_NONE : BitsAt(base + HDS_MESH_LIGHT);
        if (light != HDS_NONE) {
            _table.cdf[base + HDS_MESH_LIGHT] = shared::FloatOfBits(newIndex[light]);
        }
    }
    _table.nodes = BuildLightTree(_table.lights, _table.cdf);
    return std::move(_table);
}

LightTable BuildLightTable(const std::vector<PlacedLight>& lights,
                           const std::vector<EmissiveMesh>& meshes, const LightTableInput& input,
                           Warnings& warnings) {
    LightTableBuilder builder(input, warnings);
    for (const PlacedLight& light : lights) {
        builder.AddLight(light);
    }
    for (const EmissiveMesh& mesh : meshes) {
        builder.AddMesh(mesh);
    }
    return builder.Finish();
}

} // namespace hds
