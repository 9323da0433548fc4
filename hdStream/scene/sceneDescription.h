// SPDX-License-Identifier: Apache-2.0
// The scene as front ends hand it over: Hydra's prims without Hydra's types, keyed by prim path.
// Matrices are glm::dmat4 that act on column vectors; their memory equals GfMatrix4d's.
// Explained in docs/architecture.md.
#pragma once

#include "hdStream/geometry/geometryDescription.h"
#include "hdStream/scene/cameraLens.h"
#include "hdStream/scene/instanceTransforms.h"
#include "hdStream/shading/lightFilter.h"
#include "hdStream/shading/materialNetwork.h"
#include "hdStream/shading/volumeShader.h"
#include "hdStream/volume/voxelGrid.h"

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace hds {

/// While the shutter is open, in frames from the frame on.
struct Shutter {
    double open = 0.0;
    double close = 0.0;

    bool IsOpen() const { return close > open; }
    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(Shutter, open), HDS_FIELD(Shutter, close));
    }
};

/// A transform at a time, in frames from the frame on.
struct TransformSample {
    double time = 0.0;
    glm::dmat4 matrix{1.0};

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(TransformSample, time), HDS_FIELD(TransformSample, matrix));
    }
};

/// The transforms of all instances at a time.
struct InstanceSample {
    double time = 0.0;
    SharedSpan<double> transforms; ///< as InstanceTransforms::matrices

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(InstanceSample, time),
                         HDS_FIELD(InstanceSample, transforms).Rows(16));
    }
};

/// Common part of everything that is placed in space.
struct Placement {
    glm::dmat4 worldFromObject{1.0}; ///< below an instancer: prototype space from object
    std::string instancerPath;       ///< empty: not instanced
    /// Below an instancer: which of its instances place this prim, in the order of instanceId.
    /// -1 places nothing and counts in that order.
    SharedSpan<std::int32_t> instances;
    bool visible = true;
    /// worldFromObject around the frame, in ascending order of time; fewer than two: it is at rest.
    std::vector<TransformSample> samples;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(Placement, worldFromObject), HDS_FIELD(Placement, samples),
                         HDS_FIELD(Placement, instancerPath), HDS_FIELD(Placement, instances),
                         HDS_FIELD(Placement, visible));
    }
};

/// Which faces camera rays do not see (Hydra's cull styles). All other rays see every face.
enum class CullStyle {
    DontCare, ///< as the render's settings say
    Nothing,
    Back,
    Front,
    BackUnlessDoubleSided,
    FrontUnlessDoubleSided,
};

constexpr EnumTable<CullStyle, 6> NamesOf(CullStyle) {
    return {
        {{CullStyle::DontCare, "DontCare", "dontCare"},
         {CullStyle::Nothing, "Nothing", "nothing"},
         {CullStyle::Back, "Back", "back"},
         {CullStyle::Front, "Front", "front"},
         {CullStyle::BackUnlessDoubleSided, "BackUnlessDoubleSided", "backUnlessDoubleSided"},
         {CullStyle::FrontUnlessDoubleSided, "FrontUnlessDoubleSided", "frontUnlessDoubleSided"}}};
}

/// What a light is linked to.
struct LinkCategories {
    std::string lightLink;  ///< category of the prims that it lights; empty: all
    std::string shadowLink; ///< category of the prims that cast its shadows; empty: all

    static constexpr auto Fields() {
        constexpr auto kWhy = "front ends name categories as they like: who is unlit is dumped";
        return FieldList(HDS_FIELD(LinkCategories, lightLink).NotInDump(kWhy),
                         HDS_FIELD(LinkCategories, shadowLink).NotInDump(kWhy));
    }
};

/// What makes a mesh a light (UsdLuxMeshLightAPI); its type is Mesh.
struct MeshLight {
    LightDescription light;
    MaterialSyncMode materialSyncMode = MaterialSyncMode::GlowTintsLight;
    LinkCategories links;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(MeshLight, light), HDS_FIELD(MeshLight, materialSyncMode),
                         HDS_FIELD(MeshLight, links));
    }
};

/// A mesh, curves or points in the scene. Two prims with the same `geometry` pointer have the same
/// geometry, and so has a prim that is replaced by one with the same pointer: only a new pointer
/// makes commit prepare again.
struct GeometryPrim {
    Placement placement;
    std::string purpose = "default"; ///< default, render, proxy, guide
    std::shared_ptr<const GeometryDescription> geometry;
    std::set<std::string> categories; ///< what lights and shadows are linked to (LightPrim)
    bool doubleSided = false;
    CullStyle cullStyle = CullStyle::DontCare;
    std::string materialPath; ///< empty: no material bound, displayColor Lambert
    std::vector<std::string>
        subsetMaterialPaths;                ///< parallel to geometry->subsets; empty: the prim's
    std::shared_ptr<const MeshLight> light; ///< null: it is none
    int primId = -1;                        ///< the front end's id for the AOV; -1: order of path

    static constexpr auto Fields() {
        return FieldList(
            HDS_FIELD(GeometryPrim, placement), HDS_FIELD(GeometryPrim, purpose),
            HDS_FIELD(GeometryPrim, materialPath),
            HDS_FIELD(GeometryPrim, geometry).NotInPython("a constructor's argument"),
            HDS_FIELD(GeometryPrim, doubleSided), HDS_FIELD(GeometryPrim, cullStyle),
            HDS_FIELD(GeometryPrim, subsetMaterialPaths),
            HDS_FIELD(GeometryPrim, categories).NotInDump("see LinkCategories"),
            HDS_FIELD(GeometryPrim, light).NotInPython("SetLight"),
            HDS_FIELD(GeometryPrim, primId).NotInDump("front ends number prims as they like"));
    }
};

/// An instancer: places its prototypes (geometry, lights or instancers that name it as
/// instancerPath). worldFromPrototype(i) = parent instance * worldFromInstancer *
/// instanceTransforms[i].
struct InstancerPrim {
    Placement placement; ///< of the instancer itself (maybe below another instancer)
    InstanceTransforms instanceTransforms;
    std::vector<InstanceSample> samples; ///< of them, as Placement::samples
    /// Of each instance, added to those of what it places; empty: none.
    std::vector<std::set<std::string>> instanceCategories;
    /// With a value an instance: interpolation Instance, no indices. Prims that it places have them
    /// where they have none of that name themselves, and instancers further in have none either.
    std::vector<Primvar> primvars;

    static constexpr auto Fields() {
        return FieldList(
            HDS_FIELD(InstancerPrim, placement), HDS_FIELD(InstancerPrim, instanceTransforms),
            HDS_FIELD(InstancerPrim, samples), HDS_FIELD(InstancerPrim, primvars),
            HDS_FIELD(InstancerPrim, instanceCategories).NotInDump("see LinkCategories"));
    }
};

/// A light prim.
struct LightPrim {
    Placement placement;
    LightDescription light;
    /// In the order of time; before the first and after the last the light is as theirs. Empty: it
    /// is as above at all times.
    std::vector<LightSample> samples;
    LinkCategories links;
    std::vector<LightPortal> portals; ///< dome
    std::vector<LightFilter> filters; ///< placed as the light is

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(LightPrim, placement), HDS_FIELD(LightPrim, light),
                         HDS_FIELD(LightPrim, samples), HDS_FIELD(LightPrim, links),
                         HDS_FIELD(LightPrim, portals).NotInPython("AddPortal"),
                         HDS_FIELD(LightPrim, filters).NotInPython("AddFilter"));
    }
};

/// A field of a volume: a grid of a file, or one in memory.
struct VolumeField {
    AssetReference asset; ///< an OpenVDB file
    std::string gridName;
    int gridIndex = 0;                       ///< of those of that name
    std::shared_ptr<const VoxelGrid> voxels; ///< in place of a file

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(VolumeField, asset), HDS_FIELD(VolumeField, gridName),
                         HDS_FIELD(VolumeField, gridIndex),
                         HDS_FIELD(VolumeField, voxels).NotInDump("of the Python interface"));
    }
};

/// A volume in the scene.
struct VolumePrim {
    Placement placement;
    std::string purpose = "default";
    std::string materialPath;                  ///< whose terminal "volume" counts; empty: none
    std::optional<VolumeShading> shading;      ///< in place of a material
    std::map<std::string, VolumeField> fields; ///< by the names that materials know them by
    /// What velocities, which are by second, mean in frames; 0: nothing moves.
    double timeCodesPerSecond = 24.0;
    std::set<std::string> categories; ///< what lights are linked to (LightPrim)

    static constexpr auto Fields() {
        return FieldList(
            HDS_FIELD(VolumePrim, placement), HDS_FIELD(VolumePrim, purpose),
            HDS_FIELD(VolumePrim, timeCodesPerSecond).NotInDump("Hydra does not know it"),
            HDS_FIELD(VolumePrim, materialPath),
            HDS_FIELD(VolumePrim, shading).NotInDump("of the Python interface"),
            HDS_FIELD(VolumePrim, categories).NotInDump("see LinkCategories"),
            HDS_FIELD(VolumePrim, fields));
    }
};

/// A camera as HdCamera gives it: all lengths in scene units, as floats.
struct CameraPrim {
    glm::dmat4 worldFromCamera{1.0};
    bool orthographic = false;
    float horizontalAperture = 2.0955F;
    float verticalAperture = 1.52908F;
    float horizontalApertureOffset = 0.0F;
    float verticalApertureOffset = 0.0F;
    float focalLength = 5.0F;
    float nearClip = 1.0F;
    float farClip = 1000000.0F;
    float fStop = 0.0F;         ///< 0: pinhole
    float focusDistance = 0.0F; ///< 0: pinhole
    float exposureScale = 1.0F; ///< linear factor on radiance: 2^exposure and photographic terms
    /// Half-spaces that camera rays see, dot(plane, (x, y, z, 1)) >= 0 in camera space.
    std::vector<glm::dvec4> clippingPlanes;
    Shutter shutter;
    std::vector<TransformSample> samples; ///< of worldFromCamera, as Placement::samples
    CameraLens lens;
    /// In the order of time; before the first and after the last the lens is theirs. Empty: it has
    /// the values above at all times.
    std::vector<LensSample> lensSamples;

    /// In the order of the dump.
    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(CameraPrim, worldFromCamera), HDS_FIELD(CameraPrim, samples),
                         HDS_FIELD(CameraPrim, orthographic),
                         HDS_FIELD(CameraPrim, horizontalAperture),
                         HDS_FIELD(CameraPrim, verticalAperture),
                         HDS_FIELD(CameraPrim, horizontalApertureOffset),
                         HDS_FIELD(CameraPrim, verticalApertureOffset),
                         HDS_FIELD(CameraPrim, focalLength), HDS_FIELD(CameraPrim, nearClip),
                         HDS_FIELD(CameraPrim, farClip), HDS_FIELD(CameraPrim, fStop),
                         HDS_FIELD(CameraPrim, focusDistance), HDS_FIELD(CameraPrim, exposureScale),
                         HDS_FIELD(CameraPrim, shutter), HDS_FIELD(CameraPrim, clippingPlanes),
                         HDS_FIELD(CameraPrim, lens), HDS_FIELD(CameraPrim, lensSamples));
    }
};

/// Everything, by prim path. std::map keeps the order of paths, which is the order of identity.
struct SceneDescription {
    std::map<std::string, GeometryPrim> geometry;
    std::map<std::string, InstancerPrim> instancers;
    std::map<std::string, LightPrim> lights;
    std::map<std::string, std::shared_ptr<const MaterialNetwork>> materials;
    std::map<std::string, CameraPrim> cameras;
    std::map<std::string, VolumePrim> volumes;
};

/// Karma's primvar of who sees a prim, an expression; front ends hand it over as a number.
constexpr const char* kKarmaVisibility = "karma:object:rendervisibility";

/// The number for an expression: names of rays (primary, shadow, diffuse, reflect, refract, * for
/// all), `-` for all but these, joined by `&` and `|`; empty: none. -1 when it cannot be read.
float KarmaVisibilityNumber(const std::string& expression);

/// Whether a primvar of that name says something of a whole prim (widths, normals, priorities; not
/// who sees it). Instances that differ in it need prims of their own: no InstancerPrim has it.
bool IsReadByPrim(const std::string& primvar);

/// Whether there is such a material and it has a terminal.
inline bool HasTerminal(const SceneDescription& scene, const std::string& materialPath,
                        const char* terminal) {
    const auto found = scene.materials.find(materialPath);
    return found != scene.materials.end() && found->second->terminals.count(terminal) > 0;
}

inline bool HasSurface(const SceneDescription& scene, const std::string& materialPath) {
    return HasTerminal(scene, materialPath, "surface");
}

inline bool HasVolume(const SceneDescription& scene, const std::string& materialPath) {
    return HasTerminal(scene, materialPath, "volume");
}

/// True when there is such a material and it has a surface or a volume: binding any other is
/// binding none.
inline bool IsMaterial(const SceneDescription& scene, const std::string& materialPath) {
    return HasSurface(scene, materialPath) || HasVolume(scene, materialPath);
}

} // namespace hds
