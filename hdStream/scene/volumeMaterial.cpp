// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/volumeMaterial.h"

#include <algorithm>
#include <utility>

namespace hds {

namespace {

VolumeMaterial ReadMaterial(const SceneDescription& scene, const std::string& path,
                            const VolumePrim& prim, MaterialCommit* materials, Warnings& warnings) {
    VolumeMaterial result;
    if (prim.shading) {
        result.shading = *prim.shading;
        return result;
    }
    const auto material = scene.materials.find(prim.materialPath);
    if (material == scene.materials.end() || material->second->terminals.count("volume") == 0) {
        result.shading = DefaultVolumeShading();
        return result;
    }
    const ImageQueries images = materials->Images(nullptr);
    VolumePatterns patterns(*material->second, prim.materialPath, images, warnings);
    result.shading = ReadVolumeShading(*material->second, &patterns, [&](const std::string& text) {
        warnings.Add(path, prim.materialPath + ": " + text);
    });
    result.patterns = patterns.Values();
    result.textures = patterns.Textures();
    result.textureIndices = materials->AddTextures(result.textures);
    return result;
}

} // namespace

VolumeMaterials ReadVolumeMaterials(const SceneDescription& scene,
                                    const std::vector<std::string>& purposes,
                                    const std::function<bool(const std::string&)>& isDrawn,
                                    MaterialCommit* materials, Warnings& warnings) {
    VolumeMaterials result;
    for (const auto& [path, prim] : scene.volumes) {
        const bool hasPurpose =
            std::find(purposes.begin(), purposes.end(), prim.purpose) != purposes.end();
        if (hasPurpose && prim.placement.visible && isDrawn(path)) {
            result[path] = ReadMaterial(scene, path, prim, materials, warnings);
        }
    }
    return result;
}

} // namespace hds
