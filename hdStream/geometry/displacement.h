// SPDX-License-Identifier: Apache-2.0
// How far a mesh's surface is moved along its normals, or by vectors, per material entry. Explained
// in docs/geometry.md.
#pragma once

#include "hdStream/geometry/chunkSource.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// Lowest and highest amount, object-space units.
struct AmountRange {
    double low = 0.0;
    double high = 0.0;
};

/// Attributes of a mesh whose shading adds what its triangles leave of its displacement
/// (docs/geometry.md, "What dicing leaves"): how far its points have moved, in object space, and
/// the normals that it had before; surfaces without normals have none. No primvar has such a name,
/// and all come before them.
constexpr const char* kMovedBy = "~movedBy";
constexpr const char* kRestNormals = "~restNormals";

/// A primvar that an amount reads.
struct AmountPrimvar {
    std::vector<std::string> names;  ///< the first that the mesh has
    std::uint32_t numComponents = 1; ///< that are read, 1 to 4
    std::array<double, 4> missing{}; ///< where the mesh has none of them
};

/// Where an amount is asked for.
struct AmountPoint {
    std::vector<std::array<double, 4>> primvars; ///< by DisplacementAmount::Primvars
    glm::dvec3 position{0.0};                    ///< object space, before it is displaced
};

/// All points between two, componentwise.
struct AmountBox {
    AmountPoint low;
    AmountPoint high;
};

/// How an amount moves a point: by a distance along the normal, or by a vector.
enum class DisplacementSpace {
    Normal,
    Tangent, ///< (along dP/ds, on the side of dP/dt, along the normal), all of length 1
    Object,
};

/// An amount as a function of primvars of the mesh and of the position. Immutable, thread-safe.
class DisplacementAmount {
public:
    virtual ~DisplacementAmount() = default;

    virtual const std::vector<AmountPrimvar>& Primvars() const = 0;
    virtual bool ReadsPosition() const { return false; }
    virtual DisplacementSpace Space() const { return DisplacementSpace::Normal; }
    /// Which of the Primvars has the s and t of DisplacementSpace::Tangent.
    virtual std::size_t Coordinates() const { return 0; }
    /// Along the normal; 0 of vectors. Finite. \param point has the values of all Primvars.
    virtual double At(const AmountPoint& point) const = 0;
    /// The vector; 0 of distances. Finite.
    virtual glm::dvec3 VectorAt(const AmountPoint& /*point*/) const { return glm::dvec3(0.0); }
    /// Range of At over a box, or from minus the greatest length of vectors to it; infinite where
    /// it cannot be told.
    virtual AmountRange Over(const AmountBox& box) const = 0;
};

/// The point where a mesh has none of the primvars.
AmountPoint MissingPoint(const DisplacementAmount& amount);

/// The same amount everywhere.
std::shared_ptr<const DisplacementAmount> MakeConstantAmount(double amount);

/// The first component of a primvar.
std::shared_ptr<const DisplacementAmount> MakePrimvarAmount(std::string primvar, double fallback);

/// By material entry: 0 the prim's, 1 + i subset i. Entries beyond the end and null ones are not
/// displaced.
using Displacement = std::vector<std::shared_ptr<const DisplacementAmount>>;

/// An entry's amount with the primvars found.
struct BoundAmount {
    static constexpr std::size_t kMissing = ~std::size_t{0};

    const DisplacementAmount* amount = nullptr; ///< null: `constant`
    std::vector<std::size_t> attributes;        ///< indices of the primvars, or kMissing
    double constant = 0.0;
};

/// Looks the primvars up; one that is missing, or too short, has the value that stands for it.
/// \return one per entry of `displacement`.
std::vector<BoundAmount> BindAmounts(const Displacement& displacement,
                                     const std::vector<GeometryAttribute>& attributes);

/// Range of the amounts of some entries, with 0 if others are used too. Reads all values of the
/// primvars, and all points where an amount depends on the position. Ends that cannot be told are
/// the length of the mesh's diagonal.
AmountRange RangeOf(const std::vector<BoundAmount>& amounts,
                    const std::vector<GeometryAttribute>& attributes,
                    const GeometryDescription& mesh, bool hasOthers);

/// Whether some amount is a vector.
bool HasVectors(const std::vector<BoundAmount>& amounts);

/// Whether some amount lacks the texture coordinates that its vectors need: they move along the
/// normal alone.
bool LacksCoordinates(const std::vector<BoundAmount>& amounts);
constexpr const char* kNoCoordinates = "vectors that displace it are in the frame of texture "
                                       "coordinates, which it has none of; what they have along "
                                       "the normal is used";

/// A surface's derivatives along two directions, with those of its texture coordinates.
struct CoordinateFrame {
    glm::dvec3 normal{0.0}; ///< of length 1
    glm::dvec3 pointU{0.0};
    glm::dvec3 pointV{0.0};
    glm::dvec2 coordinatesU{0.0};
    glm::dvec2 coordinatesV{0.0};
};

/// A vector in the frame of DisplacementSpace::Tangent, in object space. Where the coordinates span
/// nothing, only the part along the normal is left.
glm::dvec3 FromTangentSpace(const CoordinateFrame& frame, const glm::dvec3& vector);

/// The vector of an amount, no longer than the range allows.
glm::dvec3 LimitedVector(const DisplacementAmount& amount, const AmountPoint& point,
                         const AmountRange& range);

/// As PointAmounts: by vectors, in object space; empty where there are none. \param normals of the
/// points of the pose
std::vector<glm::dvec3> PointVectors(const GeometryDescription& mesh,
                                     const SharedSpan<float>& points,
                                     const GeometryAttribute& normals, const AmountRange& range,
                                     const std::vector<std::uint32_t>& entries,
                                     const std::vector<GeometryAttribute>& attributes,
                                     const Displacement& displacement);

/// Amounts for the points of polygons: the mean over the face-vertices at each point, so that what
/// shares a point stays closed. Points that no face uses get 0.
/// \param entries material entry by authored face; empty: all 0. \param points of the mesh or of
/// one of its poses. \param range of the amounts, which none leaves.
std::vector<float> PointAmounts(const GeometryDescription& mesh, const SharedSpan<float>& points,
                                const AmountRange& range, const std::vector<std::uint32_t>& entries,
                                const std::vector<GeometryAttribute>& attributes,
                                const Displacement& displacement);

} // namespace hds
