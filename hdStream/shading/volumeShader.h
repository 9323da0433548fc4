// SPDX-License-Identifier: Apache-2.0
// What the volume terminal of a material says of light. Explained in docs/volumes.md.
#pragma once

#include "hdStream/base/fields.h"
#include "hdStream/shading/materialNetwork.h"
#include "hdStream/shading/volumePatterns.h"

#include <glm/vec3.hpp>

#include <functional>
#include <string>
#include <vector>

namespace hds {

/// A product of fields, and what each coefficient has of it, a unit of length of world space.
struct VolumeTerm {
    /// Names of fields and patterns (PatternName); one that is squared is there twice; may be
    /// empty.
    std::vector<std::string> fields;
    glm::vec3 absorption{0.0F}; ///< may be below 0, as the others
    glm::vec3 scattering{0.0F};
    glm::vec3 emission{0.0F};
    /// Scattering times mean cosine; where VolumeShading::turnsVary.
    glm::vec3 turned{0.0F};

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(VolumeTerm, fields), HDS_FIELD(VolumeTerm, absorption),
                         HDS_FIELD(VolumeTerm, scattering), HDS_FIELD(VolumeTerm, emission),
                         HDS_FIELD(VolumeTerm, turned));
    }
};

/// Coefficients of a volume, each times a field. Lengths are those of world space.
struct VolumeShading {
    glm::vec3 absorption{0.0F}; ///< a unit of length at a density of 1
    glm::vec3 scattering{0.0F};
    float anisotropy = 0.0F;      ///< mean cosine
    glm::vec3 emission{0.0F};     ///< a unit of length at an emission of 1
    glm::vec3 blackbody{0.0F};    ///< factor on sigma T^4 / pi in megawatts, a unit of length
    float kelvin = 1.0F;          ///< at a temperature of 1
    std::string density;          ///< name of the field
    std::string emissionField;    ///< empty: the density
    std::string temperatureField; ///< empty: no black body
    /// Where coefficients are more than a colour times a field: their sums. Then absorption,
    /// scattering and emission are what these are where all fields are 1.
    std::vector<VolumeTerm> terms;
    bool turnsVary = false; ///< the mean cosine is what the terms say, by scattering

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(VolumeShading, absorption), HDS_FIELD(VolumeShading, scattering),
                         HDS_FIELD(VolumeShading, anisotropy), HDS_FIELD(VolumeShading, emission),
                         HDS_FIELD(VolumeShading, blackbody), HDS_FIELD(VolumeShading, kelvin),
                         HDS_FIELD(VolumeShading, density), HDS_FIELD(VolumeShading, emissionField),
                         HDS_FIELD(VolumeShading, temperatureField),
                         HDS_FIELD(VolumeShading, terms), HDS_FIELD(VolumeShading, turnsVary));
    }
};

/// Grey smoke, which volumes without a material of their own are: what Blender's default is.
VolumeShading DefaultVolumeShading();

/// Whether all of it is finite, and nothing that counts light is below 0.
bool IsFinite(const VolumeShading& shading);

/// \pre the network has a terminal "volume". Nodes that are not known count as their inputs'
/// fallbacks. \param patterns gets what is more than sums and products; null: such nodes are not
/// known. \param warn gets one line for each problem.
VolumeShading ReadVolumeShading(const MaterialNetwork& network, VolumePatterns* patterns,
                                const std::function<void(const std::string&)>& warn);

} // namespace hds
