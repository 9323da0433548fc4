// SPDX-License-Identifier: Apache-2.0
// Measured distributions of luminous intensity: files of ANSI/IES LM-63 (1986 to 2019).
// Explained in docs/lights.md.
#pragma once

#include <string>
#include <vector>

namespace hds {

/// A profile in spherical coordinates about the nadir (photometric type C), made complete: its
/// azimuths go around.
struct IesProfile {
    std::vector<float> polars;   ///< radians from the nadir, ascending, at least 2
    std::vector<float> azimuths; ///< radians, from 0 to 2 pi, ascending, at least 2
    std::vector<float> candela;  ///< [azimuths][polars], not negative

    /// The mean intensity over the sphere, or over the hemisphere when the polar angles span no
    /// more: what UsdLux's `ies:normalize` divides by. Exact for the bilinear interpolation.
    double MeanIntensity() const;
};

/// Reads the text of a file. TILT data are skipped: they hold for other burning positions.
/// \param[out] error empty, or why it cannot be used (a part of a sentence).
IesProfile ParseIesProfile(const std::string& text, std::string* error);

} // namespace hds
