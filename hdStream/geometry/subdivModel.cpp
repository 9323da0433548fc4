// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/subdivModel.h"

#include "hdStream/geometry/meshContent.h"

#include <opensubdiv/bfr/limits.h>
#include <opensubdiv/sdc/crease.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace hds {
namespace {

namespace Bfr = OpenSubdiv::Bfr;
namespace Far = OpenSubdiv::Far;

/// Why the mesh cannot be subdivided, or nothing.
std::string FindObstacle(const GeometryDescription& mesh, const SubdivCage& cage) {
    const bool hasOthers =
        std::any_of(cage.counts.begin(), cage.counts.end(), [](int count) { return count != 3; });
    if (mesh.subdivisionScheme == "loop" && hasOthers) {
        return "loop needs triangles only";
    }
    if (std::any_of(cage.counts.begin(), cage.counts.end(),
                    [](int count) { return count > kMaxEdges; })) {
        return "a face has more than " + std::to_string(kMaxEdges) + " edges";
    }
    return {};
}

/// Copies tuples into rows; values that are not finite would spread to their neighbours and read
/// as 0.
void CopyRows(const GeometryAttribute& attribute, bool isDirect, int offset, ValueRows& rows) {
    const std::size_t numRows = rows.values.size() / std::size_t(rows.rowSize);
    tbb::parallel_for(std::size_t{0}, numRows, [&](std::size_t row) {
        const float* from = isDirect ? attribute.values.data() + row * attribute.numComponents
                                     : ValueOf(attribute, row);
        float* to = rows.values.data() + row * std::size_t(rows.rowSize) + offset;
        std::transform(from, from + attribute.numComponents, to,
                       [](float v) { return std::isfinite(v) ? v : 0.0F; });
    });
}

} // namespace

int FindIn(const Far::ConstIndexArray& list, int value) {
    for (int i = 0; i < list.size(); ++i) {
        if (list[i] == value) {
            return i;
        }
    }
    return -1;
}

std::unique_ptr<const SubdivModel>
SubdivModel::Make(std::shared_ptr<const GeometryDescription> mesh, const std::string& primPath,
                  Warnings& warnings) {
    std::unique_ptr<SubdivModel> model(new SubdivModel());
    model->_mesh = std::move(mesh);
    model->_primPath = primPath;
    model->_warnings = &warnings;
    PrimLog log(primPath, warnings);
    const FaceTable table = BuildFaceTable(*model->_mesh);
    CheckHeader(*model->_mesh, table, log);
    if (!IsCountable(*model->_mesh, table, log)) {
        return nullptr;
    }
    MarkHoles(*model->_mesh, log); // for its warning: the cage has its holes from the authored list
    model->_cage = BuildSubdivCage(*model->_mesh, primPath, warnings);
    if (model->_cage.faces.empty()) {
        return nullptr;
    }
    model->CollectPrimvars(primPath, warnings);
    std::string obstacle = FindObstacle(*model->_mesh, model->_cage);
    if (obstacle.empty()) {
        model->_refiner = CreateRefiner(*model->_mesh, model->_cage, model->_channels);
        obstacle = model->_refiner ? "" : "OpenSubdiv refuses its topology";
    }
    if (obstacle.empty() && model->_refiner->GetMaxValence() > kMaxEdges) {
        obstacle = "a point has more than " + std::to_string(kMaxEdges) + " edges";
    }
    if (!obstacle.empty()) {
        warnings.Add(primPath, "not subdivided: " + obstacle);
        return nullptr;
    }
    const auto makeFactory = [&](int smoothLevel, int sharpLevel) {
        Factory::Options options;
        options.SetApproxLevelSmooth(smoothLevel);
        options.SetApproxLevelSharp(sharpLevel);
        return std::make_unique<Factory>(*model->_refiner, options);
    };
    model->_factory = makeFactory(kSmoothLevel, kSharpLevel);
    model->_crowdedFactory = makeFactory(kCrowdedLevel, kCrowdedLevel);
    model->MarkTopology();
    return model;
}

/// Which faces are drawn and which vertices have several normals.
void SubdivModel::MarkTopology() {
    const Far::TopologyLevel& level = Level();
    _isDrawn.resize(NumFaces());
    _isCrowded.resize(NumFaces());
    tbb::parallel_for(0, level.GetNumFaces(), [&](int face) {
        _isDrawn[face] = _factory->FaceHasLimitSurface(face) ? 1 : 0;
        const Far::ConstIndexArray vertices = level.GetFaceVertices(face);
        bool isCrowded = vertices.size() > kCrowdedEdges;
        for (int i = 0; i < vertices.size() && !isCrowded; ++i) {
            isCrowded = level.GetVertexEdges(vertices[i]).size() > kCrowdedEdges;
        }
        _isCrowded[face] = isCrowded ? 1 : 0;
    });
    _isSharpVertex.resize(std::size_t(level.GetNumVertices()));
    tbb::parallel_for(0, level.GetNumVertices(), [&](int vertex) {
        const Far::ConstIndexArray edges = level.GetVertexEdges(vertex);
        bool isSharp =
            level.GetVertexFaces(vertex).size() > 1 &&
            (level.GetVertexSharpness(vertex) >= OpenSubdiv::Sdc::Crease::SHARPNESS_INFINITE ||
             level.IsVertexNonManifold(vertex));
        for (int i = 0; i < edges.size() && !isSharp; ++i) {
            isSharp = IsSharpEdge(edges[i]);
        }
        _isSharpVertex[vertex] = isSharp && !IsFlat() ? 1 : 0;
    });
}

FaceShape SubdivModel::Shape(int face) const {
    if (_mesh->subdivisionScheme == "loop") {
        return FaceShape::Triangle;
    }
    return _cage.counts[face] == 4 ? FaceShape::Quad : FaceShape::SubQuads;
}

int SubdivModel::EdgeOwner(int edge) const {
    return LowestDrawn(Level().GetEdgeFaces(edge));
}

int SubdivModel::VertexOwner(int vertex) const {
    return LowestDrawn(Level().GetVertexFaces(vertex));
}

int SubdivModel::LowestDrawn(const Far::ConstIndexArray& faces) const {
    int owner = -1;
    for (int i = 0; i < faces.size(); ++i) {
        if (IsDrawn(faces[i]) && (owner < 0 || faces[i] < owner)) {
            owner = faces[i];
        }
    }
    return owner;
}

bool SubdivModel::IsSharpEdge(int edge) const {
    const Far::TopologyLevel& level = Level();
    return level.IsEdgeNonManifold(edge) ||
           (level.GetEdgeFaces(edge).size() > 1 &&
            level.GetEdgeSharpness(edge) >= OpenSubdiv::Sdc::Crease::SHARPNESS_INFINITE);
}

void SubdivModel::CollectPrimvars(const std::string& primPath, Warnings& warnings) {
    TopologySize size{_mesh->points.size() / 3, _mesh->faceVertexCounts.size(), 0};
    for (const std::int32_t count : _mesh->faceVertexCounts) {
        size.numCorners += static_cast<std::size_t>(std::max(count, 0));
    }
    PrimLog log(primPath, warnings);
    for (GeometryAttribute& attribute : CollectAttributes(*_mesh, size, log)) {
        SubdivPrimvar primvar;
        const auto authored =
            std::find_if(_mesh->primvars.begin(), _mesh->primvars.end(),
                         [&](const Primvar& other) { return other.name == attribute.name; });
        if (attribute.interpolation == Interpolation::Vertex &&
            authored->interpolation == Interpolation::Varying) {
            attribute.interpolation = Interpolation::Varying;
        }
        primvar.attribute = std::move(attribute);
        AddPrimvar(std::move(primvar));
    }
}

/// Gives a primvar its place in the rows of its kind.
void SubdivModel::AddPrimvar(SubdivPrimvar primvar) {
    const auto numComponents = static_cast<int>(primvar.attribute.numComponents);
    switch (primvar.attribute.interpolation) {
    case Interpolation::Vertex:
        primvar.offset = _vertexRows.rowSize;
        _vertexRows.rowSize += numComponents;
        break;
    case Interpolation::Varying:
        primvar.offset = _varyingRows.rowSize;
        _varyingRows.rowSize += numComponents;
        break;
    case Interpolation::FaceVarying: {
        SubdivChannel channel;
        channel.numValues =
            static_cast<int>(primvar.attribute.values.size() / primvar.attribute.numComponents);
        channel.valueIndices.reserve(_cage.corners.size());
        for (const std::uint32_t corner : _cage.corners) {
            channel.valueIndices.push_back(static_cast<int>(ValueIndex(primvar.attribute, corner)));
        }
        primvar.channel = static_cast<int>(_channels.size());
        _channels.push_back(std::move(channel));
        _channelRows.emplace_back().rowSize = numComponents;
        break;
    }
    default:
        break;
    }
    _primvars.push_back(std::move(primvar));
}

void SubdivModel::FillRows() const {
    const std::size_t numPoints = _mesh->points.size() / 3;
    _vertexRows.values.resize(numPoints * std::size_t(_vertexRows.rowSize));
    _varyingRows.values.resize(numPoints * std::size_t(_varyingRows.rowSize));
    for (const SubdivPrimvar& primvar : _primvars) {
        const GeometryAttribute& attribute = primvar.attribute;
        WarnNotFinite(attribute, _primPath, *_warnings);
        if (attribute.interpolation == Interpolation::Vertex) {
            CopyRows(attribute, false, primvar.offset, _vertexRows);
        } else if (attribute.interpolation == Interpolation::Varying) {
            CopyRows(attribute, false, primvar.offset, _varyingRows);
        } else if (attribute.interpolation == Interpolation::FaceVarying) {
            ValueRows& rows = _channelRows[primvar.channel];
            rows.values.resize(attribute.values.size());
            CopyRows(attribute, true, 0, rows);
        }
    }
}

const ValueRows& SubdivModel::VertexRows() const {
    std::call_once(_rowsMade, [this] { FillRows(); });
    return _vertexRows;
}

const ValueRows& SubdivModel::VaryingRows() const {
    std::call_once(_rowsMade, [this] { FillRows(); });
    return _varyingRows;
}

const ValueRows& SubdivModel::ChannelRows(int channel) const {
    std::call_once(_rowsMade, [this] { FillRows(); });
    return _channelRows[channel];
}

} // namespace hds
