// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/materialCommit.h"

#include <tbb/parallel_for.h>

namespace hds {

void MaterialCommit::Compile(
    const std::vector<const std::pair<const std::string, MeshPrim>*>& prims) {
    _compiled[""] = DisplayColorMaterial();
    std::vector<const std::pair<const std::string, MaterialNetwork>*> networks;
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
        for (const MeshSubset& subset : prim->second.mesh.subsets) {
            use(prim->first, subset.materialPath);
        }
    }
    const MeanColorCallback meanColor = [this](const AssetReference& asset,
                                               const std::string& colorSpace) {
        return _images.MeanOf(asset, colorSpace);
    };
    std::vector<CompiledMaterial> results(networks.size());
    tbb::parallel_for(std::size_t{0}, networks.size(), [&](std::size_t i) {
        results[i] = CompileMaterial(networks[i]->second, networks[i]->first, meanColor, _warnings);
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
                                         const TriangleMesh& triangles) {
    std::vector<AttributeName> names;
    for (const MeshAttribute& attribute : triangles.attributes) {
        names.push_back({attribute.name, attribute.numComponents});
    }
    MeshMaterialInfo info;
    info.materialBase = static_cast<std::uint32_t>(meshMaterials.size());
    const auto add = [&](const std::string& materialPath) {
        const shared::HdsMaterial record =
            ResolveMaterial(Find(materialPath), names, path, _warnings);
        info.hasCutouts = info.hasCutouts || (record.flags & HDS_MATERIAL_CUTOUT) != 0;
        info.isEmissive = info.isEmissive || (record.flags & HDS_MATERIAL_EMISSIVE) != 0;
        meshMaterials.push_back(AddRecord(record));
        ++info.numEntries;
    };
    add(prim.materialPath);
    for (const MeshSubset& subset : prim.mesh.subsets) {
        // A subset without a material of its own shows the prim's.
        add(subset.materialPath.empty() ? prim.materialPath : subset.materialPath);
    }
    return info;
}

} // namespace hds
