// SPDX-License-Identifier: Apache-2.0
// The triangles of one diced cage face: a grid inside, and strips that join it to edges whose rates
// may be lower. Pure topology, no positions. Internal to geometry. Explained in docs/geometry.md.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <vector>

namespace hds {

/// How a cage face is parameterised (the ptex faces of OpenSubdiv).
enum class FaceShape : std::uint8_t {
    Quad,     ///< u along edge 0, v along edge 3, whole face
    Triangle, ///< u along edge 0, v along edge 2 (loop)
    SubQuads, ///< one quad a corner: u to the middle of its edge, v to that of the edge before
};

/// A point of a cage face: (u, v) in [0, 1]^2 of a sub-face, which is 0 unless SubQuads.
struct FacePoint {
    int subFace = 0;
    glm::dvec2 uv{0.0};
};

/// The point at fraction `t` of an edge, from corner `edge` to the next.
FacePoint EdgePoint(FaceShape shape, std::uint32_t numEdges, std::uint32_t edge, double t);

/// Where a vertex of a pattern lies.
struct PatternVertex {
    enum class Kind : std::uint8_t { Corner, Edge, Inside };
    Kind kind = Kind::Inside;
    std::uint32_t index = 0; ///< corner or edge of the face
    std::uint32_t step = 0;  ///< Edge: 1 .. rate - 1, from corner `index` to the next
    FacePoint at;
};

/// Part of a quad's parameter domain.
struct PatternBox {
    glm::dvec2 low{0.0};
    glm::dvec2 high{1.0};
};

/// A face with 2^level segments along each edge. Vertices are numbered: corners, then edges, then
/// the inside. Triangles are those of tiles, which are small enough to be primitive groups of a
/// chunk source.
class DicePattern {
public:
    /// Cells of a tile along each side; a cell has at most two triangles.
    static constexpr std::uint32_t kTileCells = 8;
    static constexpr std::uint32_t kMaxLevel = 8;

    /// \param levels [numEdges], at most kMaxLevel; must outlive the pattern.
    DicePattern(FaceShape shape, std::uint32_t numEdges, const std::uint8_t* levels);

    std::uint32_t NumVertices() const { return _numVertices; }
    /// Those that no other face has.
    std::uint32_t NumInside() const { return _numVertices - _firstInside; }
    std::uint32_t NumTiles() const;
    /// Upper bound; exact for a face of one tile.
    std::uint32_t TileTriangles(std::uint32_t tile) const;
    /// Holds the parameters of all vertices of the tile's triangles; all of the face unless Quad.
    PatternBox TileBox(std::uint32_t tile) const;
    /// Appends the tile's triangles, counter-clockwise like the face.
    void AddTile(std::uint32_t tile, std::vector<glm::uvec3>& triangles) const;
    PatternVertex Locate(std::uint32_t vertex) const;

private:
    struct Cell {
        std::uint32_t subFace;
        std::uint32_t x;
        std::uint32_t y;
    };
    struct TileCells {
        std::uint32_t subFace;
        glm::uvec2 low;
        glm::uvec2 high; ///< exclusive
    };

    std::uint32_t Rate(std::uint32_t edge) const { return 1U << _levels[edge]; }
    /// Cells along an edge in the inside's rate.
    std::uint32_t InnerRate(std::uint32_t edge) const;
    std::uint32_t CountTriangles() const;
    TileCells CellsOf(std::uint32_t tile) const;
    bool IsInTile(std::uint32_t tile, const Cell& cell) const;
    Cell EdgeCell(std::uint32_t edge, std::uint32_t cell) const;

    std::uint32_t OuterVertex(std::uint32_t edge, std::uint32_t step) const;
    std::uint32_t InnerVertex(std::uint32_t edge, std::uint32_t step) const;
    std::uint32_t InsideVertex(std::uint32_t subFace, std::uint32_t x, std::uint32_t y) const;
    PatternVertex LocateInside(std::uint32_t index) const;

    void AddSmall(std::vector<glm::uvec3>& triangles) const;
    void AddBand(std::uint32_t tile, std::vector<glm::uvec3>& triangles) const;
    void AddInside(std::uint32_t tile, std::vector<glm::uvec3>& triangles) const;
    void AddStrip(std::uint32_t tile, std::uint32_t edge, std::vector<glm::uvec3>& triangles) const;

    FaceShape _shape;
    std::uint32_t _numEdges;
    const std::uint8_t* _levels;
    std::vector<std::uint32_t> _firstOnEdge; ///< [edges] first vertex inside of an edge
    glm::uvec2 _rate{1};                     ///< of the inside; SubQuads: of a sub-face
    std::uint32_t _firstInside = 0;
    std::uint32_t _numVertices = 0;
    glm::uvec2 _numTiles{1}; ///< of a sub-face; Triangle: x of the first row
    bool _isOneTile = false;
};

} // namespace hds
