// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/materialCommit.h"

#include <tbb/parallel_for.h>

namespace hds {

void MaterialCommit::Compile(
    const std::vector<const std::pair<const std::string, MeshPrim>*>& prims) {
    _compiled[""] = DisplayColorMaterial();
    std::vector<const std::pair<const std::string, std::shared_ptr<const MaterialNetwork>>*>
        networks;
    const auto use = [&](const std::string& primPath, const std::string& materialPath) {
        if (materialPath.empty() || _compiled.count(materialPath) > 0) {
            return;
        }
        _compiled[materialPath] = DisplayColorMaterial();
        const auto found = _scene.materials.find(materialPath);
        if (found == _scene.materials.end()) {
            _warnings.Add(primPath, "its material " + materialPath +
                                        " does not exist; drawn with displayColor");
            return;
        }
        networks.push_back(&*found);
    };
    for (const auto* prim : prims) {
        use(prim->first, prim->second.materialPath);
        for (const std::string& materialPath : prim->second.subsetMaterialPaths) {
            use(prim->first, materialPath);
        }
    }
    const MeanColorCallback meanColor = [this](const AssetReference& asset,
                                               const std::string& colorSpace) {
        return _images.MeanOf(asset, colorSpace);
    };
    std::vector<CompiledMaterial> results(networks.size());
    tbb::parallel_for(std::size_t{0}, networks.size(), [&](std::size_t i) {
        results[i] =
            CompileMaterial(*networks[i]->second, networks[i]->first, meanColor, _warnings);
    });
    for (std::size_t i = 0; i < networks.size(); ++i) {
        _compiled[networks[i]->first] = std::move(results[i]);
    }
}

const CompiledMaterial& MaterialCommit::Find(const std::string& materialPath) const {
    return _compiled.at(materialPath);
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

MeshMaterialInfo MaterialCommit::AddMesh(const std::string& path, const MeshPrim& prim,
                                         const PreparedMesh& prepared) {
    MeshMaterialInfo info;
    info.materialBase = static_cast<std::uint32_t>(meshMaterials.size());
    const auto add = [&](const std::string& materialPath) {
        const shared::HdsMaterial record =
            ResolveMaterial(Find(materialPath), prepared.attributes, path, _warnings);
        info.hasCutouts = info.hasCutouts || (record.flags & HDS_MATERIAL_CUTOUT) != 0;
        info.isEmissive = info.isEmissive || (record.flags & HDS_MATERIAL_EMISSIVE) != 0;
        meshMaterials.push_back(AddRecord(record));
        ++info.numEntries;
    };
    add(prim.materialPath);
    for (std::size_t i = 0; i < prim.mesh->subsets.size(); ++i) {
        // A subset without a material of its own shows the prim's.
        const bool hasOwn = i < prim.subsetMaterialPaths.size() &&
                            _scene.materials.count(prim.subsetMaterialPaths[i]) > 0;
        add(hasOwn ? prim.subsetMaterialPaths[i] : prim.materialPath);
    }
    return info;
}

} // namespace hds
