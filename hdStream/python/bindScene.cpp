// SPDX-License-Identifier: Apache-2.0
#include "hdStream/python/bindings.h"
#include "hdStream/python/bufferSpan.h"

#include <glm/gtc/type_ptr.hpp>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/set.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>

namespace nb = nanobind;
using namespace nb::literals;

namespace hds::python {

namespace {

/// A matrix from 16 doubles in Gf's memory order, which is glm's too (see sceneDescription.h).
glm::dmat4 MatrixFromBuffer(nb::handle object, const char* what) {
    const HeldBuffer buffer(object, 'd', sizeof(double), what);
    if (buffer.numItems() != 16) {
        throw nb::value_error("a matrix has 16 items");
    }
    glm::dmat4 matrix(1.0);
    std::copy_n(static_cast<const double*>(buffer.data()), 16, glm::value_ptr(matrix));
    return matrix;
}

/// A numpy array [4][4] with a copy of the matrix, in Gf's memory order.
nb::object ArrayFromMatrix(const glm::dmat4& matrix) {
    const double* items = glm::value_ptr(matrix);
    return ArrayFromSpan(SharedSpan<double>(std::vector<double>(items, items + 16)), 4);
}

template <typename Owner>
void BindMatrix(nb::class_<Owner>& binding, const char* name, glm::dmat4 Owner::*member) {
    binding.def_prop_rw(
        name, [member](const Owner& self) { return ArrayFromMatrix(self.*member); },
        [member, name](Owner& self, nb::handle object) {
            self.*member = MatrixFromBuffer(object, name);
        });
}

/// A list of (time, matrix): transforms over time.
template <typename Owner>
void BindSamples(nb::class_<Owner>& binding, const char* name,
                 std::vector<TransformSample> Owner::*member) {
    using Pairs = std::vector<std::pair<double, nb::object>>;
    binding.def_prop_rw(
        name,
        [member](const Owner& self) {
            Pairs pairs;
            for (const TransformSample& sample : self.*member) {
                pairs.emplace_back(sample.time, ArrayFromMatrix(sample.matrix));
            }
            return pairs;
        },
        [member, name](Owner& self, const Pairs& pairs) {
            (self.*member).clear();
            for (const auto& [time, matrix] : pairs) {
                (self.*member).push_back({time, MatrixFromBuffer(matrix, name)});
            }
        });
}

void BindPrimvar(nb::module_& module) {
    nb::enum_<Interpolation>(module, "Interpolation")
        .value("Constant", Interpolation::Constant)
        .value("Uniform", Interpolation::Uniform)
        .value("Varying", Interpolation::Varying)
        .value("Vertex", Interpolation::Vertex)
        .value("FaceVarying", Interpolation::FaceVarying)
        .value("Instance", Interpolation::Instance);

    nb::class_<Primvar> primvar(module, "Primvar", "A named array of values on a prim.");
    primvar.def(
        "__init__",
        [](Primvar* self, const std::string& name, Interpolation interpolation, nb::handle values,
           nb::handle indices) {
            auto [span, numComponents] = SpanFromBuffer<float>(values, name.c_str());
            if (numComponents < 1 || numComponents > 4) {
                throw nb::value_error("a primvar has 1 to 4 components");
            }
            SharedSpan<std::int32_t> indexSpan;
            if (!indices.is_none()) {
                indexSpan = SpanFromBuffer<std::int32_t>(indices, name.c_str()).first;
            }
            new (self) Primvar{name, interpolation, static_cast<std::uint32_t>(numComponents),
                               std::move(span), std::move(indexSpan)};
        },
        "name"_a, "interpolation"_a, "values"_a, "indices"_a = nb::none(),
        "`values` is a float32 array [count] or [count][components].");
    primvar.def_ro("name", &Primvar::name)
        .def_ro("interpolation", &Primvar::interpolation)
        .def_ro("numComponents", &Primvar::numComponents)
        .def_prop_ro(
            "values",
            [](const Primvar& self) { return ArrayFromSpan(self.values, self.numComponents); })
        .def_prop_ro("indices", [](const Primvar& self) { return ArrayFromSpan(self.indices, 1); });
}

void BindMesh(nb::module_& module) {
    nb::class_<MeshSubset> subset(module, "MeshSubset", "A face set.");
    subset.def(nb::init<>()).def_rw("name", &MeshSubset::name);
    BindSpan(subset, "faces", &MeshSubset::faces, 1);

    nb::class_<SubdivTags> tags(module, "SubdivTags", "OpenSubdiv tags as authored.");
    tags.def(nb::init<>())
        .def_rw("interpolateBoundary", &SubdivTags::interpolateBoundary)
        .def_rw("faceVaryingLinearInterpolation", &SubdivTags::faceVaryingLinearInterpolation)
        .def_rw("triangleSubdivisionRule", &SubdivTags::triangleSubdivisionRule);
    BindSpan(tags, "creaseIndices", &SubdivTags::creaseIndices, 1);
    BindSpan(tags, "creaseLengths", &SubdivTags::creaseLengths, 1);
    BindSpan(tags, "creaseSharpnesses", &SubdivTags::creaseSharpnesses, 1);
    BindSpan(tags, "cornerIndices", &SubdivTags::cornerIndices, 1);
    BindSpan(tags, "cornerSharpnesses", &SubdivTags::cornerSharpnesses, 1);

    nb::enum_<PrimitiveKind>(module, "PrimitiveKind", "What a description is made of.")
        .value("Faces", PrimitiveKind::Faces)
        .value("Curves", PrimitiveKind::Curves)
        .value("Points", PrimitiveKind::Points);
    nb::class_<CurveForm>(module, "CurveForm", "How points become curves.")
        .def(nb::init<>())
        .def_rw("type", &CurveForm::type)
        .def_rw("basis", &CurveForm::basis)
        .def_rw("wrap", &CurveForm::wrap);

    nb::class_<MeshDescription> mesh(module, "MeshDescription",
                                     "A mesh, curves or points as authored.");
    mesh.def(nb::init<>())
        .def_rw("primitives", &MeshDescription::primitives)
        .def_rw("curves", &MeshDescription::curves)
        .def_rw("subdivisionScheme", &MeshDescription::subdivisionScheme)
        .def_rw("subdivTags", &MeshDescription::subdivTags)
        .def_rw("leftHanded", &MeshDescription::leftHanded)
        .def_rw("primvars", &MeshDescription::primvars)
        .def_rw("subsets", &MeshDescription::subsets);
    BindSpan(mesh, "points", &MeshDescription::points, 3);
    using Samples = std::vector<std::pair<double, nb::object>>;
    mesh.def_prop_rw(
        "samples",
        [](const MeshDescription& self) {
            Samples samples;
            for (const PointSample& sample : self.samples) {
                samples.emplace_back(sample.time, ArrayFromSpan(sample.points, 3));
            }
            return samples;
        },
        [](MeshDescription& self, const Samples& samples) {
            self.samples.clear();
            for (const auto& [time, points] : samples) {
                self.samples.push_back({time, SpanFromBuffer<float>(points, "samples").first});
            }
        });
    BindSpan(mesh, "faceVertexCounts", &MeshDescription::faceVertexCounts, 1);
    BindSpan(mesh, "faceVertexIndices", &MeshDescription::faceVertexIndices, 1);
    BindSpan(mesh, "holeIndices", &MeshDescription::holeIndices, 1);

    nb::class_<ImplicitShape>(module, "ImplicitShape", "Size of an implicit gprim.")
        .def(nb::init<>())
        .def_rw("type", &ImplicitShape::type)
        .def_rw("axis", &ImplicitShape::axis)
        .def_rw("size", &ImplicitShape::size)
        .def_rw("radius", &ImplicitShape::radius)
        .def_rw("height", &ImplicitShape::height)
        .def_rw("width", &ImplicitShape::width)
        .def_rw("length", &ImplicitShape::length);
    module.def("MakeImplicitMesh", &MakeImplicitMesh, "shape"_a, "The mesh of an implicit gprim.");
}

void BindPlaced(nb::module_& module) {
    nb::class_<Placement> placement(module, "Placement",
                                    "Where a prim is and whether it is drawn.");
    placement
        .def(
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
            "worldFromObject"_a, "instancerPath"_a = "", "instances"_a = nb::none(),
            "visible"_a = true,
            "`instances` (int32): which instances of the instancer place the prim.")
        .def_rw("instancerPath", &Placement::instancerPath)
        .def_rw("visible", &Placement::visible);
    BindMatrix(placement, "worldFromObject", &Placement::worldFromObject);
    BindSpan(placement, "instances", &Placement::instances, 1);
    BindSamples(placement, "samples", &Placement::samples);

    nb::enum_<CullStyle>(module, "CullStyle", "Which faces camera rays do not see.")
        .value("DontCare", CullStyle::DontCare)
        .value("Nothing", CullStyle::Nothing)
        .value("Back", CullStyle::Back)
        .value("Front", CullStyle::Front)
        .value("BackUnlessDoubleSided", CullStyle::BackUnlessDoubleSided)
        .value("FrontUnlessDoubleSided", CullStyle::FrontUnlessDoubleSided);
    nb::class_<MeshPrim>(module, "MeshPrim", "A mesh in the scene.")
        .def(
            "__init__",
            [](MeshPrim* self, const MeshDescription& mesh, const Placement& where,
               const std::string& purpose, const std::string& materialPath) {
                new (self) MeshPrim;
                self->placement = where;
                self->purpose = purpose;
                self->mesh = std::make_shared<const MeshDescription>(mesh); // shares the arrays
                self->materialPath = materialPath;
            },
            "mesh"_a, "placement"_a, "purpose"_a = "default", "materialPath"_a = "")
        .def_rw("placement", &MeshPrim::placement)
        .def_rw("purpose", &MeshPrim::purpose)
        .def_prop_ro(
            "mesh", [](const MeshPrim& self) -> const MeshDescription& { return *self.mesh; },
            nb::rv_policy::reference_internal)
        .def_rw("categories", &MeshPrim::categories)
        .def_rw("doubleSided", &MeshPrim::doubleSided)
        .def_rw("cullStyle", &MeshPrim::cullStyle)
        .def_rw("subsetMaterialPaths", &MeshPrim::subsetMaterialPaths)
        .def_rw("materialPath", &MeshPrim::materialPath)
        .def_rw("primId", &MeshPrim::primId)
        .def(
            "SetLight",
            [](MeshPrim& self, const LightDescription& light, MaterialSyncMode mode,
               const LinkCategories& links) {
                self.light = std::make_shared<const MeshLight>(MeshLight{light, mode, links});
            },
            "light"_a, "materialSyncMode"_a, "links"_a, "Makes the mesh a light.")
        .def("RemoveLight", [](MeshPrim& self) { self.light = nullptr; });

    nb::class_<InstancerPrim> instancer(module, "InstancerPrim", "Places its prototypes.");
    instancer
        .def(
            "__init__",
            [](InstancerPrim* self, const Placement& where) {
                new (self) InstancerPrim;
                self->placement = where;
            },
            "placement"_a)
        .def_rw("instanceCategories", &InstancerPrim::instanceCategories)
        .def_rw("placement", &InstancerPrim::placement);
    BindSpan(instancer, "instanceTransforms", &InstancerPrim::instanceTransforms, 16);
    using Samples = std::vector<std::pair<double, nb::object>>;
    instancer.def_prop_rw(
        "samples",
        [](const InstancerPrim& self) {
            Samples samples;
            for (const InstanceSample& sample : self.samples) {
                samples.emplace_back(sample.time, ArrayFromSpan(sample.transforms, 16));
            }
            return samples;
        },
        [](InstancerPrim& self, const Samples& samples) {
            self.samples.clear();
            for (const auto& [time, transforms] : samples) {
                self.samples.push_back({time, SpanFromBuffer<double>(transforms, "samples").first});
            }
        });
}

void BindLight(nb::module_& module) {
    nb::enum_<LightType>(module, "LightType")
        .value("Distant", LightType::Distant)
        .value("Sphere", LightType::Sphere)
        .value("Rect", LightType::Rect)
        .value("Disk", LightType::Disk)
        .value("Cylinder", LightType::Cylinder)
        .value("Dome", LightType::Dome)
        .value("Mesh", LightType::Mesh);
    nb::enum_<MaterialSyncMode>(module, "MaterialSyncMode")
        .value("GlowTintsLight", MaterialSyncMode::GlowTintsLight)
        .value("Independent", MaterialSyncMode::Independent)
        .value("NoMaterialResponse", MaterialSyncMode::NoMaterialResponse);
    nb::class_<LightShaping>(module, "LightShaping", "How light depends on its direction.")
        .def(nb::init<>())
        .def_rw("focus", &LightShaping::focus)
        .def_rw("focusTint", &LightShaping::focusTint)
        .def_rw("coneAngle", &LightShaping::coneAngle)
        .def_rw("coneSoftness", &LightShaping::coneSoftness)
        .def_rw("iesFile", &LightShaping::iesFile)
        .def_rw("iesAngleScale", &LightShaping::iesAngleScale)
        .def_rw("iesNormalize", &LightShaping::iesNormalize);
    nb::class_<LightShadow>(module, "LightShadow", "The shadows a light casts.")
        .def(nb::init<>())
        .def_rw("enable", &LightShadow::enable)
        .def_rw("color", &LightShadow::color)
        .def_rw("distance", &LightShadow::distance)
        .def_rw("falloff", &LightShadow::falloff)
        .def_rw("falloffGamma", &LightShadow::falloffGamma);
    nb::class_<LightDescription>(module, "LightDescription", "A UsdLux light as authored.")
        .def(nb::init<>())
        .def_rw("type", &LightDescription::type)
        .def_rw("intensity", &LightDescription::intensity)
        .def_rw("exposure", &LightDescription::exposure)
        .def_rw("diffuse", &LightDescription::diffuse)
        .def_rw("specular", &LightDescription::specular)
        .def_rw("normalize", &LightDescription::normalize)
        .def_rw("color", &LightDescription::color)
        .def_rw("enableColorTemperature", &LightDescription::enableColorTemperature)
        .def_rw("colorTemperature", &LightDescription::colorTemperature)
        .def_rw("angle", &LightDescription::angle)
        .def_rw("radius", &LightDescription::radius)
        .def_rw("width", &LightDescription::width)
        .def_rw("height", &LightDescription::height)
        .def_rw("length", &LightDescription::length)
        .def_rw("treatAsPoint", &LightDescription::treatAsPoint)
        .def_rw("treatAsLine", &LightDescription::treatAsLine)
        .def_rw("textureFormat", &LightDescription::textureFormat)
        .def_rw("textureFile", &LightDescription::textureFile)
        .def_rw("shaping", &LightDescription::shaping)
        .def_rw("shadow", &LightDescription::shadow)
        .def_rw("visibleToCamera", &LightDescription::visibleToCamera);
    nb::class_<LinkCategories>(module, "LinkCategories", "What a light is linked to.")
        .def(
            "__init__",
            [](LinkCategories* self, const std::string& lightLink, const std::string& shadowLink) {
                new (self) LinkCategories{lightLink, shadowLink};
            },
            "lightLink"_a = "", "shadowLink"_a = "")
        .def_rw("lightLink", &LinkCategories::lightLink)
        .def_rw("shadowLink", &LinkCategories::shadowLink);
    nb::class_<LightPrim>(module, "LightPrim", "A light in the scene.")
        .def(
            "__init__",
            [](LightPrim* self, const LightDescription& light, const Placement& where) {
                new (self) LightPrim{where, light, {}, {}};
            },
            "light"_a, "placement"_a)
        .def(
            "AddPortal",
            [](LightPrim& self, nb::handle worldFromPortal, float width, float height) {
                self.portals.push_back(
                    {MatrixFromBuffer(worldFromPortal, "worldFromPortal"), width, height});
            },
            "worldFromPortal"_a, "width"_a, "height"_a)
        .def_rw("placement", &LightPrim::placement)
        .def_rw("light", &LightPrim::light)
        .def_rw("links", &LightPrim::links);
}

void BindCamera(nb::module_& module) {
    nb::class_<CameraPrim> camera(module, "CameraPrim", "A camera in the scene.");
    camera.def(nb::init<>())
        .def_rw("orthographic", &CameraPrim::orthographic)
        .def_rw("horizontalAperture", &CameraPrim::horizontalAperture)
        .def_rw("verticalAperture", &CameraPrim::verticalAperture)
        .def_rw("horizontalApertureOffset", &CameraPrim::horizontalApertureOffset)
        .def_rw("verticalApertureOffset", &CameraPrim::verticalApertureOffset)
        .def_rw("focalLength", &CameraPrim::focalLength)
        .def_rw("nearClip", &CameraPrim::nearClip)
        .def_rw("farClip", &CameraPrim::farClip)
        .def_rw("fStop", &CameraPrim::fStop)
        .def_rw("focusDistance", &CameraPrim::focusDistance)
        .def_rw("exposureScale", &CameraPrim::exposureScale)
        .def_prop_rw(
            "clippingPlanes",
            [](const CameraPrim& self) {
                std::vector<std::array<double, 4>> planes;
                for (const glm::dvec4& plane : self.clippingPlanes) {
                    planes.push_back({plane.x, plane.y, plane.z, plane.w});
                }
                return planes;
            },
            [](CameraPrim& self, const std::vector<std::array<double, 4>>& planes) {
                self.clippingPlanes.clear();
                for (const auto& plane : planes) {
                    self.clippingPlanes.emplace_back(plane[0], plane[1], plane[2], plane[3]);
                }
            });
    BindMatrix(camera, "worldFromCamera", &CameraPrim::worldFromCamera);
    BindSamples(camera, "samples", &CameraPrim::samples);
    camera.def_prop_rw(
        "shutter",
        [](const CameraPrim& self) {
            return std::make_pair(self.shutter.open, self.shutter.close);
        },
        [](CameraPrim& self, const std::pair<double, double>& shutter) {
            self.shutter = {shutter.first, shutter.second};
        });
}

} // namespace

void BindScene(nb::module_& module) {
    BindPrimvar(module);
    BindMesh(module);
    BindPlaced(module);
    BindLight(module);
    BindCamera(module);
    // Copies of the maps, whose arrays are shared: edits of the session end the life of its own.
    nb::class_<SceneDescription>(module, "SceneDescription", "All prims, by path; copies.")
        .def_prop_ro("meshes", [](const SceneDescription& self) { return self.meshes; })
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
        .def_prop_ro("cameras", [](const SceneDescription& self) { return self.cameras; });
}

} // namespace hds::python
