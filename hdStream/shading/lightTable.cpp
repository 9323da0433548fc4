// SPDX-License-Identifier: Apache-2.0
// Builds the tables of kernels/light from UsdLux lights and emissive meshes.
#include "hdStream/shading/lightTable.h"

#include "hdStream/shading/lightPlacement.h"
#include "hdStream/shading/lightShaping.h"
#include "hdStream/shading/lightTree.h"
#include "hdStream/shading/lightUnits.h"
#include "hdStream/shading/movingMesh.h"

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

constexpr double kPi = 3.14159265358979323846;

double Luminance(const glm::dvec3& rgb) {
    return glm::dot(rgb, glm::dvec3(0.2126, 0.7152, 0.0722));
}

/// What is brighter cannot be summed over lights, areas and bounces in floats.
constexpr double kMaxRadiance = 1e30;
/// Of a light: sums over lights stay finite. Only ratios matter.
constexpr double kMaxStrength = 1e28;
/// Most of a mesh that moves: its turns between keys are not quite those of its triangles, and so
/// its estimate must not become 0.
constexpr float kMovingFlatness = 0.99F;

bool IsShadowPlain(const LightShadow& shadow) {
    return shadow.enable && shadow.distance < 0.0F &&
           shadow.color == std::array<float, 3>{0.0F, 0.0F, 0.0F};
}

bool IsUsable(const glm::dvec3& radiance) {
    return glm::all(glm::lessThanEqual(radiance, glm::dvec3(kMaxRadiance))); // false for NaN
}

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

/// Grows the tables light by light.
class Builder {
public:
    Builder(const LightTableInput& input, Warnings& warnings) : _input(input), _warnings(warnings) {
        AddLinks();
    }

    void AddLight(const PlacedLight& placed);
    void AddMesh(const EmissiveMesh& mesh);
    LightTable Finish();

private:
    std::uint32_t GroupOf(const PlacedLight& placed);
    bool Radiance(const PlacedLight& placed, const shared::HdsLight& light, glm::dvec3* radiance);
    bool AddImage(const PlacedLight& placed, shared::HdsLight* light, double* meanLuminance);
    std::uint32_t LinkOf(std::uint32_t category) const {
        return category == HDS_NONE ? HDS_NONE : _linkBases[category];
    }
    bool IsSampledAlone(const PlacedLight& placed) const {
        return !IsShadowPlain(placed.light.shadow) || LinkOf(placed.shadowLink) != HDS_NONE;
    }
    void AddLinks();
    void AddShaping(const PlacedLight& placed, shared::HdsLight* light, double* power);
    void AddControls(const PlacedLight& placed, shared::HdsLight* light, double* power);
    void AddFilters(const PlacedLight& placed, shared::HdsLightControls* controls, double* power);
    void AddKeys(const std::vector<LightKey>& lightKeys, shared::HdsLightControls* controls);
    void AppendControls(const shared::HdsLightControls& controls, shared::HdsLight* light);
    void AddMeshMotion(const EmissiveMesh& mesh, const EmissiveClusters& all,
                       const EmissiveCluster& cluster, std::uint32_t matrixBase,
                       shared::HdsLight* light);
    void AddPortals(const PlacedLight& placed, shared::HdsLight* light);
    void WarnIgnored(const PlacedLight& placed);
    void Push(shared::HdsLight light, const glm::dvec3& radiance, double power);
    bool MeshRadiance(const EmissiveMesh& mesh, glm::dvec3* radiance);
    shared::HdsLight BeginMesh(const EmissiveMesh& mesh, bool isWeighed, double* factor);
    void AddTriangle(const EmissiveMesh& mesh, const EmissiveTriangle& triangle);
    void AddCluster(const EmissiveMesh& mesh, const EmissiveClusters& all,
                    const EmissiveCluster& cluster, shared::HdsLight light,
                    const glm::dvec3& radiance, double factor, std::uint32_t matrixBase);
    void AddMeshTable(std::uint32_t firstLight, std::uint32_t firstTriangle, bool isOneLight);
    std::uint32_t BitsAt(std::uint32_t word) const {
        std::uint32_t bits = 0;
        std::memcpy(&bits, &_table.cdf[word], sizeof(bits));
        return bits;
    }

    const LightTableInput& _input;
    Warnings& _warnings;
    std::vector<std::uint32_t> _linkBases; ///< of each category
    LightTable _table;
};

/// A light that shines alike in all directions on everything.
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
void Builder::AddLinks() {
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
void Builder::AddShaping(const PlacedLight& placed, shared::HdsLight* light, double* power) {
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
void Builder::AddKeys(const std::vector<LightKey>& lightKeys, shared::HdsLightControls* controls) {
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

void Builder::AddFilters(const PlacedLight& placed, shared::HdsLightControls* controls,
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

void Builder::AppendControls(const shared::HdsLightControls& controls, shared::HdsLight* light) {
    light->controlBase = std::uint32_t(_table.cdf.size());
    _table.cdf.resize(_table.cdf.size() + sizeof(controls) / sizeof(_table.cdf[0]));
    std::memcpy(&_table.cdf[light->controlBase], &controls, sizeof(controls));
    _table.hasControls = true;
}

/// \param[in,out] power grows by the peak of the filters
void Builder::AddControls(const PlacedLight& placed, shared::HdsLight* light, double* power) {
    const LightDescription& description = placed.light;
    light->lightLink = LinkOf(placed.lightLink);
    light->shadowLink = LinkOf(placed.shadowLink);
    if (IsSampledAlone(placed)) {
        light->flags |= HDS_LIGHT_SAMPLED;
    }
    shared::HdsLightControls controls = LightControls(description);
    AddFilters(placed, &controls, power);
    if (!IsShadowPlain(description.shadow) || description.diffuse != 1.0F ||
        description.specular != 1.0F || !placed.keys.empty() || controls.numFilters > 0) {
        AddKeys(placed.keys, &controls);
        AppendControls(controls, light);
    }
    _table.hasControls =
        _table.hasControls || light->lightLink != HDS_NONE || light->shadowLink != HDS_NONE;
}

/// The portals of a dome, as rects of radiance 1, and the sums over its image. To be called after
/// AddImage.
void Builder::AddPortals(const PlacedLight& placed, shared::HdsLight* light) {
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

void Builder::WarnIgnored(const PlacedLight& placed) {
    const LightDescription& light = placed.light;
    if (light.type == LightType::Dome && !light.textureFile.authoredPath.empty() &&
        light.textureFormat != "automatic" && light.textureFormat != "latlong") {
        _warnings.Add(placed.name, "dome texture format " + light.textureFormat +
                                       " is not supported; read as latlong");
    }
}

/// Emission after `normalize`; for delta lights the intensity (sphere) or irradiance (distant).
/// False: negative or not finite (with a warning), or black.
bool Builder::Radiance(const PlacedLight& placed, const shared::HdsLight& light,
                       glm::dvec3* radiance) {
    const LightDescription& description = placed.light;
    const glm::dvec3 emission = LightEmission(description);
    *radiance = glm::max(emission, glm::dvec3(0.0));
    if (description.type == LightType::Distant) {
        const double irradiance = DistantIrradiance(DistantHalfAngle(description));
        *radiance /= description.normalize ? irradiance : 1.0;
    } else if (description.type == LightType::Sphere && (light.flags & HDS_LIGHT_POINT) != 0) {
        /* A sphere's intensity is its radiance times its projected area, a quarter of its area. */
        *radiance *= description.normalize ? 0.25 : 0.25 * light.area;
    } else if (description.type != LightType::Dome && description.normalize) {
        *radiance /= double(light.area);
    }
    if (!IsUsable(*radiance) || (Luminance(*radiance) <= 0.0 && Luminance(emission) < 0.0)) {
        _warnings.Add(placed.name, "light's emission is not between 0 and 1e30; left out");
        return false;
    }
    return Luminance(*radiance) > 0.0;
}

/// False: cannot be read, the light stays untextured. \param meanLuminance of the image, as the
/// light's power has it
bool Builder::AddImage(const PlacedLight& placed, shared::HdsLight* light, double* meanLuminance) {
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

void Builder::Push(shared::HdsLight light, const glm::dvec3& radiance, double power) {
    for (int i = 0; i < 3; ++i) {
        light.radiance[i] = float(radiance[i]);
    }
    const bool isFar = light.boundRadius >= HDS_LIGHT_FAR;
    light.strength = float(std::min(isFar ? power : power / (4.0 * kPi), kMaxStrength));
    _table.lights.push_back(light);
}

/// The number of a light's group; 0: it is in none.
std::uint32_t Builder::GroupOf(const PlacedLight& placed) {
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

void Builder::AddLight(const PlacedLight& authored) {
    PlacedLight placed = authored;
    ApplyFilterMultipliers(placed.filters, _warnings, &placed.light);
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
    if (!PlaceLight(description, placed.worldFromLight, &light)) {
        _warnings.Add(placed.name, "light has a singular transform or no size; left out");
        return;
    }
    glm::dvec3 radiance;
    if (!Radiance(placed, light, &radiance)) {
        return;
    }
    const bool isTextured = !description.textureFile.authoredPath.empty();
    double power = Luminance(radiance) * kPi * light.area;
    if (description.type == LightType::Distant) {
        power = Luminance(radiance) * DistantIrradiance(DistantHalfAngle(description));
    } else if (description.type == LightType::Dome) {
        double meanLuminance = 1.0;
        if (isTextured) {
            AddImage(placed, &light, &meanLuminance);
        }
        power = kPi * Luminance(radiance) * meanLuminance;
        AddPortals(placed, &light);
    } else if (isPoint) {
        power = Luminance(radiance) * 4.0 * kPi;
    } else if (description.type == LightType::Rect && isTextured) {
        double meanLuminance = 1.0;
        AddImage(placed, &light, &meanLuminance);
        power *= meanLuminance;
    }
    AddShaping(placed, &light, &power);
    AddControls(placed, &light, &power);
    if (power > 0.0) {
        Push(light, radiance, power);
    }
}

/// What a mesh emits where its material does not vary the emission; false: nothing.
bool Builder::MeshRadiance(const EmissiveMesh& mesh, glm::dvec3* radiance) {
    if (mesh.lux && mesh.lux->light.normalize && !(mesh.wholeArea > 0.0)) {
        return false;
    }
    *radiance = glm::max(mesh.radiance, glm::dvec3(0.0));
    if (mesh.lux) {
        shared::HdsLight light{};
        light.area = float(mesh.wholeArea);
        glm::dvec3 factor;
        if (!Radiance(*mesh.lux, light, &factor)) {
            return false;
        }
        *radiance *= factor;
    }
    if (!IsUsable(*radiance)) {
        _warnings.Add(mesh.name, "emission is not finite or above 1e30; not sampled as a light");
        return false;
    }
    return Luminance(*radiance) > 0.0;
}

/// What all clusters of a mesh have in common.
shared::HdsLight Builder::BeginMesh(const EmissiveMesh& mesh, bool isWeighed, double* factor) {
    shared::HdsLight light = PlainLight();
    light.type = HDS_LIGHT_MESH;
    light.dataSize[1] = HDS_NONE;
    light.flags = (mesh.twoSided ? HDS_LIGHT_TWO_SIDED : 0U) |
                  (mesh.hasTexturedEmission ? HDS_LIGHT_TEXTURED_EMISSION : 0U) |
                  (isWeighed || mesh.Moves() ? HDS_LIGHT_WEIGHED : 0U) |
                  (mesh.lux ? HDS_LIGHT_REPLACES : 0U);
    *factor = kPi * (mesh.twoSided ? 2.0 : 1.0);
    if (mesh.lux) {
        light.flags |= mesh.lux->light.visibleToCamera ? HDS_LIGHT_VISIBLE : 0U;
        light.flags |= GroupOf(*mesh.lux) << HDS_LIGHT_GROUP_SHIFT;
        AddShaping(*mesh.lux, &light, factor);
        AddControls(*mesh.lux, &light, factor);
    }
    _table.hasMeshes = true;
    _table.hasTexturedEmission = _table.hasTexturedEmission || mesh.hasTexturedEmission;
    return light;
}

void Builder::AddTriangle(const EmissiveMesh& mesh, const EmissiveTriangle& triangle) {
    constexpr double kRounding = 8.0 / 16777216.0; ///< of the float positions and their use
    glm::dvec3 p[3];
    for (int i = 0; i < 3; ++i) {
        p[i] = mesh.Moves() ? glm::dvec3(mesh.shapes[0][triangle.source].p[i]) : triangle.p[i];
    }
    const glm::dvec3 e1 = p[1] - p[0];
    const glm::dvec3 e2 = p[2] - p[0];
    shared::HdsLightTriangle out{};
    double largest = 0.0;
    for (int i = 0; i < 3; ++i) {
        out.p0[i] = float(p[0][i]);
        out.e1[i] = float(e1[i]);
        out.e2[i] = float(e2[i]);
        largest = std::max({largest, std::abs(triangle.p[0][i]), std::abs(triangle.p[1][i]),
                            std::abs(triangle.p[2][i])});
    }
    out.light = std::uint32_t(_table.lights.size());
    out.primId = triangle.primId;
    out.error = float(kRounding * largest + mesh.positionError);
    _table.triangles.push_back(out);
}

/// What is chosen by goes with its sphere; directions are bounds only where nothing bends.
void Builder::AddMeshMotion(const EmissiveMesh& mesh, const EmissiveClusters& all,
                            const EmissiveCluster& cluster, std::uint32_t matrixBase,
                            shared::HdsLight* light) {
    const ClusterWay way = FollowCluster(mesh, all, cluster);
    light->dataSize[1] = AppendMeshMotion(mesh, all, cluster, matrixBase, &_table.cdf);
    for (int i = 0; i < 3; ++i) {
        light->worldFromLight[4 * i + 3] = light->center[i];
    }
    light->params[0] = way.isBent ? 0.0F : std::min(light->params[0], kMovingFlatness);
    light->boundRadius = float(way.radius * (1.0 + 1e-5));
    shared::HdsLightControls controls = LightControls(LightDescription());
    if (light->controlBase != HDS_NONE) {
        std::memcpy(&controls, &_table.cdf[light->controlBase], sizeof(controls));
    }
    AddKeys(way.keys, &controls);
    AppendControls(controls, light);
}

/// A cluster's triangles, their distribution, and the light that it is.
void Builder::AddCluster(const EmissiveMesh& mesh, const EmissiveClusters& all,
                         const EmissiveCluster& cluster, shared::HdsLight light,
                         const glm::dvec3& radiance, double factor, std::uint32_t matrixBase) {
    light.area = float(cluster.area);
    light.dataBase = std::uint32_t(_table.triangles.size());
    light.dataSize[0] = std::uint32_t(cluster.end - cluster.begin);
    light.cdfBase = std::uint32_t(_table.cdf.size());
    double sum = 0.0;
    _table.cdf.push_back(0.0F);
    for (std::size_t i = cluster.begin; i < cluster.end; ++i) {
        AddTriangle(mesh, all.triangles[i]);
        sum += all.triangles[i].weight;
        _table.cdf.push_back(i + 1 == cluster.end ? 1.0F : float(sum / cluster.weight));
    }
    const glm::dvec3 center = 0.5 * (cluster.low + cluster.high);
    for (int i = 0; i < 3; ++i) {
        light.center[i] = float(center[i]);
        light.worldFromLight[i] = float(cluster.axis[i]);
    }
    light.params[0] = float(cluster.flatness);
    light.boundRadius = float(0.5 * glm::length(cluster.high - cluster.low) * (1.0 + 1e-5));
    if (mesh.Moves()) {
        AddMeshMotion(mesh, all, cluster, matrixBase, &light);
    }
    Push(light, radiance, Luminance(radiance) * factor * cluster.weight);
}

/// Where a hit finds its triangle's light.
void Builder::AddMeshTable(std::uint32_t firstLight, std::uint32_t firstTriangle, bool isOneLight) {
    _table.tableByMesh.back() = std::uint32_t(_table.cdf.size());
    const auto add = [&](std::uint32_t word) { _table.cdf.push_back(shared::FloatOfBits(word)); };
    if (isOneLight) {
        add(firstLight);
        add(0);
        return;
    }
    std::vector<std::uint32_t> order(_table.triangles.size() - firstTriangle);
    std::iota(order.begin(), order.end(), firstTriangle);
    const auto primId = [&](std::uint32_t i) { return _table.triangles[i].primId; };
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return primId(a) < primId(b); });
    add(HDS_NONE);
    add(std::uint32_t(order.size()));
    for (const std::uint32_t i : order) {
        add(primId(i));
    }
    std::for_each(order.begin(), order.end(), add);
}

void Builder::AddMesh(const EmissiveMesh& mesh) {
    _table.tableByMesh.push_back(HDS_NONE);
    const EmissiveClusters all = ClusterTriangles(mesh);
    glm::dvec3 radiance;
    double factor = 0.0;
    const auto firstLight = std::uint32_t(_table.lights.size());
    const auto firstTriangle = std::uint32_t(_table.triangles.size());
    const bool isUsable = MeshRadiance(mesh, &radiance);
    if (isUsable && all.weight > 0.0) {
        const shared::HdsLight light = BeginMesh(mesh, all.isWeighed, &factor);
        const std::uint32_t matrixBase = mesh.Moves() ? AppendMatrices(mesh, &_table.cdf) : 0;
        for (const EmissiveCluster& cluster : all.clusters) {
            AddCluster(mesh, all, cluster, light, radiance, factor, matrixBase);
        }
        AddMeshTable(firstLight, firstTriangle,
                     all.clusters.size() == 1 && (light.flags & HDS_LIGHT_WEIGHED) == 0);
    } else if (mesh.lux) {
        // Not sampled, but rays that find it see what it emits, which may be nothing.
        Push(BeginMesh(mesh, false, &factor), isUsable ? radiance : glm::dvec3(0.0), 0.0);
        AddMeshTable(firstLight, firstTriangle, true);
    }
}

/// Puts lights at infinity first, as selection wants them, and builds the tree over the others.
LightTable Builder::Finish() {
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

} // namespace

LightTable BuildLightTable(const std::vector<PlacedLight>& lights,
                           const std::vector<EmissiveMesh>& meshes, const LightTableInput& input,
                           Warnings& warnings) {
    Builder builder(input, warnings);
    for (const PlacedLight& light : lights) {
        builder.AddLight(light);
    }
    for (const EmissiveMesh& mesh : meshes) {
        builder.AddMesh(mesh);
    }
    return builder.Finish();
}

} // namespace hds
