// SPDX-License-Identifier: Apache-2.0
// How far a mesh's surface is moved along its normals, per material entry (UsdPreviewSurface
// displacement). Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/chunkSource.h"

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

/// An amount as a function of one primvar of the mesh. Immutable, thread-safe. What is known now:
/// constants and primvars. A texture is one more, a function of its coordinates.
class DisplacementAmount {
public:
    virtual ~DisplacementAmount() = default;

    /// Name of the primvar; empty: none is read.
    virtual const std::string& Primvar() const = 0;
    /// Components of the primvar that At reads.
    virtual std::uint32_t NumComponents() const = 0;
    /// The amount where the primvar is `value`; finite. \param value [NumComponents()]
    virtual double At(const double* value) const = 0;
    /// Range of At over all values between `low` and `high`, componentwise.
    virtual AmountRange Over(const double* low, const double* high) const = 0;
    /// Where the mesh has no such primvar.
    virtual double Fallback() const = 0;
};

/// The same amount everywhere.
std::shared_ptr<const DisplacementAmount> MakeConstantAmount(double amount);

/// The first component of a primvar.
std::shared_ptr<const DisplacementAmount> MakePrimvarAmount(std::string primvar, double fallback);

/// By material entry: 0 the prim's, 1 + i subset i. Entries beyond the end and null ones are not
/// displaced.
using Displacement = std::vector<std::shared_ptr<const DisplacementAmount>>;

/// An entry's amount with the primvar found.
struct BoundAmount {
    const DisplacementAmount* amount = nullptr; ///< null: `constant`
    std::size_t attribute = 0;                  ///< index of the primvar
    double constant = 0.0;
};

/// Looks the primvars up; one that is missing, or too short, leaves the fallback.
/// \return one per entry of `displacement`.
std::vector<BoundAmount> BindAmounts(const Displacement& displacement,
                                     const std::vector<GeometryAttribute>& attributes);

/// Range of the amounts of some entries, with 0 if others are used too. Reads all values of the
/// primvars.
AmountRange RangeOf(const std::vector<BoundAmount>& amounts,
                    const std::vector<GeometryAttribute>& attributes, bool hasOthers);

/// Amounts for the points of polygons: the mean over the face-vertices at each point, so that what
/// shares a point stays closed. Points that no face uses get 0.
/// \param entries material entry by authored face; empty: all 0.
std::vector<float> PointAmounts(const GeometryDescription& mesh,
                                const std::vector<std::uint32_t>& entries,
                                const std::vector<GeometryAttribute>& attributes,
                                const Displacement& displacement);

} // namespace hds
