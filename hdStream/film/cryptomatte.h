// SPDX-License-Identifier: Apache-2.0
// Cryptomatte: which share of a pixel belongs to which object, material or instance, as layers of
// ids and coverages with the names in the header of the file.
// Source: Friedman and Jones 2015, "Fully Automatic ID Mattes with Support for Motion Blur and
// Transparency"; Psyop, Cryptomatte specification 1.2.0. Explained in docs/film.md.
#pragma once

#include "hdStream/film/imageLayer.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace hds {

/// What a matte tells apart.
enum class MatteKind { Object, Material, Instance };

/// Layers of a Cryptomatte that its name alone stands for: two ranks each.
constexpr std::uint32_t kMatteLayers = 3;
/// Layers that can be asked for one by one.
constexpr std::uint32_t kMaxMatteLayers = 8;

/// An AOV that is a layer of a Cryptomatte.
struct MatteAov {
    MatteKind kind = MatteKind::Object;
    std::string cryptomatte;            ///< name of the Cryptomatte: crypto_object
    std::optional<std::uint32_t> layer; ///< nothing: the name stands for all its layers
};

/// \return nothing when the name is no such AOV's.
std::optional<MatteAov> ParseMatteAov(const std::string& name);
/// Of a layer: crypto_object00.
std::string MatteLayerName(const std::string& cryptomatte, std::uint32_t layer);

/// The id of a name: MurmurHash3 (Appleby 2011, x86, 32 bits, seed 0), changed in one bit where the
/// float of these bits would be no normal number.
std::uint32_t MatteId(const std::string& name);

/// The surface that the camera ray of a sample met first, in the numbers of a committed scene.
struct MatteSurface {
    std::uint32_t prim = 0;    ///< of the scene's prims
    std::uint32_t entry = 0;   ///< of its material entries
    std::int32_t instance = 0; ///< as the AOV instanceId

    bool operator==(const MatteSurface& other) const {
        return prim == other.prim && entry == other.entry && instance == other.instance;
    }
};

/// How many samples of a pixel have met a surface.
struct MatteCount {
    std::uint32_t pixel = 0; ///< y * width + x
    MatteSurface surface;
    std::uint32_t count = 0;
};
static_assert(sizeof(MatteCount) == 5 * sizeof(std::uint32_t)); // as farms ship it

/// Name of a surface, by kind.
using MatteNamer = std::function<std::string(MatteKind, const MatteSurface&)>;

/// Counts of all pixels. Whole numbers: their sums depend on no order. Externally synchronised.
class MatteSums {
public:
    /// No samples.
    void Reset(std::uint32_t width, std::uint32_t height);

    /// A sample of a pixel that has met nothing, or that a caller of Add counts.
    void AddSample(std::uint32_t pixel) { ++_numSamples[pixel]; }
    void Add(std::uint32_t pixel, const MatteSurface& surface, std::uint32_t count);
    /// Says how many samples a pixel has.
    void SetSamples(std::uint32_t pixel, std::uint32_t count) { _numSamples[pixel] = count; }

    /// All of them, by pixel, then by surface.
    std::vector<MatteCount> Counts() const;

    /// The first layers of a Cryptomatte: in each pixel the ids of largest coverage first, of equal
    /// ones the lower id. Headers have the names of all that is seen.
    std::vector<ImageLayer> MakeLayers(MatteKind kind, const std::string& cryptomatte,
                                       std::uint32_t numLayers, const MatteNamer& nameOf) const;

private:
    /// Samples of one surface in one pixel.
    struct Share {
        std::uint32_t surface = 0; ///< index in _surfaces
        std::uint32_t count = 0;
    };
    struct SurfaceHash {
        std::size_t operator()(const MatteSurface& surface) const noexcept;
    };

    std::vector<Share> SharesOf(std::uint32_t pixel) const;

    std::uint32_t _width = 0;
    std::uint32_t _height = 0;
    std::vector<std::uint32_t> _numSamples;
    std::vector<MatteSurface> _surfaces;
    std::unordered_map<MatteSurface, std::uint32_t, SurfaceHash> _indices; ///< in _surfaces
    std::vector<Share> _first; ///< by pixel: the surface that came first
    std::unordered_map<std::uint32_t, std::vector<Share>> _others; ///< by pixel
};

} // namespace hds
