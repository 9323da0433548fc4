// SPDX-License-Identifier: Apache-2.0
// Brings all colours of a scene into the working space before anything else looks at them, so that
// nothing behind it knows of colour spaces. Explained in docs/color.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/scene/sceneDescription.h"

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace hds {

/// Keeps what it has converted, so that what did not change keeps its identity from commit to
/// commit. Externally synchronised.
class SceneColors {
public:
    /// The scene with the colours of materials, primvars, lights and filters in the working space,
    /// and with images that say what they are to be converted from and to; the scene itself where
    /// nothing is to be converted. Colours that name no space are taken to be linear Rec.709, which
    /// is USD's fallback, where there is a working space, else to be in the working space.
    /// \param workingSpace empty: the configuration's scene_linear role
    /// \return valid until the next call and as long as `scene`
    const SceneDescription& Convert(const SceneDescription& scene, const std::string& workingSpace,
                                    Warnings& warnings);

private:
    template <typename T>
    using Copies = std::map<std::shared_ptr<const T>, std::shared_ptr<const T>>;
    class Pass;

    std::string _key; ///< all that conversions depend on
    SceneDescription _converted;
    Copies<GeometryDescription> _geometry;
    Copies<MaterialNetwork> _materials;
    Copies<MeshLight> _meshLights;
};

/// Rows of the matrix from linear Rec.709 to a working space; nothing: they are the same.
std::optional<std::array<float, 9>> WorkingFromRec709(const std::string& workingSpace);

} // namespace hds
