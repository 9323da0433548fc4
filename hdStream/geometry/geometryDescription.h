// SPDX-License-Identifier: Apache-2.0
// A mesh, curves or points as the front ends translate them: authored data, nothing interpreted.
// Explained in docs/architecture.md.
#pragma once

#include "hdStream/base/apart.h"
#include "hdStream/base/enumTable.h"
#include "hdStream/base/fields.h"
#include "hdStream/base/sharedSpan.h"

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// Hydra's interpolations of a primvar.
enum class Interpolation { Constant, Uniform, Varying, Vertex, FaceVarying, Instance };

constexpr EnumTable<Interpolation, 6> NamesOf(Interpolation) {
    return {{{Interpolation::Constant, "Constant", "constant"},
             {Interpolation::Uniform, "Uniform", "uniform"},
             {Interpolation::Varying, "Varying", "varying"},
             {Interpolation::Vertex, "Vertex", "vertex"},
             {Interpolation::FaceVarying, "FaceVarying", "faceVarying"},
             {Interpolation::Instance, "Instance", "instance"}}};
}

/// A named array of values on a prim. Values are tuples of 1 to 4 floats (integers are converted).
struct Primvar {
    std::string name; ///< without "primvars:"; authored normals are the primvar "normals"
    Interpolation interpolation = Interpolation::Constant;
    std::uint32_t numComponents = 1;  ///< 1 to 4
    SharedSpan<float> values;         ///< [count][numComponents]
    SharedSpan<std::int32_t> indices; ///< empty: values are used in order
    std::string colorSpace = {};      ///< of the values; empty: none is said

    static constexpr auto Fields() {
        return FieldList(
            HDS_FIELD(Primvar, name), HDS_FIELD(Primvar, interpolation),
            HDS_FIELD(Primvar, numComponents),
            HDS_FIELD(Primvar, values).NotInPython("rows of numComponents"),
            HDS_FIELD(Primvar, indices),
            HDS_FIELD(Primvar, colorSpace).NotInKey("pages have values in the working space"));
    }
};

/// A face set that may have a material of its own (GeometryPrim::subsetMaterialPaths).
struct MeshSubset {
    std::string name; ///< the subset's prim path
    SharedSpan<std::int32_t> faces;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(MeshSubset, name).NotInKey("names are no part of pages"),
                         HDS_FIELD(MeshSubset, faces));
    }
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

    static constexpr auto Fields() {
        return FieldList(
            HDS_FIELD(SubdivTags, interpolateBoundary),
            HDS_FIELD(SubdivTags, faceVaryingLinearInterpolation),
            HDS_FIELD(SubdivTags, triangleSubdivisionRule), HDS_FIELD(SubdivTags, creaseIndices),
            HDS_FIELD(SubdivTags, creaseLengths), HDS_FIELD(SubdivTags, creaseSharpnesses),
            HDS_FIELD(SubdivTags, cornerIndices), HDS_FIELD(SubdivTags, cornerSharpnesses));
    }
};

/// What a description is made of.
enum class PrimitiveKind {
    Faces,
    Curves, ///< UsdGeomBasisCurves: round, or ribbons where there are normals
    Points, ///< UsdGeomPoints: spheres
    Splats, ///< UsdVolParticleField3DGaussianSplat; their shapes are primvars of the points
};

constexpr EnumTable<PrimitiveKind, 4> NamesOf(PrimitiveKind) {
    return {{{PrimitiveKind::Faces, "Faces", "mesh"},
             {PrimitiveKind::Curves, "Curves", "curves"},
             {PrimitiveKind::Points, "Points", "points"},
             {PrimitiveKind::Splats, "Splats", "splats"}}};
}

/// How the points of curves become curves (UsdGeomBasisCurves).
struct CurveForm {
    std::string type = "cubic";       ///< linear, cubic
    std::string basis = "bezier";     ///< of cubic ones: bezier, bspline, catmullRom
    std::string wrap = "nonperiodic"; ///< periodic, pinned; segmented: pairs, lines of draw modes

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(CurveForm, type), HDS_FIELD(CurveForm, basis),
                         HDS_FIELD(CurveForm, wrap));
    }
};

/// Points at a time, in frames from the frame on.
struct PointSample {
    double time = 0.0;
    SharedSpan<float> points; ///< as GeometryDescription::points

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(PointSample, time), HDS_FIELD(PointSample, points).Rows(3));
    }
};

/// Values of a primvar at a time, in frames from the frame on.
struct FloatSample {
    double time = 0.0;
    SharedSpan<float> values; ///< as Primvar::values

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(FloatSample, time), HDS_FIELD(FloatSample, values));
    }
};

/// The shapes of Gaussian splats around the frame: samples of as many values as the primvars of
/// these names have. Fewer than two: they are those of the frame.
struct SplatSamples {
    std::vector<FloatSample> orientations; ///< on the shorter arc from one to the next
    std::vector<FloatSample> scales;
    std::vector<FloatSample> opacities;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(SplatSamples, orientations), HDS_FIELD(SplatSamples, scales),
                         HDS_FIELD(SplatSamples, opacities));
    }
};

/// What moves, at a time while the shutter is open.
struct ShutterKey {
    SharedSpan<float> points;       ///< as GeometryDescription::points
    SharedSpan<float> widths;       ///< values of the primvar; empty: they do not change
    SharedSpan<float> normals;      ///< the same, as of those of splats
    SharedSpan<float> orientations; ///< of unit length
    SharedSpan<float> scales;
    SharedSpan<float> opacities;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(ShutterKey, points), HDS_FIELD(ShutterKey, widths),
                         HDS_FIELD(ShutterKey, normals), HDS_FIELD(ShutterKey, orientations),
                         HDS_FIELD(ShutterKey, scales), HDS_FIELD(ShutterKey, opacities));
    }
};

/// Topology, points and primvars of a mesh, of curves or of points. Object space, float as
/// authored. Widths and normals are primvars of these names.
struct GeometryDescription {
    PrimitiveKind primitives = PrimitiveKind::Faces;
    SharedSpan<float> points; ///< [numPoints][3]
    /// The points around the frame, in ascending order of time; fewer than two: they are at rest.
    std::vector<PointSample> samples;
    /// The same of the primvars "widths" (of curves and points) and "normals" (of faces): samples
    /// of as many values. Fewer than two: they are those of the frame.
    std::vector<FloatSample> widthSamples;
    std::vector<PointSample> normalSamples;
    Apart<SplatSamples> splatSamples;
    /// Where commit lets all go while the shutter is open, straight from one to the next: at equal
    /// steps of time, the last one when it closes. `points` are where it opens. Empty: nowhere.
    std::vector<ShutterKey> keys;
    SharedSpan<std::int32_t> faceVertexCounts;  ///< curves: vertices of each curve
    SharedSpan<std::int32_t> faceVertexIndices; ///< curves: empty: points in their order
    Apart<CurveForm> curves;
    SharedSpan<std::int32_t> holeIndices;   ///< faces left out
    std::string subdivisionScheme = "none"; ///< none, bilinear, catmullClark, loop
    Apart<SubdivTags> subdivTags;
    bool leftHanded = false;
    std::vector<Primvar> primvars;
    std::vector<MeshSubset> subsets;

    static constexpr auto Fields() {
        constexpr auto kFaces = PrimitiveKind::Faces;
        constexpr auto kCurves = PrimitiveKind::Curves;
        return FieldList(HDS_FIELD(GeometryDescription, primitives),
                         HDS_FIELD(GeometryDescription, points).Rows(3),
                         HDS_FIELD(GeometryDescription, samples)
                             .NotInKey("MakeGeometryKey adds them while the shutter is open"),
                         HDS_FIELD(GeometryDescription, widthSamples)
                             .For(kCurves, PrimitiveKind::Points)
                             .NotInKey("MakeGeometryKey adds them while the shutter is open"),
                         HDS_FIELD(GeometryDescription, normalSamples)
                             .For(kFaces)
                             .NotInKey("MakeGeometryKey adds them while the shutter is open"),
                         HDS_FIELD(GeometryDescription, splatSamples)
                             .For(PrimitiveKind::Splats)
                             .NotInKey("MakeGeometryKey adds them while the shutter is open"),
                         HDS_FIELD(GeometryDescription, keys)
                             .NotInKey("made of samples and the shutter")
                             .NotInDump("no front end sets it")
                             .NotInPython("no front end sets it"),
                         HDS_FIELD(GeometryDescription, faceVertexCounts).For(kFaces, kCurves),
                         HDS_FIELD(GeometryDescription, faceVertexIndices).For(kFaces, kCurves),
                         HDS_FIELD(GeometryDescription, curves).For(kCurves),
                         HDS_FIELD(GeometryDescription, holeIndices).For(kFaces),
                         HDS_FIELD(GeometryDescription, subdivisionScheme).For(kFaces),
                         HDS_FIELD(GeometryDescription, subdivTags).For(kFaces),
                         HDS_FIELD(GeometryDescription, leftHanded).For(kFaces),
                         HDS_FIELD(GeometryDescription, primvars),
                         HDS_FIELD(GeometryDescription, subsets));
    }
};

} // namespace hds
