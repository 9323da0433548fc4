// SPDX-License-Identifier: Apache-2.0
// The sampling tables of images on lights (kernels/light/dome.clh, kernels/light/rectImage.clh).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace hds {

/// A mip of a light's image in the linear working space, top row first: small enough for a
/// distribution (FindTableMip).
struct LightImage {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> rgb; ///< [height][width][3], finite and not negative
    std::uint32_t mip = 0;  ///< which of the image's it is
};

/// The image of a light, and its index among the scene's textures.
struct LightTexture {
    std::shared_ptr<const LightImage> image; ///< null: it cannot be read
    std::uint32_t index = 0;
};

/// The mip of an image that its distribution is made of: the finest of at most 2^21 texels, and of
/// at most 8192 in a row or a column. 2048 x 1024 cells of a dome are 0.18 degrees wide, a third of
/// the sun, and take 24 MB.
std::uint32_t FindTableMip(std::uint32_t width, std::uint32_t height);

/// Distribution of a light's directions or points, in proportion to the luminance of the image's
/// bilinear lookup; no cell is without a share, since finer mips are looked up too.
struct LightImageTable {
    std::uint32_t width = 0;    ///< cells in a row
    std::uint32_t numRows = 0;  ///< of cells
    std::vector<float> cdf;     ///< marginal [numRows + 1], then conditionals [numRows][width + 1];
                                ///< of a dome then the texels, [height][width][2] words
                                ///< (kernels/light/domeImage.clh)
    double meanLuminance = 0.0; ///< over the sphere of directions, or the image
};

/// For a dome's latitude-longitude image, by solid angle. Cells lie between the centres of texels
/// (kernels/light/dome.clh), so there is a row more than the image has. Cost: O(pixels), on all
/// cores; the result does not depend on their number. A black image gives a uniform distribution.
/// Where BSDF samples find the light too, they are left what is everywhere: a cell's share is by
/// what it has beyond half of the mean luminance (after Karlik, Sik, Vevoda, Skrivan, Krivanek
/// 2019, "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling",
/// equation 16, which takes the whole mean off). docs/lights.md has what that saves.
/// \param leavesMean that is so. Not where only light samples find the light (HDS_LIGHT_SAMPLED),
/// and not of domes with portals, through which BSDF samples seldom come.
LightImageTable BuildLatLongTable(const LightImage& image, bool leavesMean);

/// The same for an image on a flat light, by area. Its cells are the texels.
LightImageTable BuildFlatTable(const LightImage& image);

/// What portals need of a distribution: the mass of all cells above row y and left of column x, at
/// [y * (width + 1) + x]. No cell is without mass, and all together have less than 2^32.
/// \param cdf of LightImageTable.
std::vector<std::uint32_t> SumCells(const float* cdf, std::uint32_t width, std::uint32_t numRows);

} // namespace hds
