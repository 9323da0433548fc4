// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/materialCommit.h"

#include "hdStream/geometry/displacement.h"
#include "hdStream/geometry/splatSource.h"
#include "hdStream/scene/mediaBounds.h"
#include "hdStream/shading/materialPrimvars.h"
#include "hdStream/shading/programWriter.h"
#include "hdStream/shading/shaderMath.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace hds {

namespace {

/// In the place of a path: what splats have for a material.
const std::string kSplats = "splats";

} // namespace

void MaterialCommit::Compile(
    const std::vector<const std::pair<const std::string, GeometryPrim>*>& prims) {
    _displayColor.compiled = DisplayColorMaterial();
    _displayColor.primvars = hds::PrimvarsOf(_displayColor.compiled);
    _used[""] = &_displayColor;
    _splats.compiled = SplatMaterial(kSplatHarmonics);
    _splats.primvars = {kSplatHarmonics, kSplatDegree, kSplatOpacities, kSplatOrientations,
                        kSplatScales};
    _used[kSplats] = &_splats;
    std::vector<const std::pair<const std::string, std::shared_ptr<const MaterialNetwork>>*>
        missing;
    const auto use = [&](const std::string& primPath,
                         const std::string& materialPath) -> const CachedMaterial* {
        const auto [known, isNew] = _used.try_emplace(materialPath, &_displayColor);
        if (!isNew) {
            return known->second;
        }
        const auto found = _scene.materials.find(materialPath);
        if (found == _scene.materials.end()) {
            _warnings.Add(primPath, "its material " + materialPath +
                                        " does not exist; drawn with displayColor");
            return known->second;
        }
        CachedMaterial& cached = _cache[materialPath];
        known->second = &cached;
        if (cached.network != found->second) {
            missing.push_back(&*found);
            return &cached;
        }
        for (const AssetReference& asset : cached.images) {
            _images.Probe(asset); // counts as used
        }
        return &cached;
    };
    _firstEntry.reserve(prims.size() + 1);
    for (const auto* entry : prims) {
        const auto& [path, prim] = *entry;
        if (prim.geometry->primitives == PrimitiveKind::Splats) {
            _entries.push_back({&kSplats, &_splats});
        } else {
            const Entry own = {&prim.materialPath, use(path, prim.materialPath)};
            _entries.push_back(own);
            const std::vector<std::string>& ofSubsets = prim.subsetMaterialPaths;
            const std::size_t numSubsets = prim.geometry->subsets.size();
            for (std::size_t i = 0; i < std::max(ofSubsets.size(), numSubsets); ++i) {
                // A subset without a material of its own shows the prim's.
                const CachedMaterial* material =
                    i < ofSubsets.size() ? use(path, ofSubsets[i]) : nullptr;
                if (i < numSubsets) {
                    const bool hasOwn = material != nullptr && IsMaterial(_scene, ofSubsets[i]);
                    _entries.push_back(hasOwn ? Entry{&ofSubsets[i], material} : own);
                }
            }
        }
        _firstEntry.push_back(static_cast<std::uint32_t>(_entries.size()));
    }
    tbb::parallel_for(std::size_t{0}, missing.size(), [&](std::size_t i) {
        _cache.at(missing[i]->first) = CompileNetwork(missing[i]->first, missing[i]->second);
    });
    for (auto cached = _cache.begin(); cached != _cache.end();) {
        const bool isGone = _scene.materials.count(cached->first) == 0;
        cached = isGone ? _cache.erase(cached) : std::next(cached);
    }
}

CachedMaterial
MaterialCommit::CompileNetwork(const std::string& path,
                               const std::shared_ptr<const MaterialNetwork>& network) {
    CachedMaterial result;
    result.network = network;
    result.compiled = CompileMaterial(*network, path, Images(&result.images), _warnings);
    result.primvars = hds::PrimvarsOf(result.compiled);
    return result;
}

ImageQueries MaterialCommit::Images(std::vector<AssetReference>* asked) const {
    ImageQueries queries;
    queries.probe = [this, asked](const AssetReference& asset) {
        if (asked != nullptr) {
            asked->push_back(asset);
        }
        return _images.Probe(asset);
    };
    queries.findTiles = ImageLibrary::FindTiles;
    return queries;
}

std::uint32_t MaterialCommit::AddRecord(const shared::HdsMaterial& record) {
    const std::string bytes(reinterpret_cast<const char*>(&record), sizeof(record));
    const auto [found, isNew] =
        _indexByBytes.emplace(bytes, static_cast<std::uint32_t>(materials.size()));
    if (isNew) {
        materials.push_back(record);
    }
    return found->second;
}

namespace {

bool Refracts(const CompiledMaterial& material) {
    return (material.constants.lobes & HDS_LOBE_TRANSMISSION) != 0 &&
           (material.constants.flags & HDS_MATERIAL_THIN_WALLED) == 0;
}

/// Of the inside of a prim, if some is authored.
std::optional<float> PriorityOf(const GeometryPrim& prim, const CompiledMaterial& material) {
    const std::optional<float> ofPrim = DielectricPriority(prim.geometry->primvars);
    return ofPrim ? ofPrim : material.dielectricPriority;
}

} // namespace

bool MaterialCommit::MayBeFilled(std::size_t index, const GeometryPrim& prim) const {
    bool isFilled = false;
    ForEachEntry(index, [&](const Entry& entry) {
        const CompiledMaterial& material = entry.material->compiled;
        isFilled = isFilled || (material.constants.flags & HDS_MATERIAL_MEDIUM) != 0 ||
                   material.meshMedium || (Refracts(material) && PriorityOf(prim, material));
    });
    return isFilled;
}

/// What fills a prim: the volume of its material, or where that has a priority, what its refracting
/// surface encloses.
std::optional<shared::HdsMeshMedium> MaterialCommit::MediumOf(const std::string& path,
                                                              const GeometryPrim& prim,
                                                              const CompiledMaterial& material) {
    const bool refracts = Refracts(material);
    const std::optional<float> priority = PriorityOf(prim, material);
    if (!material.meshMedium && !(priority && refracts)) {
        return std::nullopt;
    }
    shared::HdsMeshMedium medium{};
    if (refracts) {
        medium = InteriorOf(material, path, _warnings);
    }
    if (material.meshMedium) {
        const float ior = refracts ? medium.ior : 1.0F;
        medium = *material.meshMedium;
        medium.ior = ior;
    }
    medium.priority = priority && std::isfinite(*priority) ? *priority : 0.0F;
    return medium;
}

/// Number of a medium that is to fill a prim; 0, with a warning: it cannot.
std::uint32_t MaterialCommit::AddMedium(const std::string& path, const GeometryPrim& prim,
                                        const shared::HdsMeshMedium& medium) {
    if (prim.geometry->primitives != PrimitiveKind::Faces) {
        _warnings.Add(path, "only meshes have an inside: the medium of its material is left out");
        return 0;
    }
    const std::string bytes(reinterpret_cast<const char*>(&medium), sizeof(medium));
    const auto found = _mediumByBytes.find(bytes);
    if (found == _mediumByBytes.end() && meshMedia.size() == HDS_MAX_MESH_MEDIA) {
        _warnings.Add(path, "more than " + std::to_string(HDS_MAX_MESH_MEDIA) +
                                " media of meshes: its own is left out");
        return 0;
    }
    if (found != _mediumByBytes.end()) {
        return found->second;
    }
    meshMedia.push_back(medium);
    return _mediumByBytes[bytes] = static_cast<std::uint32_t>(meshMedia.size());
}

/// First word of the program in `programs`.
std::uint32_t MaterialCommit::AddProgram(const std::vector<std::uint32_t>& words) {
    const auto [found, isNew] =
        _programByWords.emplace(words, static_cast<std::uint32_t>(programs.size()));
    if (isNew) {
        programs.insert(programs.end(), words.begin(), words.end());
        maxLookups = std::max(maxLookups, CountLookups(words));
    }
    return found->second;
}

std::vector<std::uint32_t> MaterialCommit::AddTextures(const std::vector<MaterialTexture>& added) {
    std::vector<std::uint32_t> indices;
    for (const MaterialTexture& texture : added) {
        const auto [found, isNew] = _textureByKey.emplace(
            MaterialTextureKey(texture), static_cast<std::uint32_t>(textures.size()));
        if (isNew) {
            textures.push_back(texture);
        }
        textures[found->second].channels |= texture.channels;
        indices.push_back(found->second);
    }
    return indices;
}

/// Of a mesh that is no light: as if the light asked its material.
MaterialSyncMode MaterialCommit::SyncModeOf(const GeometryPrim& prim,
                                            const std::string& materialPath) const {
    if (!prim.light) {
        return MaterialSyncMode::GlowTintsLight;
    }
    return HasSurface(_scene, materialPath) ? prim.light->materialSyncMode
                                            : MaterialSyncMode::NoMaterialResponse;
}

namespace {

bool KeepsRest(const std::vector<AttributeName>& attributes) {
    return std::any_of(attributes.begin(), attributes.end(),
                       [](const AttributeName& one) { return one.name == kMovedBy; });
}

/// Whether an amount depends on a primvar.
bool Displaces(const DisplacementInput& displacement, const std::string& primvar) {
    return displacement.primvar == primvar ||
           (displacement.network &&
            std::any_of(displacement.network->primvars.begin(),
                        displacement.network->primvars.end(), [&](const DisplacementPrimvar& one) {
                            return std::find(one.names.begin(), one.names.end(), primvar) !=
                                   one.names.end();
                        }));
}

} // namespace

void MaterialCommit::GetDisplacements(std::size_t index,
                                      std::vector<DisplacementInput>* displacements) const {
    displacements->clear();
    ForEachEntry(index, [&](const Entry& entry) {
        DisplacementInput& input =
            displacements->emplace_back(entry.material->compiled.displacement);
        if (auto& lookup = input.lookup) {
            lookup->image = _images.LoadHeights(lookup->texture, lookup->channel);
        }
        if (auto& network = input.network) {
            _images.LoadHeights(&*network);
        }
    });
}

std::vector<const std::set<std::string>*> MaterialCommit::PrimvarsOf(std::size_t index) const {
    std::vector<const std::set<std::string>*> names;
    ForEachEntry(index, [&](const Entry& entry) { names.push_back(&entry.material->primvars); });
    return names;
}

PrimMaterialInfo MaterialCommit::AddPrim(std::size_t index, const std::string& path,
                                         const GeometryPrim& prim, const PlannedGeometry& prepared,
                                         const std::vector<AttributeName>& ofInstances) {
    PrimMaterialInfo info;
    bool scattersBelow = false; // some surface of it says so itself
    info.materialBase = static_cast<std::uint32_t>(primMaterials.size());
    const bool hasSplats = prim.geometry->primitives == PrimitiveKind::Splats;
    ForEachEntry(index, [&](const Entry& entry) {
        const MaterialSyncMode syncMode = SyncModeOf(prim, *entry.path);
        const bool isBlack = syncMode == MaterialSyncMode::NoMaterialResponse;
        const CompiledMaterial& compiled = isBlack ? _black : entry.material->compiled;
        const bool isBumped = compiled.relief.value && KeepsRest(prepared.attributes);
        ResolvedMaterial resolved = ResolveMaterial(
            compiled, AddTextures(isBumped ? compiled.relief.textures : compiled.textures),
            prepared.attributes, hasSplats ? std::vector<AttributeName>() : ofInstances, path,
            _warnings);
        for (const AttributeName& one : ofInstances) {
            if (Displaces(compiled.displacement, one.name)) {
                _warnings.Add(path, "primvar " + one.name +
                                        " differs between instances and cannot displace them");
            }
        }
        shared::HdsMaterial& record = resolved.record;
        if (!resolved.program.empty()) {
            OffsetPositions(&resolved.program, HDS_SPACE_OBJECT,
                            {static_cast<float>(prepared.origin.x),
                             static_cast<float>(prepared.origin.y),
                             static_cast<float>(prepared.origin.z)});
            record.program = AddProgram(resolved.program);
        }
        record.flags |= prim.light ? HDS_MATERIAL_EMISSIVE : 0U;
        if (hasSplats) {
            record.flags |= SplatDegree(*prim.geometry).value_or(0) << HDS_MATERIAL_DEGREE_SHIFT;
        }
        if (const auto medium = MediumOf(path, prim, compiled)) {
            record.meshMedium = AddMedium(path, prim, *medium);
            // Shadow rays that come to it ask what it lets pass.
            record.flags |= record.meshMedium != 0 ? HDS_MATERIAL_CUTOUT : 0U;
            info.hasMedium = info.hasMedium || record.meshMedium != 0;
        }
        if (_glassShadows && (record.lobes & HDS_LOBE_TRANSMISSION) != 0 &&
            (record.flags & HDS_MATERIAL_THIN_WALLED) == 0) {
            record.flags |= HDS_MATERIAL_GLASS;
            info.isGlass = true;
        }
        lobes |= record.lobes;
        scattersBelow = scattersBelow || (record.flags & HDS_MATERIAL_MEDIUM) != 0;
        hasHair = hasHair || (record.flags & HDS_MATERIAL_HAIR) != 0;
        info.isHair = info.isHair || (record.flags & HDS_MATERIAL_HAIR) != 0;
        info.hasCutouts = info.hasCutouts || (record.flags & HDS_MATERIAL_CUTOUT) != 0;
        info.isEmissive = info.isEmissive || (record.flags & HDS_MATERIAL_EMISSIVE) != 0;
        primMaterials.push_back(AddRecord(record));
        info.entries.push_back({compiled.emission, syncMode});
    });
    hasMedia = hasMedia || scattersBelow;
    info.isFilled = info.hasMedium || scattersBelow;
    return info;
}

} // namespace hds
