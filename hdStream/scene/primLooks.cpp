// SPDX-License-Identifier: Apache-2.0
// Of PrimCommit what mends the tables of a scene where materials and lights get other numbers.
#include "hdStream/scene/primCommit.h"
#include "hdStream/shading/materialPrimvars.h"

#include <algorithm>
#include <cstring>

namespace hds {

namespace {

/// Whether a material is made of numbers alone: then its record is the same for all prims, but for
/// flags.
bool IsPlain(const CachedMaterial& material) {
    const CompiledMaterial& compiled = material.compiled;
    return std::none_of(compiled.values.begin(), compiled.values.end(),
                        [](const ShaderValue& value) { return bool(value); }) &&
           !compiled.relief.value && compiled.displacement == DisplacementInput() &&
           !compiled.meshMedium && !compiled.dielectricPriority && material.images.empty() &&
           material.primvars.empty();
}

/// What of a record other tables, or kernels, are made by.
bool HaveSameKind(const shared::HdsMaterial& a, const shared::HdsMaterial& b) {
    return a.flags == b.flags && a.lobes == b.lobes &&
           (a.flags & (HDS_MATERIAL_EMISSIVE | HDS_MATERIAL_MEDIUM)) == 0;
}

/// A record of `before` becomes one of `after`. \return false where other words than flags are not
/// those of the material.
bool Repaint(const shared::HdsMaterial& before, const shared::HdsMaterial& after,
             shared::HdsMaterial* record) {
    const std::uint32_t flags = record->flags;
    shared::HdsMaterial expected = before;
    expected.flags = flags;
    if (std::memcmp(record, &expected, sizeof(expected)) != 0 ||
        (flags & HDS_MATERIAL_EMISSIVE) != 0) { // of a mesh that is a light
        return false;
    }
    *record = after;
    record->flags = flags;
    return true;
}

} // namespace

LightCommitInput PrimCommit::LightInput(const glm::dvec3& centre) const {
    LightCommitInput input;
    input.scene = &_scene;
    input.centre = centre;
    input.domeVisible = _options.domeVisible;
    input.lightsVisible = _options.lightsVisible;
    input.primInfos = &primInfos;
    input.materials = &materials;
    input.worldInstances = &worldInstances;
    input.links = &links;
    input.shutter = _options.shutter;
    return input;
}

/// The light table, where meshes that glow are the lights of it that they were.
bool PrimCommit::MendLights(CommittedScene* scene, PlaceChanges* changes) {
    const CommittedLights lights = CommitLights(LightInput(scene->centre), &_cache, _warnings);
    const LightTable& before = *scene->lights;
    const LightTable& after = *_cache.lights;
    if (lights.lightByEntry != scene->lightByEntry || after.numImages != before.numImages ||
        after.hasMotion != before.hasMotion ||
        after.hasTexturedEmission != before.hasTexturedEmission) {
        return false;
    }
    scene->lights = _cache.lights;
    changes->areLights = true;
    return true;
}

void PrimCommit::FindRecords() {
    if (_records) {
        return;
    }
    _records.emplace().numUsers.resize(materials.materials.size());
    std::size_t at = 0;
    for (std::size_t prim = 0; prim < _drawn.size(); ++prim) {
        materials.ForEachEntry(prim, [&](const MaterialCommit::Entry& entry) {
            const std::uint32_t record = materials.primMaterials[at++];
            const bool isNew = _records->ofMaterial[entry.material].insert(record).second;
            _records->numUsers[record] += isNew ? 1 : 0;
        });
    }
}

/// \return the records that have changed; nothing: all has to be made anew.
std::optional<std::set<std::uint32_t>> PrimCommit::RecolourOne(const std::string& path) {
    const auto known = _cache.materials.find(path);
    if (known == _cache.materials.end()) {
        return std::set<std::uint32_t>(); // nothing that is drawn has it
    }
    CachedMaterial& cached = known->second;
    FindRecords();
    const auto users = _records->ofMaterial.find(&cached);
    if (users == _records->ofMaterial.end()) {
        return std::set<std::uint32_t>(); // likewise: who draws it next finds another network
    }
    if (!IsPlain(cached)) {
        return std::nullopt;
    }
    CachedMaterial next;
    next.network = _scene.materials.at(path);
    next.compiled = CompileMaterial(*next.network, path, materials.Images(&next.images), _warnings);
    next.primvars = PrimvarsOf(next.compiled);
    const auto recordOf = [&](const CachedMaterial& material) {
        return ResolveMaterial(material.compiled, {}, {}, {}, path, _warnings).record;
    };
    if (!IsPlain(next)) {
        return std::nullopt;
    }
    const shared::HdsMaterial before = recordOf(cached);
    const shared::HdsMaterial after = recordOf(next);
    if (!HaveSameKind(before, after)) {
        return std::nullopt;
    }
    const std::set<std::uint32_t>& records = users->second;
    for (const std::uint32_t record : records) {
        if (_records->numUsers[record] > 1 ||
            !Repaint(before, after, &materials.materials[record])) {
            return std::nullopt;
        }
    }
    cached = std::move(next);
    return records;
}

bool PrimCommit::Recolour(CommittedScene* scene, PlaceChanges* changes) {
    if (!recoloured.empty() && !_scene.volumes.empty()) {
        return false; // their terms are made of their materials
    }
    for (const std::string& path : recoloured) {
        const auto records = RecolourOne(path);
        if (!records) {
            return false;
        }
        for (const std::uint32_t record : *records) {
            if (scene != nullptr) {
                scene->materials[record] = materials.materials[record];
                changes->materials.push_back(record);
            }
        }
    }
    recoloured.clear();
    return true;
}

} // namespace hds
