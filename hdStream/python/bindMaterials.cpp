// SPDX-License-Identifier: Apache-2.0
#include "hdStream/python/bindFields.h"
#include "hdStream/python/bindings.h"
#include "hdStream/session/hostFrame.h"
#include "hdStream/session/session.h"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

namespace nb = nanobind;
using namespace nb::literals;

namespace hds::python {

void BindMaterials(nb::module_& module) {
    nb::class_<AssetReference> asset(module, "AssetReference", "A file or a byte range of one.");
    asset.def(
        "__init__",
        [](AssetReference* self, const std::string& authoredPath, const std::string& file,
           std::uint64_t offset, std::uint64_t size, const std::string& colorSpace) {
            new (self) AssetReference{authoredPath, file, offset, size, colorSpace};
        },
        "authoredPath"_a = "", "file"_a = "", "offset"_a = 0, "size"_a = 0, "colorSpace"_a = "");
    BindFields<FieldAccess::ReadOnly>(asset);

    nb::class_<MaterialNode::Connection> connection(module, "Connection", "The output of a node.");
    connection.def(
        "__init__",
        [](MaterialNode::Connection* self, const std::string& path, const std::string& output) {
            new (self) MaterialNode::Connection{path, output};
        },
        "upstreamPath"_a, "upstreamOutput"_a);
    BindFields<FieldAccess::ReadOnly>(connection);

    nb::class_<MaterialNode> node(module, "MaterialNode", "One shader node.");
    node.def(
        "__init__",
        [](MaterialNode* self, const std::string& path, const std::string& identifier,
           std::map<std::string, ParameterValue> parameters,
           std::map<std::string, MaterialNode::Connection> connections) {
            new (self)
                MaterialNode{path, identifier, std::move(parameters), std::move(connections)};
        },
        "path"_a, "identifier"_a, "parameters"_a, "connections"_a);
    BindFields<FieldAccess::ReadOnly>(node);

    nb::class_<MaterialNetwork> network(module, "MaterialNetwork",
                                        "Nodes and terminals of a material.");
    network.def(
        "__init__",
        [](MaterialNetwork* self, std::vector<MaterialNode> nodes,
           std::map<std::string, MaterialNode::Connection> terminals, std::optional<double> frame) {
            new (self) MaterialNetwork{std::move(nodes), std::move(terminals)};
            TellFrame(frame, self);
        },
        "nodes"_a, "terminals"_a, "frame"_a = nb::none(),
        "`frame`: that is rendered, for nodes that ask for it; None: it is not known.");
    BindFields<FieldAccess::ReadOnly>(network);

    module.def(
        "FindInPackage",
        [](const std::string& path) -> nb::object {
            const std::optional<ByteRange> range = FindInPackage(path);
            return range ? nb::cast(std::make_tuple(range->file, range->offset, range->size))
                         : nb::none();
        },
        "path"_a,
        "File, offset and size in bytes of an entry of a package, \"a.usdz[b.png]\", nested or "
        "not. "
        "None: the package cannot be read, or has no such entry that is stored as it is.");
    module.def("PatternNames", &PatternNames,
               "The names of all pattern nodes, sorted: MaterialX's categories and USD's names.");
    module.def("ClosureIds", &ClosureIds,
               "The ids of all BSDF, EDF and VDF nodes of MaterialX that are drawn, sorted.");
    module.def(
        "SurfaceInputs",
        [](const std::string& identifier) {
            std::vector<std::tuple<std::string, std::uint32_t, std::vector<float>>> rows;
            for (const SurfaceInput& one : SurfaceInputs(identifier)) {
                const float* values = one.fallback.data();
                rows.emplace_back(one.name, one.numComponents,
                                  std::vector<float>(values, values + one.numComponents));
            }
            return rows;
        },
        "identifier"_a, "Name, components and default of a MaterialX surface's inputs.");
    module.def("IsSurfaceShader", &IsSurfaceShader, "identifier"_a,
               "Whether a shader id is that of a surface that is drawn.");
    module.def("IsKnownShader", &IsKnownShader, "identifier"_a,
               "Whether an id is that of a pattern node or of a surface shader that is drawn.");
}

} // namespace hds::python
