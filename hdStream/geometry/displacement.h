// SPDX-License-Identifier: Apache-2.0
// How far a mesh's surface is moved along its normals, per material entry. Explained in
// docs/geometry.md.
#pragma once

#include "hdStream/geometry/chunkSource.h"

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

/// An amount as a function of primvars of the mesh and of the position. Immutable, thread-safe.
class DisplacementAmount {
public:
    virtual ~DisplacementAmount() = default;

    virtual const std::vector<AmountPrimvar>& Primvars() const = 0;
    virtual bool ReadsPosition() const { return false; }
    /// Finite. \param point has the values of all Primvars.
    virtual double At(const AmountPoint& point) const = 0;
    /// Range of At over a box; infinite where it cannot be told.
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

/// Amounts for the points of polygons: the mean over the face-vertices at each point, so that what
/// shares a point stays closed. Points that no face uses get 0.
/// \param entries material entry by authored face; empty: all 0. \param points of the mesh or of
/// one of its poses. \param range of the amounts, which none leaves.
std::vector<float> PointAmounts(const GeometryDescription& mesh, const SharedSpan<float>& points,
                                const AmountRange& range, const std::vector<std::uint32_t>& entries,
                                const std::vector<GeometryAttribute>& attributes,
                                const Displacement& displacement);

} // namespace hds
