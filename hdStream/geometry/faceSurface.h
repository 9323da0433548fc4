// SPDX-License-Identifier: Apache-2.0
// The limit surface of one cage face, ready to be evaluated. Internal to geometry. Explained in
// docs/geometry.md.
#pragma once

#include "hdStream/geometry/subdivModel.h"

#include <glm/vec3.hpp>

#include <array>
#include <memory>
#include <unordered_map>
#include <vector>

namespace hds {

/// A point of the limit surface with its first derivatives, object space.
struct SurfaceFrame {
    glm::dvec3 point{0.0};
    glm::dvec3 tangentU{0.0};
    glm::dvec3 tangentV{0.0};
};

/// The same with second derivatives.
struct SurfaceFrame2 : SurfaceFrame {
    glm::dvec3 uu{0.0};
    glm::dvec3 uv{0.0};
    glm::dvec3 vv{0.0};
};

/// Evaluates one drawn face; primvars are prepared when first asked for. Values are in double.
/// Externally synchronised; the model must outlive it.
class FaceSurface {
public:
    FaceSurface(const SubdivModel& model, int face);

    bool IsRegular() const { return _surface.IsRegular(); }
    glm::dvec3 Point(const FacePoint& at) const;
    SurfaceFrame Frame(const FacePoint& at) const;
    SurfaceFrame2 Frame2(const FacePoint& at) const;
    /// Unit, towards the authored front. Where tangents vanish, that of a point nearby; never zero.
    glm::dvec3 Normal(const FacePoint& at, const SurfaceFrame& frame) const;

    /// Points of the cage that the surface is made of.
    void ControlPoints(std::vector<int>& points) const;

    /// Rows of SubdivModel::VertexRows, VaryingRows and ChannelRows at a point.
    void VertexValues(const FacePoint& at, double* values);
    void VaryingValues(const FacePoint& at, double* values);
    void ChannelValues(int channel, const FacePoint& at, double* values);

private:
    using Surface = OpenSubdiv::Bfr::Surface<double>;
    /// A surface over rows of any size.
    struct Prepared {
        Surface surface;
        int rowSize = 0;
        std::vector<double> points;
    };

    std::array<double, 2> Coordinates(const FacePoint& at) const;
    const double* Points() const;
    void Prepare(const ValueRows& rows, Prepared& prepared) const;
    void Evaluate(const Prepared& prepared, const FacePoint& at, double* values) const;

    const SubdivModel& _model;
    int _face;
    FaceShape _shape;
    Surface _surface;
    mutable std::vector<double> _points; ///< patch points, once something is evaluated
    std::unique_ptr<Prepared> _vertex;
    std::unique_ptr<Prepared> _varying;
    std::vector<std::unique_ptr<Prepared>> _channels;
};

/// The faces that a piece of work touches. Externally synchronised.
class FaceSurfaces {
public:
    explicit FaceSurfaces(const SubdivModel& model) : _model(model) {}
    /// Valid as long as this lives. Precondition: the face is drawn.
    FaceSurface& At(int face);

private:
    const SubdivModel& _model;
    std::unordered_map<int, std::unique_ptr<FaceSurface>> _faces;
};

/// The middle of a face.
FacePoint FaceCentre(FaceShape shape);

} // namespace hds
