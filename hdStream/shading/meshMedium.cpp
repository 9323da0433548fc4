// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/meshMedium.h"

#include "hdStream/shading/volumeShader.h"
#include "kernels/shared/material.h"

#include <algorithm>
#include <set>

namespace hds {

namespace {

/// So that products stay finite, as HDS_MEDIUM_MAX_EXTINCTION of kernels/shading/medium.clh.
constexpr float kMaxCoefficient = 1e8F;

std::uint32_t KindOf(const shared::HdsMeshMedium& medium) {
    const auto isAny = [](const float(&values)[3]) {
        return std::any_of(values, values + 3, [](float value) { return value > 0.0F; });
    };
    if (isAny(medium.albedo)) {
        return HDS_MEDIUM_SCATTERS;
    }
    return isAny(medium.extinction) || isAny(medium.emission) ? HDS_MEDIUM_ABSORBS
                                                              : HDS_MEDIUM_NONE;
}

} // namespace

std::optional<shared::HdsMeshMedium> ReadMeshMedium(const MaterialNetwork& network,
                                                    const std::string& materialPath,
                                                    Warnings& warnings) {
    if (network.terminals.count("volume") == 0) {
        return std::nullopt;
    }
    const VolumeShading shading = ReadVolumeShading(
        network, nullptr, [&](const std::string& text) { warnings.Add(materialPath, text); });
    if (!IsFinite(shading)) {
        warnings.Add(materialPath, "volume that makes no sense: left out");
        return std::nullopt;
    }
    std::set<std::string> fields;
    if (shading.terms.empty()) {
        fields.insert(shading.density);
        fields.insert(shading.emission != glm::vec3(0.0F) ? shading.emissionField : "");
    }
    for (const VolumeTerm& term : shading.terms) {
        fields.insert(term.fields.begin(), term.fields.end());
    }
    for (const std::string& field : fields) {
        if (!field.empty() && field != DefaultVolumeShading().density) {
            warnings.Add(materialPath,
                         "its volume follows the field " + field + ", which counts as 1 in a mesh");
        }
    }
    return MakeMeshMedium(shading.absorption, shading.scattering, shading.anisotropy,
                          shading.emission);
}

shared::HdsMeshMedium MakeMeshMedium(const glm::vec3& absorption, const glm::vec3& scattering,
                                     float asymmetry, const glm::vec3& emission) {
    shared::HdsMeshMedium medium{};
    for (int i = 0; i < 3; ++i) {
        const float scattered = std::min(scattering[i], kMaxCoefficient);
        medium.extinction[i] = std::min(absorption[i], kMaxCoefficient) + scattered;
        medium.albedo[i] = scattered > 0.0F ? scattered / medium.extinction[i] : 0.0F;
        medium.emission[i] = std::min(emission[i], kMaxCoefficient);
    }
    medium.asymmetry = std::clamp(asymmetry, -0.98F, 0.98F);
    medium.kind = KindOf(medium);
    medium.ior = 1.0F;
    return medium;
}

} // namespace hds
