// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/lightCommit.h"

#include "hdStream/base/hash.h"
#include "hdStream/persist/file.h"
#include "hdStream/persist/fileIdentity.h"
#include "hdStream/scene/emissiveMeshes.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <type_traits>
#include <utility>

namespace hds {

namespace {

/// Files of IES profiles have some kilobytes; what is longer is none.
constexpr std::uint64_t kMaxProfileBytes = 64U << 20U;

std::vector<PlacedLight> PlaceLights(const LightCommitInput& input) {
    const SceneDescription& scene = *input.scene;
    const glm::dmat4 centreFromWorld = glm::translate(glm::dmat4(1.0), -input.centre);
    std::vector<PlacedLight> placed;
    for (const auto& [path, prim] : scene.lights) {
        if (!prim.placement.visible) {
            continue;
        }
        LightDescription light = prim.light;
        if (light.type == LightType::Dome) {
            light.visibleToCamera = light.visibleToCamera && input.domeVisible;
        }
        PlacedLight place{path,
                          light,
                          {},
                          input.links->IndexOf(prim.links.lightLink),
                          input.links->IndexOf(prim.links.shadowLink),
                          prim.portals};
        for (LightPortal& portal : place.portals) {
            portal.worldFromPortal = centreFromWorld * portal.worldFromPortal;
        }
        ForEachPlacement(scene, prim.placement, [&](const glm::dmat4& worldFromLight) {
            place.worldFromLight = centreFromWorld * worldFromLight;
            placed.push_back(place);
        });
    }
    return placed;
}

/// All that a light table is made of, as bytes.
class KeyWriter {
public:
    template <typename T>
    void Add(const T& value) {
        static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>, "no padding, no pointers");
        _key.append(reinterpret_cast<const char*>(&value), sizeof(value));
    }
    void Add(const std::string& text) {
        Add(text.size());
        _key += text;
    }
    void Add(const AssetReference& asset) {
        Add(asset.authoredPath);
        Add(asset.file);
        Add(asset.offset);
        Add(asset.size);
    }
    void Add(const LightDescription& light) {
        Add(light.type);
        for (const float value :
             {light.intensity, light.exposure, light.diffuse, light.specular, light.color[0],
              light.color[1], light.color[2], light.colorTemperature, light.angle, light.radius,
              light.width, light.height, light.length}) {
            Add(value);
        }
        for (const bool flag : {light.normalize, light.enableColorTemperature, light.treatAsPoint,
                                light.treatAsLine, light.visibleToCamera}) {
            Add(flag);
        }
        Add(light.textureFormat);
        Add(light.textureFile);
        Add(light.shaping);
        Add(light.shadow);
    }
    void Add(const LightShaping& shaping) {
        for (const float value :
             {shaping.focus, shaping.focusTint[0], shaping.focusTint[1], shaping.focusTint[2],
              shaping.coneAngle, shaping.coneSoftness, shaping.iesAngleScale}) {
            Add(value);
        }
        Add(shaping.iesFile);
        Add(shaping.iesNormalize);
    }
    void Add(const LightShadow& shadow) {
        Add(shadow.enable);
        for (const float value : {shadow.color[0], shadow.color[1], shadow.color[2],
                                  shadow.distance, shadow.falloff, shadow.falloffGamma}) {
            Add(value);
        }
    }
    void Add(const LinkTable& links) {
        Add(links.numSets);
        for (const std::vector<bool>& category : links.categories) {
            for (const bool isIn : category) {
                Add(isIn);
            }
        }
    }
    void Add(const PlacedLight& light) {
        Add(light.name);
        Add(light.light);
        Add(light.lightLink);
        Add(light.shadowLink);
        Add(light.worldFromLight);
        Add(light.portals.size());
        for (const LightPortal& portal : light.portals) {
            Add(portal.worldFromPortal);
            Add(portal.width);
            Add(portal.height);
        }
    }
    void Add(const EmissiveMesh& mesh) {
        Add(mesh.name);
        Add(mesh.radiance);
        Add(mesh.twoSided);
        Add(mesh.isGlowing);
        Add(mesh.positionError);
        Add(mesh.wholeArea);
        Add(mesh.lux.has_value());
        if (mesh.lux) {
            Add(*mesh.lux);
        }
        Add(mesh.triangles.size());
        for (const EmissiveMesh::Triangle& triangle : mesh.triangles) {
            Add(triangle.primId);
            Add(triangle.glow);
            for (const glm::dvec3& corner : triangle.p) {
                Add(corner);
            }
        }
    }
    std::string Take() { return std::move(_key); }

private:
    void Add(const glm::dvec3& v) {
        for (int i = 0; i < 3; ++i) {
            Add(v[i]);
        }
    }
    void Add(const glm::dmat4& m) {
        for (int i = 0; i < 16; ++i) {
            Add(m[i / 4][i % 4]);
        }
    }
    std::string _key;
};

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
        const File file = File::Open(asset.file);
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
    KeyWriter writer;
    writer.Add(links);
    for (const PlacedLight& light : lights) {
        writer.Add(light);
        writer.Add(HasImage(light.light) ? images.Find(light.light.textureFile).index : 0);
        writer.Add(IdentityOf(light.light.shaping.iesFile));
    }
    for (const EmissiveMesh& mesh : emissive) {
        writer.Add(mesh);
        if (mesh.lux) {
            writer.Add(IdentityOf(mesh.lux->light.shaping.iesFile));
        }
    }
    std::string key = writer.Take();
    if (!cache->lights || key != cache->lightKey) {
        LightTableInput input;
        input.loadImage = [&](const AssetReference& asset) { return images.Find(asset); };
        input.loadProfile = [&](const AssetReference& asset) {
            return LoadProfile(asset, warnings);
        };
        input.links = links;
        cache->lights =
            std::make_shared<const LightTable>(BuildLightTable(lights, emissive, input, warnings));
        cache->lightKey = std::move(key);
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
            cache->images.LoadLightImage(texture.file, cache->textures.get()) != nullptr;
        if (isReadable && keys.insert(MaterialTextureKey(texture)).second) {
            textures.push_back(texture);
        }
    }
    return textures;
}

CommittedLights CommitLights(const LightCommitInput& input, CommitCache* cache,
                             Warnings& warnings) {
    CommittedLights result;
    std::vector<PlacedLight> lights = PlaceLights(input);
    EmissiveMeshes emissive = CollectEmissiveMeshes(input, cache, warnings);
    result.firstEntryByRecord = std::move(emissive.firstEntryByRecord);
    result.lightByEntry = std::move(emissive.meshByEntry);
    result.emissiveTriangles = emissive.numTriangles;
    // Lights that are all hidden leave the scene dark.
    if (input.scene->lights.empty() && input.ownRecords->empty()) {
        warnings.Add("", "the stage has no lights: lit by a uniform dome of radiance 1");
        PlacedLight dome;
        dome.name = "default dome";
        dome.light.type = LightType::Dome;
        dome.light.visibleToCamera = input.domeVisible;
        lights.push_back(dome);
    }
    UpdateTable(lights, emissive.meshes, ImageFinder(input.materials->textures, cache),
                input.links->Table(), cache, warnings);
    result.glowByRecord.resize(result.firstEntryByRecord.size());
    for (std::size_t record = 0; record < result.glowByRecord.size(); ++record) {
        const bool isLast = record + 1 == result.glowByRecord.size();
        const std::size_t end =
            isLast ? result.lightByEntry.size() : result.firstEntryByRecord[record + 1];
        for (std::size_t i = result.firstEntryByRecord[record]; i < end; ++i) {
            std::uint32_t& entry = result.lightByEntry[i];
            if (entry != HDS_NONE) {
                const bool isGlowing = emissive.meshes[entry].isGlowing;
                entry = cache->lights->tableByMesh[entry];
                result.glowByRecord[record] =
                    result.glowByRecord[record] || (isGlowing && entry != HDS_NONE);
            }
        }
    }
    return result;
}

} // namespace hds
