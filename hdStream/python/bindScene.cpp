// SPDX-License-Identifier: Apache-2.0
#include "hdStream/python/bindFields.h"
#include "hdStream/python/bindings.h"

#include <nanobind/stl/optional.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace nb = nanobind;
using namespace nb::literals;

namespace hds::python {

namespace {

/// A grid that volumes share.
struct GridInMemory {
    std::shared_ptr<const VoxelGrid> voxels;
};

void BindPrimvar(nb::module_& module) {
    BindEnum<Interpolation>(module, "Interpolation", "How values go with a prim's parts.");

    nb::class_<Primvar> primvar(module, "Primvar", "A named array of values on a prim.");
    primvar.def(
        "__init__",
        [](Primvar* self, const std::string& name, Interpolation interpolation, nb::handle values,
           nb::handle indices, const std::string& colorSpace) {
            auto [span, numComponents] = SpanFromBuffer<float>(values, name.c_str());
            if (numComponents < 1 || numComponents > 4) {
                throw nb::value_error("a primvar has 1 to 4 components");
            }
            SharedSpan<std::int32_t> indexSpan;
            if (!indices.is_none()) {
                indexSpan = SpanFromBuffer<std::int32_t>(indices, name.c_str()).first;
            }
            new (self) Primvar{name,
                               interpolation,
                               static_cast<std::uint32_t>(numComponents),
                               std::move(span),
                               std::move(indexSpan),
                               colorSpace};
        },
        "name"_a, "interpolation"_a, "values"_a, "indices"_a = nb::none(), "colorSpace"_a = "",
        "`values` is a float32 array [count] or [count][components].");
    BindFields<FieldAccess::ReadOnly>(primvar);
    primvar.def_prop_ro("values", [](const Primvar& self) {
        return ArrayFromSpan(self.values, self.numComponents);
    });
}

void BindGeometry(nb::module_& module) {
    BindStruct<MeshSubset>(module, "MeshSubset", "A face set.");
    BindStruct<SubdivTags>(module, "SubdivTags", "OpenSubdiv tags as authored.");
    BindEnum<PrimitiveKind>(module, "PrimitiveKind", "What a description is made of.");
    BindStruct<CurveForm>(module, "CurveForm", "How points become curves.");
    BindStruct<SplatSamples>(module, "SplatSamples", "Shapes of Gaussian splats around the frame.");
    BindStruct<GeometryDescription>(module, "GeometryDescription",
                                    "A mesh, curves or points as authored.");

    nb::class_<ImplicitShape>(module, "ImplicitShape", "Size of an implicit gprim.")
        .def(nb::init<>())
        .def_rw("type", &ImplicitShape::type)
        .def_rw("axis", &ImplicitShape::axis)
        .def_rw("size", &ImplicitShape::size)
        .def_rw("radius", &ImplicitShape::radius)
        .def_rw("radiusTop", &ImplicitShape::radiusTop, nb::arg().none())
        .def_rw("height", &ImplicitShape::height)
        .def_rw("width", &ImplicitShape::width)
        .def_rw("length", &ImplicitShape::length);
    module.attr("KARMA_VISIBILITY") = kKarmaVisibility;
    module.def("KarmaVisibilityNumber", &KarmaVisibilityNumber, "expression"_a,
               "The number that the primvar of that name has for an expression.");
    module.def("SaysRayVisibility", &SaysRayVisibility, "primvar"_a,
               "Whether a primvar says which rays see a prim, by its name.");
    module.def("IsReadByPrim", &IsReadByPrim, "primvar"_a,
               "Whether a primvar of that name says something of a whole prim, so that instances "
               "that differ in it need prims of their own.");
    module.def(
        "CarryNormals",
        [](const Primvar& normals, const GeometryDescription& mesh, nb::handle atRest,
           nb::handle posed) {
            return CarryNormals(normals, mesh, SpanFromBuffer<float>(atRest, "atRest").first,
                                SpanFromBuffer<float>(posed, "posed").first);
        },
        "normals"_a, "mesh"_a, "atRest"_a, "posed"_a,
        "The primvar `normals` of a mesh whose points, float32 [count][3], went from one pose to "
        "another; None where it does not fit the faces of `mesh`.");
    module.def("MakeImplicitMesh", &MakeImplicitMesh, "shape"_a,
               "OpenUSD's mesh of an implicit gprim, whose points lie on the gprim.");
    module.def(
        "FitLimitSurface", &FitLimitSurface, "cage"_a,
        "Moves the points of a catmullClark cage so that its limit surface goes through where "
        "they were.");
}

void BindPlaced(nb::module_& module) {
    nb::class_<Placement> placement(module, "Placement",
                                    "Where a prim is and whether it is drawn.");
    placement.def(
        "__init__",
        [](Placement* self, nb::handle worldFromObject, const std::string& instancerPath,
           nb::handle instances, bool visible) {
            SharedSpan<std::int32_t> span;
            if (!instances.is_none()) {
                span = SpanFromBuffer<std::int32_t>(instances, "instances").first;
            }
            new (self) Placement{MatrixFromBuffer(worldFromObject, "worldFromObject"),
                                 instancerPath,
                                 std::move(span),
                                 visible,
                                 {}};
        },
        "worldFromObject"_a, "instancerPath"_a = "", "instances"_a = nb::none(), "visible"_a = true,
        "`instances` (int32): which instances of the instancer place the prim.");
    BindFields(placement);

    BindEnum<CullStyle>(module, "CullStyle", "Which faces camera rays do not see.");
    nb::class_<GeometryPrim> geometryPrim(module, "GeometryPrim",
                                          "A mesh, curves or points in the scene.");
    geometryPrim
        .def(
            "__init__",
            [](GeometryPrim* self, const GeometryDescription& geometry, const Placement& where,
               const std::string& purpose, const std::string& materialPath) {
                new (self) GeometryPrim;
                self->placement = where;
                self->purpose = purpose;
                self->geometry =
                    std::make_shared<const GeometryDescription>(geometry); // shares the arrays
                self->materialPath = materialPath;
            },
            "geometry"_a, "placement"_a, "purpose"_a = "default", "materialPath"_a = "")
        .def_prop_ro(
            "geometry",
            [](const GeometryPrim& self) -> const GeometryDescription& { return *self.geometry; },
            nb::rv_policy::reference_internal)
        .def(
            "SetLight",
            [](GeometryPrim& self, const LightDescription& light, MaterialSyncMode mode,
               const LinkCategories& links) {
                self.light = std::make_shared<const MeshLight>(MeshLight{light, mode, links});
            },
            "light"_a, "materialSyncMode"_a, "links"_a, "Makes the mesh a light.")
        .def("RemoveLight", [](GeometryPrim& self) { self.light = nullptr; })
        .def(
            "WithConstants",
            [](const GeometryPrim& self, const std::vector<Primvar>& constants,
               nb::handle instances) {
                GeometryPrim split = self; // whatever it has
                auto geometry = std::make_shared<GeometryDescription>(*self.geometry);
                geometry->primvars.insert(geometry->primvars.end(), constants.begin(),
                                          constants.end());
                split.geometry = std::move(geometry);
                split.placement.instances =
                    SpanFromBuffer<std::int32_t>(instances, "instances").first;
                return split;
            },
            "constants"_a, "instances"_a,
            "The prim with these primvars too, placed by these instances; it shares all arrays.");
    BindFields(geometryPrim);

    nb::class_<GridInMemory>(module, "VoxelGrid", "Voxels of a box, as floats.")
        .def(
            "__init__",
            [](GridInMemory* self, nb::handle values, std::array<int, 3> size,
               std::array<int, 3> first, nb::handle objectFromIndex) {
                const auto span = SpanFromBuffer<float>(values, "values").first;
                const glm::dvec3 count(size[0], size[1], size[2]);
                if (count.x * count.y * count.z != static_cast<double>(span.size())) {
                    throw nb::value_error("values are not as many as the size says");
                }
                new (self) GridInMemory{std::make_shared<const VoxelGrid>(MakeVoxelGrid(
                    span.data(), {first[0], first[1], first[2]}, {size[0], size[1], size[2]},
                    MatrixFromBuffer(objectFromIndex, "objectFromIndex")))};
            },
            "values"_a, "size"_a, "first"_a, "objectFromIndex"_a,
            "values: float32 [size z][size y][size x]; first: the least voxel; "
            "objectFromIndex: 16 doubles in Gf's memory order.");
    nb::class_<VolumePrim>(module, "VolumePrim", "A volume in the scene.")
        .def(
            "__init__",
            [](VolumePrim* self, const Placement& placed, const std::string& purpose,
               const std::string& materialPath) {
                new (self) VolumePrim;
                self->placement = placed;
                self->purpose = purpose;
                self->materialPath = materialPath;
            },
            "placement"_a, "purpose"_a = "default", "materialPath"_a = "")
        .def_ro("materialPath", &VolumePrim::materialPath)
        .def(
            "SetTimeCodesPerSecond",
            [](VolumePrim& self, double rate) { self.timeCodesPerSecond = rate; }, "rate"_a,
            "What a velocity, which is by second, means in frames.")
        .def(
            "SetMaterialPath",
            [](VolumePrim& self, const std::string& path) { self.materialPath = path; }, "path"_a)
        .def(
            "SetShading",
            [](VolumePrim& self, std::array<float, 3> absorption, std::array<float, 3> scattering,
               float anisotropy, std::array<float, 3> emission, std::array<float, 3> blackbody,
               float kelvin, const std::string& density, const std::string& emissionField,
               const std::string& temperatureField) {
                const auto vector = [](const std::array<float, 3>& v) {
                    return glm::vec3(v[0], v[1], v[2]);
                };
                self.shading = VolumeShading{vector(absorption),
                                             vector(scattering),
                                             anisotropy,
                                             vector(emission),
                                             vector(blackbody),
                                             kelvin,
                                             density,
                                             emissionField,
                                             temperatureField,
                                             {},
                                             false};
            },
            "absorption"_a, "scattering"_a, "anisotropy"_a, "emission"_a, "blackbody"_a, "kelvin"_a,
            "density"_a, "emissionField"_a, "temperatureField"_a, "In place of a material.")
        .def(
            "AddTerm",
            [](VolumePrim& self, const std::vector<std::string>& fields,
               std::array<float, 3> absorption, std::array<float, 3> scattering,
               std::array<float, 3> emission) {
                const auto vector = [](const std::array<float, 3>& v) {
                    return glm::vec3(v[0], v[1], v[2]);
                };
                if (!self.shading) {
                    self.shading = VolumeShading();
                }
                self.shading->terms.push_back(
                    {fields, vector(absorption), vector(scattering), vector(emission), {}});
            },
            "fields"_a, "absorption"_a, "scattering"_a, "emission"_a,
            "A product of fields, by name, and what each coefficient has of it, a unit of length "
            "of world space: in place of the coefficients of SetShading.")
        .def(
            "SetGrid",
            [](VolumePrim& self, const std::string& name, const GridInMemory& grid) {
                self.fields[name].voxels = grid.voxels;
            },
            "name"_a, "grid"_a, "A field in memory.")
        .def(
            "SetFile",
            [](VolumePrim& self, const std::string& name, const AssetReference& asset,
               const std::string& gridName, int gridIndex) {
                self.fields[name] = VolumeField{asset, gridName, gridIndex, nullptr};
            },
            "name"_a, "asset"_a, "gridName"_a, "gridIndex"_a, "A field of an OpenVDB file.");

    nb::class_<InstancerPrim> instancer(module, "InstancerPrim", "Places its prototypes.");
    instancer.def(
        "__init__",
        [](InstancerPrim* self, const Placement& where) {
            new (self) InstancerPrim;
            self->placement = where;
        },
        "placement"_a);
    BindFields(instancer);
}

void BindLight(nb::module_& module) {
    BindEnum<LightType>(module, "LightType", "The lights that are rendered.");
    BindEnum<MaterialSyncMode>(module, "MaterialSyncMode",
                               "How a mesh light and its material go together.");
    BindStruct<LightShaping>(module, "LightShaping", "How light depends on its direction.");
    BindStruct<LightShadow>(module, "LightShadow", "The shadows a light casts.");
    module.attr("LIGHT_GROUP_ATTRIBUTES") =
        std::vector<std::string>(kLightGroupAttributes.begin(), kLightGroupAttributes.end());
    BindStruct<LightDescription>(module, "LightDescription", "A UsdLux light as authored.");
    nb::class_<LinkCategories> links(module, "LinkCategories", "What a light is linked to.");
    links.def(
        "__init__",
        [](LinkCategories* self, const std::string& lightLink, const std::string& shadowLink) {
            new (self) LinkCategories{lightLink, shadowLink};
        },
        "lightLink"_a = "", "shadowLink"_a = "");
    BindFields(links);
    BindStruct<LightSample>(module, "LightSample",
                            "What of a light changes, at a time in frames from the frame.");
    nb::class_<LightPrim> lightPrim(module, "LightPrim", "A light in the scene.");
    lightPrim
        .def(
            "__init__",
            [](LightPrim* self, const LightDescription& light, const Placement& where) {
                new (self) LightPrim{where, light, {}, {}, {}, {}};
            },
            "light"_a, "placement"_a)
        .def(
            "AddPortal",
            [](LightPrim& self, nb::handle worldFromPortal, float width, float height) {
                self.portals.push_back(
                    {MatrixFromBuffer(worldFromPortal, "worldFromPortal"), width, height});
            },
            "worldFromPortal"_a, "width"_a, "height"_a)
        .def(
            "AddFilter",
            [](LightPrim& self, const MaterialNode& node, nb::handle worldFromFilter) {
                self.filters.push_back(
                    {node, MatrixFromBuffer(worldFromFilter, "worldFromFilter")});
            },
            "node"_a, "worldFromFilter"_a);
    BindFields(lightPrim);
}

void BindCamera(nb::module_& module) {
    BindEnum<CameraProjection>(module, "CameraProjection",
                               "How directions become points of the image.");
    BindStruct<CameraLens>(module, "CameraLens", "Projection and aperture of a camera.");
    BindStruct<LensSample>(module, "LensSample",
                           "The lens at a time, in frames from the frame; scene units.");
    BindStruct<CameraPrim>(module, "CameraPrim", "A camera in the scene.");
    module.attr("CAMERA_ATTRIBUTES") = nb::cast(CameraAttributeNames());
    module.attr("EXPOSURE_ATTRIBUTES") = nb::cast(ExposureAttributeNames());
    module.def(
        "SetCameraAttributes",
        [](const CameraAttributes& attributes, CameraPrim& camera) {
            return SetCameraAttributes(attributes, &camera);
        },
        "attributes"_a, "camera"_a,
        "Sets what attributes (CAMERA_ATTRIBUTES by name) say of a camera's lens; returns what is "
        "wrong with them, a line each.");
    module.def("LinearExposureScale", &LinearExposureScale, "exposure"_a, "attributes"_a,
               "The factor on radiance of `exposure`, in stops, and EXPOSURE_ATTRIBUTES by name.");
}

/// \param path of USD: those below it begin with it and a slash.
std::vector<std::string> PathsBelow(const SceneDescription& scene, const std::string& path) {
    std::vector<std::string> found;
    const auto add = [&](const auto& prims) {
        for (auto prim = prims.lower_bound(path);
             prim != prims.end() && prim->first.compare(0, path.size(), path) == 0; ++prim) {
            if (prim->first.size() == path.size() || prim->first[path.size()] == '/') {
                found.push_back(prim->first);
            }
        }
    };
    add(scene.geometry);
    add(scene.volumes);
    add(scene.instancers);
    add(scene.lights);
    return found;
}

/// Of everything that names one; resolved ones alone.
std::set<std::string> AssetFiles(const SceneDescription& scene) {
    std::set<std::string> files;
    const auto add = [&](const AssetReference& asset) {
        if (!asset.file.empty()) {
            files.insert(asset.file);
        }
    };
    const auto addOfLight = [&](const LightDescription& light) {
        add(light.textureFile);
        add(light.shaping.iesFile);
    };
    const auto addOfNode = [&](const MaterialNode& node) {
        for (const auto& [name, value] : node.parameters) {
            if (const auto* asset = std::get_if<AssetReference>(&value)) {
                add(*asset);
            }
        }
    };
    for (const auto& [path, prim] : scene.lights) {
        addOfLight(prim.light);
        for (const LightFilter& filter : prim.filters) {
            addOfNode(filter.node);
        }
    }
    for (const auto& [path, prim] : scene.geometry) {
        if (prim.light) {
            addOfLight(prim.light->light);
        }
    }
    for (const auto& [path, prim] : scene.volumes) {
        for (const auto& [name, field] : prim.fields) {
            add(field.asset);
        }
    }
    for (const auto& [path, network] : scene.materials) {
        for (const MaterialNode& node : network->nodes) {
            addOfNode(node);
        }
    }
    return files;
}

} // namespace

void BindScene(nb::module_& module) {
    BindPrimvar(module);
    BindGeometry(module);
    BindPlaced(module);
    BindLight(module);
    BindCamera(module);
    // Copies of the maps, whose arrays are shared: edits of the session end the life of its own.
    nb::class_<SceneDescription>(module, "SceneDescription", "All prims, by path; copies.")
        .def_prop_ro("geometry", [](const SceneDescription& self) { return self.geometry; })
        .def_prop_ro("volumes", [](const SceneDescription& self) { return self.volumes; })
        .def_prop_ro("instancers", [](const SceneDescription& self) { return self.instancers; })
        .def_prop_ro("lights", [](const SceneDescription& self) { return self.lights; })
        .def_prop_ro("materials",
                     [](const SceneDescription& self) {
                         std::map<std::string, MaterialNetwork> networks;
                         for (const auto& [path, network] : self.materials) {
                             networks[path] = *network;
                         }
                         return networks;
                     })
        .def_prop_ro("cameras", [](const SceneDescription& self) { return self.cameras; })
        // What copies of a million prims would take long for.
        .def("PathsBelow", &PathsBelow, "path"_a,
             "Of geometry, volumes, instancers and lights at a path of USD and below it.")
        .def_prop_ro(
            "isEmpty",
            [](const SceneDescription& self) {
                return self.geometry.empty() && self.volumes.empty();
            },
            "Whether there is nothing to draw.")
        .def_prop_ro("hasInstancers",
                     [](const SceneDescription& self) { return !self.instancers.empty(); })
        .def_prop_ro(
            "hasPlacedLights",
            [](const SceneDescription& self) {
                return std::any_of(self.lights.begin(), self.lights.end(), [](const auto& entry) {
                    return !entry.second.placement.instancerPath.empty();
                });
            },
            "Whether an instancer places a light.")
        .def("AssetFiles", &AssetFiles,
             "Files that the scene reads: images, light profiles, volumes.")
        .def(
            "FindGeometry",
            [](const SceneDescription& self,
               const std::string& path) -> std::optional<GeometryPrim> {
                const auto prim = self.geometry.find(path);
                return prim == self.geometry.end() ? std::nullopt : std::optional(prim->second);
            },
            "path"_a, "A copy of the prim of that path; None where there is none.");
}

} // namespace hds::python
