// SPDX-License-Identifier: Apache-2.0
// The limit surface of a control cage: topology, primvars and what evaluates them, face by face
// (OpenSubdiv's Bfr). Nothing is refined beforehand. Internal to geometry. Explained in
// docs/geometry.md.
#pragma once

#include "hdStream/geometry/dicePattern.h"
#include "hdStream/geometry/subdivTopology.h"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>

#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <vector>

namespace hds {

/// How often features are isolated before a surface is approximated; points of rates up to
/// 2^level are exact (docs/geometry.md has the cost).
constexpr int kSmoothLevel = 6;
constexpr int kSharpLevel = 8;
/// The same beside crowded vertices, or in faces with many: OpenSubdiv's cost grows with the cube
/// of their edges.
constexpr int kCrowdedLevel = 2;
constexpr int kCrowdedEdges = 32;
/// With more edges at a vertex or a face, the cage is drawn.
constexpr int kMaxEdges = 512;

/// A primvar of a subdivided mesh. Uniform and constant ones are not refined.
struct SubdivPrimvar {
    GeometryAttribute attribute; ///< its interpolation is the authored one: Varying stays
    int channel = -1;            ///< FaceVarying: of the refiner
    int offset = 0;              ///< Vertex, Varying: first float in the rows of its kind
};

/// Rows of floats: one a point or face-varying value.
struct ValueRows {
    int rowSize = 0;
    std::vector<float> values; ///< [rows][rowSize], finite
};

/// Topology and values of a cage. Immutable after Make; any number of threads may read it.
class SubdivModel {
public:
    using Factory =
        OpenSubdiv::Bfr::RefinerSurfaceFactory<OpenSubdiv::Bfr::SurfaceFactoryCacheThreaded<
            std::shared_mutex, std::shared_lock<std::shared_mutex>,
            std::unique_lock<std::shared_mutex>>>;

    /// \return null, and one warning, when OpenSubdiv refuses the topology; null too, with the
    /// warnings of what was dropped, when no face is left. Precondition: a subdivision scheme.
    /// \param warnings must outlive the model.
    static std::unique_ptr<const SubdivModel> Make(std::shared_ptr<const GeometryDescription> mesh,
                                                   const std::string& primPath, Warnings& warnings);

    const GeometryDescription& Mesh() const { return *_mesh; }
    const SubdivCage& Cage() const { return _cage; }
    /// What makes the surfaces of a face.
    const Factory& Surfaces(int face) const {
        return _isCrowded[face] != 0 ? *_crowdedFactory : *_factory;
    }
    const OpenSubdiv::Far::TopologyLevel& Level() const { return _refiner->GetLevel(0); }
    /// Sorted by name.
    const std::vector<SubdivPrimvar>& Primvars() const { return _primvars; }
    /// Bilinear surfaces are shaded flat.
    bool IsFlat() const { return _mesh->subdivisionScheme == "bilinear"; }

    std::uint32_t NumFaces() const { return static_cast<std::uint32_t>(_cage.faces.size()); }
    FaceShape Shape(int face) const;
    /// False for holes, and for faces that have no limit surface (interpolateBoundary none).
    bool IsDrawn(int face) const { return _isDrawn[face] != 0; }

    /// The lowest drawn face at an edge or a vertex: it evaluates what they share. -1: none.
    int EdgeOwner(int edge) const;
    int VertexOwner(int vertex) const;
    /// True where the surface has an edge of its own: the normals of both sides differ.
    bool IsSharpEdge(int edge) const;
    /// True where the faces around a vertex do not share one normal.
    bool IsSharpVertex(int vertex) const { return _isSharpVertex[vertex] != 0; }

    /// Values of Vertex and Varying primvars by point, of a channel by its value. Made on first
    /// use.
    const ValueRows& VertexRows() const;
    const ValueRows& VaryingRows() const;
    const ValueRows& ChannelRows(int channel) const;

private:
    SubdivModel() = default;
    void CollectPrimvars(const std::string& primPath, Warnings& warnings);
    void AddPrimvar(SubdivPrimvar primvar);
    void MarkTopology();
    int LowestDrawn(const OpenSubdiv::Far::ConstIndexArray& faces) const;
    void FillRows() const;

    std::shared_ptr<const GeometryDescription> _mesh;
    SubdivCage _cage;
    std::vector<SubdivChannel> _channels;
    std::vector<SubdivPrimvar> _primvars;
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> _refiner;
    std::unique_ptr<Factory> _factory;
    std::unique_ptr<Factory> _crowdedFactory;
    std::vector<std::uint8_t> _isDrawn;       ///< [faces]
    std::vector<std::uint8_t> _isCrowded;     ///< [faces]
    std::vector<std::uint8_t> _isSharpVertex; ///< [points]
    std::string _primPath;
    Warnings* _warnings = nullptr;
    mutable std::once_flag _rowsMade;
    mutable ValueRows _vertexRows;
    mutable ValueRows _varyingRows;
    mutable std::vector<ValueRows> _channelRows;
};

/// Index of `value` in a short list of OpenSubdiv, -1: not there.
int FindIn(const OpenSubdiv::Far::ConstIndexArray& list, int value);

} // namespace hds
