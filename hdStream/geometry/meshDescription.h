// SPDX-License-Identifier: Apache-2.0
// A mesh as the front ends translate it: authored data, nothing interpreted.
// Explained in docs/architecture.md.
#pragma once

#include "hdStream/base/sharedSpan.h"

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// Hydra's interpolations of a primvar.
enum class Interpolation { Constant, Uniform, Varying, Vertex, FaceVarying, Instance };

/// A named array of values on a prim. Values are tuples of 1 to 4 floats (integers are converted).
struct Primvar {
    std::string name; ///< without "primvars:"; authored normals are the primvar "normals"
    Interpolation interpolation = Interpolation::Constant;
    std::uint32_t numComponents = 1;  ///< 1 to 4
    SharedSpan<float> values;         ///< [count][numComponents]
    SharedSpan<std::int32_t> indices; ///< empty: values are used in order
};

/// A face set that may have a material of its own (MeshPrim::subsetMaterialPaths).
struct MeshSubset {
    std::string name; ///< the subset's prim path
    SharedSpan<std::int32_t> faces;
};

/// OpenSubdiv tags, as authored on the mesh.
struct SubdivTags {
    std::string interpolateBoundary = "edgeAndCorner";
    std::string faceVaryingLinearInterpolation = "cornersPlus1";
    std::string triangleSubdivisionRule = "catmullClark";
    SharedSpan<std::int32_t> creaseIndices;
    SharedSpan<std::int32_t> creaseLengths;
    SharedSpan<float> creaseSharpnesses;
    SharedSpan<std::int32_t> cornerIndices;
    SharedSpan<float> cornerSharpnesses;
};

/// What a description is made of.
enum class PrimitiveKind {
    Faces,
    Curves, ///< UsdGeomBasisCurves: round, or ribbons where there are normals
    Points, ///< UsdGeomPoints: spheres
};

/// How the points of curves become curves (UsdGeomBasisCurves).
struct CurveForm {
    std::string type = "cubic";       ///< linear, cubic
    std::string basis = "bezier";     ///< of cubic ones: bezier, bspline, catmullRom
    std::string wrap = "nonperiodic"; ///< periodic, pinned; segmented: pairs, lines of draw modes
};

/// Points at a time, in frames from the frame on.
struct PointSample {
    double time = 0.0;
    SharedSpan<float> points; ///< as MeshDescription::points
};

/// Topology, points and primvars of a mesh, of curves or of points. Object space, float as
/// authored. Widths and normals are primvars of these names.
struct MeshDescription {
    PrimitiveKind primitives = PrimitiveKind::Faces;
    SharedSpan<float> points; ///< [numPoints][3]
    /// The points around the frame, in ascending order of time; fewer than two: they are at rest.
    std::vector<PointSample> samples;
    /// Where commit lets points go straight to while the shutter is open; empty: nowhere.
    SharedSpan<float> closePoints;
    SharedSpan<std::int32_t> faceVertexCounts;  ///< curves: vertices of each curve
    SharedSpan<std::int32_t> faceVertexIndices; ///< curves: empty: points in their order
    CurveForm curves;
    SharedSpan<std::int32_t> holeIndices;   ///< faces left out
    std::string subdivisionScheme = "none"; ///< none, bilinear, catmullClark, loop
    SubdivTags subdivTags;
    bool leftHanded = false;
    std::vector<Primvar> primvars;
    std::vector<MeshSubset> subsets;
};

} // namespace hds
