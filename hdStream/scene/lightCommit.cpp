// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/lightCommit.h"

#include "hdStream/base/fieldHash.h"
#include "hdStream/persist/file.h"
#include "hdStream/persist/fileIdentity.h"
#include "hdStream/scene/emissiveMeshes.h"
#include "hdStream/scene/lightCells.h"
#include "hdStream/scene/placements.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace hds {

namespace {

/// Files of IES profiles have some kilobytes; what is longer is none.
constexpr std::uint64_t kMaxProfileBytes = 64U << 20U;

/// Images of filters always lie in the light table: what is larger is averaged.
constexpr std::uint32_t kMaxFilterTexels = 1024;

/// Lights that change have at most that many records together, 24 MiB, unless each has but one:
/// where more would be needed, all have fewer.
constexpr std::size_t kMostLightRecords = 1U << 17U;

bool IsNoTurn(const LightKey& key) {
    constexpr double kRounding = 1e-12;
    return glm::length(glm::dvec3(key.turn)) <= kRounding;
}

/// Where one placement of a light is over the shutter, and how it is.
struct LightWay {
    std::vector<LightKey> keys;
    std::vector<LightCell> cells;
    bool hasPortals = false; ///< and would move

    /// \param mostCells of MakeLightCells
    void Follow(const LightPrim& prim, const Shutter& shutter,
                const MovingTransform& worldFromLight, std::size_t mostCells) {
        // What is at infinity has directions alone; filters and portals lie somewhere.
        const LightType type = prim.light.type;
        const bool isFar = (type == LightType::Distant || type == LightType::Dome) &&
                           prim.filters.empty() && prim.portals.empty();
        const MovingTransform way = isFar ? worldFromLight.Directions() : worldFromLight;
        bool isRigid = true;
        keys = MakeLightKeys(way, &isRigid);
        if (isFar && std::all_of(keys.begin(), keys.end(), IsNoTurn)) {
            keys.clear();
        }
        if (!keys.empty() && !prim.portals.empty()) {
            hasPortals = true;
            keys.clear();
        }
        cells = MakeLightCells(prim, shutter, way, keys, isRigid, mostCells);
    }

    void Warn(const std::string& path, Warnings& warnings) const {
        if (hasPortals) {
            warnings.Add(path, "dome with portals: not blurred by its motion");
        }
    }
};

/// Where the instances of a light take its filters, which lie in the world as the light does before
/// it is instanced: the places of a prim that is at their origin. No inverse of the light's own
/// transform, which may be flat.
std::vector<Placed> PlacesOfFilters(const SceneDescription& scene, const LightPrim& prim) {
    if (prim.filters.empty()) {
        return {};
    }
    Placement place = prim.placement;
    place.worldFromObject = glm::dmat4(1.0);
    place.samples.clear();
    return PlacementsOf(scene, place, Shutter());
}

/// \param mostCells of a light (MakeLightCells). \return nothing: there are too many together
std::optional<std::vector<PlacedLight>> TryPlaceLights(const LightCommitInput& input,
                                                       std::size_t mostCells, Warnings& warnings) {
    const SceneDescription& scene = *input.scene;
    const glm::dmat4 centreFromWorld = glm::translate(glm::dmat4(1.0), -input.centre);
    std::vector<PlacedLight> placed;
    std::size_t numCells = 0;
    const auto areTooMany = [&] { return numCells > kMostLightRecords && mostCells > 1; };
    for (const auto& [path, prim] : scene.lights) {
        if (!prim.placement.visible || areTooMany()) {
            continue;
        }
        LightDescription light = prim.light;
        const bool isSeen = light.type == LightType::Dome ? input.domeVisible : input.lightsVisible;
        light.visibleToCamera = light.visibleToCamera && isSeen;
        PlacedLight place{path,
                          light,
                          {},
                          input.links->IndexOf(prim.links.lightLink),
                          input.links->IndexOf(prim.links.shadowLink),
                          prim.portals,
                          prim.filters,
                          {},
                          {}};
        for (LightPortal& portal : place.portals) {
            portal.worldFromPortal = centreFromWorld * portal.worldFromPortal;
        }
        LightWay way;
        WarnOfTooMany(scene, path, prim.placement, warnings);
        const std::vector<Placed> ofFilters = PlacesOfFilters(scene, prim);
        std::size_t number = 0;
        ForEachPlacement(scene, prim.placement, input.shutter,
                         [&](const MovingTransform& worldFromLight) {
                             if (areTooMany()) {
                                 return;
                             }
                             way.Follow(prim, input.shutter, worldFromLight, mostCells);
                             numCells += way.cells.size();
                             place.worldFromLight = centreFromWorld * worldFromLight.AtFrame();
                             place.keys = way.keys;
                             place.cells = way.cells;
                             place.light = way.cells.empty() ? light : MostOf(light, way.cells);
                             for (LightCell& cell : place.cells) {
                                 cell.worldFromLight = centreFromWorld * cell.worldFromLight;
                                 cell.light.visibleToCamera = light.visibleToCamera;
                             }
                             for (std::size_t i = 0; i < place.filters.size(); ++i) {
                                 place.filters[i].worldFromFilter =
                                     centreFromWorld * ofFilters[number].worldFromObject.AtFrame() *
                                     prim.filters[i].worldFromFilter;
                             }
                             ++number;
                             placed.push_back(place);
                         });
        way.Warn(path, warnings);
    }
    return areTooMany() ? std::nullopt : std::optional(std::move(placed));
}

std::vector<PlacedLight> PlaceLights(const LightCommitInput& input, Warnings& warnings) {
    std::size_t mostCells = kMostLightCells;
    std::optional<std::vector<PlacedLight>> placed = TryPlaceLights(input, mostCells, warnings);
    while (!placed) {
        mostCells /= 2;
        placed = TryPlaceLights(input, mostCells, warnings);
    }
    if (mostCells < kMostLightCells) {
        warnings.Add("", "lights that change over the shutter have " + std::to_string(mostCells) +
                             " parts of it at most, since there are many");
    }
    return std::move(*placed);
}

/// The image of a filter, at most kMaxFilterTexels in width and height; null, after a warning, when
/// it cannot be read.
std::shared_ptr<const FilterImage> LoadImageOfFilter(const AssetReference& asset,
                                                     ImageLibrary* images) {
    std::array<std::shared_ptr<const HeightImage>, 3> channels;
    for (std::uint32_t c = 0; c < 3; ++c) {
        channels[c] = images->LoadHeights(LightTextureOf(asset), c);
        if (!channels[c]) {
            return nullptr;
        }
    }
    const std::uint32_t width = channels[0]->width;
    const std::uint32_t height = channels[0]->height;
    const std::uint32_t step =
        (std::max(width, height) + kMaxFilterTexels - 1) / kMaxFilterTexels; // texels to one
    auto image = std::make_shared<FilterImage>();
    image->width = (width + step - 1) / step;
    image->height = (height + step - 1) / step;
    for (std::uint32_t y = 0; y < image->height; ++y) {
        for (std::uint32_t x = 0; x < image->width; ++x) {
            for (const auto& channel : channels) {
                double sum = 0.0;
                std::uint32_t count = 0;
                for (std::uint32_t j = y * step; j < std::min((y + 1) * step, height); ++j) {
                    for (std::uint32_t i = x * step; i < std::min((x + 1) * step, width); ++i) {
                        sum += channel->values[std::size_t(j) * width + i];
                        ++count;
                    }
                }
                image->rgb.push_back(float(sum / count));
            }
        }
    }
    return image;
}

/// Lights of these types show their images.
bool HasImage(const LightDescription& light) {
    return (light.type == LightType::Dome || light.type == LightType::Rect) &&
           !light.textureFile.authoredPath.empty();
}

/// Images of lights by their place among the scene's textures, which they begin.
class ImageFinder {
public:
    ImageFinder(const std::vector<MaterialTexture>& textures, CommitCache* cache) : _cache(*cache) {
        for (std::uint32_t i = 0; i < textures.size() && textures[i].isRadiance; ++i) {
            _indexByKey.emplace(MaterialTextureKey(textures[i]), i);
        }
    }

    LightTexture Find(const AssetReference& asset) const {
        const auto found = _indexByKey.find(MaterialTextureKey(LightTextureOf(asset)));
        if (found == _indexByKey.end()) {
            return {};
        }
        return {_cache.images.LoadLightImage(asset, _cache.textures.get()), found->second};
    }

private:
    CommitCache& _cache;
    std::map<std::string, std::uint32_t> _indexByKey;
};

/// The profile of a file; null, after a warning, when it cannot be used.
std::shared_ptr<const IesProfile> LoadProfile(const AssetReference& asset, Warnings& warnings) {
    std::string text;
    std::string error = "the file does not exist";
    if (!asset.file.empty()) {
        const File file = File::OpenForReading(asset.file);
        const std::uint64_t size = asset.size > 0 ? asset.size : file.Size();
        text.resize(std::min(size, kMaxProfileBytes));
        error = !file.IsOpen() || !file.Read(asset.offset, text.data(), text.size())
                    ? "it cannot be read"
                    : std::string();
    }
    IesProfile profile;
    if (error.empty()) {
        profile = ParseIesProfile(text, &error);
    }
    if (!error.empty()) {
        warnings.Add("", asset.authoredPath + ": not used as an IES profile: " + error);
        return nullptr;
    }
    return std::make_shared<const IesProfile>(std::move(profile));
}

/// Of a profile, so that an edited file is read again.
std::string IdentityOf(const AssetReference& asset) {
    Hasher hasher;
    const bool isThere =
        !asset.file.empty() && AppendFileIdentity(&hasher, asset.file, asset.offset, asset.size);
    return isThere ? hasher.Hex() : std::string();
}

void UpdateTable(const std::vector<PlacedLight>& lights, const std::vector<EmissiveMesh>& emissive,
                 const ImageFinder& images, const LinkTable& links, CommitCache* cache,
                 Warnings& warnings) {
    Hasher hasher;
    FieldHasher table(&hasher); // all that the table is made of
    table.Add(links);
    table.Add(lights);
    table.Add(emissive);
    for (const PlacedLight& light : lights) {
        table.Add(HasImage(light.light) ? images.Find(light.light.textureFile).index : 0);
        table.Add(IdentityOf(light.light.shaping.iesFile));
        for (const LightFilter& filter : light.filters) {
            const AssetReference* file = FilterImageFile(filter);
            table.Add(file == nullptr ? std::string() : IdentityOf(*file));
        }
    }
    for (const EmissiveMesh& mesh : emissive) {
        if (mesh.lux) {
            table.Add(IdentityOf(mesh.lux->light.shaping.iesFile));
        }
    }
    const PageKey key = MakePageKey(hasher);
    if (!cache->lights || key != cache->lightKey) {
        LightTableInput input;
        input.loadImage = [&](const AssetReference& asset) { return images.Find(asset); };
        input.loadProfile = [&](const AssetReference& asset) {
            return LoadProfile(asset, warnings);
        };
        input.loadFilterImage = [&](const AssetReference& asset) {
            return LoadImageOfFilter(asset, &cache->images);
        };
        input.links = links;
        cache->lights =
            std::make_shared<const LightTable>(BuildLightTable(lights, emissive, input, warnings));
        cache->lightKey = key;
    }
    cache->images.DropLightImages();
}

} // namespace

std::vector<MaterialTexture> LoadLightTextures(const SceneDescription& scene, CommitCache* cache) {
    std::vector<MaterialTexture> textures;
    std::set<std::string> keys;
    for (const auto& [path, prim] : scene.lights) {
        if (!prim.placement.visible || !HasImage(prim.light)) {
            continue;
        }
        const MaterialTexture texture = LightTextureOf(prim.light.textureFile);
        const bool isReadable =
            cache->images.LoadLightImage(prim.light.textureFile, cache->textures.get()) != nullptr;
        if (isReadable && keys.insert(MaterialTextureKey(texture)).second) {
            textures.push_back(texture);
        }
    }
    return textures;
}

CommittedLights CommitLights(const LightCommitInput& input, CommitCache* cache,
                             Warnings& warnings) {
    CommittedLights result;
    std::vector<PlacedLight> lights = PlaceLights(input, warnings);
    EmissiveMeshes emissive = CollectEmissiveMeshes(input, cache, warnings);
    result.firstEntryByRecord = std::move(emissive.firstEntryByRecord);
    result.lightByEntry = std::move(emissive.meshByEntry);
    result.emissiveTriangles = emissive.numTriangles;
    // Lights that are all hidden leave the scene dark.
    if (input.scene->lights.empty() && input.worldInstances->empty()) {
        warnings.Add("", "the stage has no lights: lit by a uniform dome of radiance 1");
        PlacedLight dome;
        dome.name = "default dome";
        dome.light.type = LightType::Dome;
        dome.light.visibleToCamera = input.domeVisible;
        lights.push_back(dome);
    }
    UpdateTable(lights, emissive.meshes, ImageFinder(input.materials->textures, cache),
                input.links->Table(), cache, warnings);
    result.texturedEmissionByRecord.resize(result.firstEntryByRecord.size());
    for (std::size_t record = 0; record < result.texturedEmissionByRecord.size(); ++record) {
        const bool isLast = record + 1 == result.texturedEmissionByRecord.size();
        const std::size_t end =
            isLast ? result.lightByEntry.size() : result.firstEntryByRecord[record + 1];
        for (std::size_t i = result.firstEntryByRecord[record]; i < end; ++i) {
            std::uint32_t& entry = result.lightByEntry[i];
            if (entry != HDS_NONE) {
                const bool hasTexturedEmission = emissive.meshes[entry].hasTexturedEmission;
                entry = cache->lights->tableByMesh[entry];
                result.texturedEmissionByRecord[record] =
                    result.texturedEmissionByRecord[record] ||
                    (hasTexturedEmission && entry != HDS_NONE);
            }
        }
    }
    return result;
}

} // namespace hds
