// SPDX-License-Identifier: Apache-2.0
// A deep picture: of each pixel the surfaces that its camera rays end on, each with how deep it
// lies, how much it covers, and its light. Laid over each other they are the flat picture.
// Source: Kainz, Bogart, Stanczyk, Hillman 2013, "Interpreting OpenEXR Deep Pixels".
// Explained in docs/film.md.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace hds {

/// A surface in a pixel. It covers `color[3]` of what the samples before it leave free.
struct DeepSample {
    float z = 0.0F;     ///< along the camera's -Z, in scene units: where it begins
    float zBack = 0.0F; ///< where it ends, >= z
    /// R, G, B, premultiplied, and A, over what the samples before it leave free.
    std::array<float, 4> color{};
};

/// Samples of all pixels, those of a pixel one behind another: none begins before the one before
/// it ends.
struct DeepImage {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<std::uint32_t> counts; ///< [height][width]: samples in a pixel
    std::vector<DeepSample> samples;   ///< pixel by pixel
};

/// How samples of a pixel become one.
struct DeepLimits {
    /// Of one surface, whose depths differ from that of the first by at most this share of it.
    float tolerance = 0.01F;
    std::uint32_t mostSamples = 64; ///< in a pixel, at least 1
    float farDepth = 1e30F;         ///< of what shines behind everything
};

/// What the camera ray of a sample of a pixel has ended on, and what its path has found.
struct DeepHit {
    /// What is told apart: the prim and its instance; HDS_NONE and HDS_DEEP_LIGHT, HDS_DEEP_VOLUME
    /// or 0: nothing.
    std::pair<std::uint32_t, std::uint32_t> surface;
    float depth = 0.0F;            ///< may be infinite: unknown
    std::array<float, 4> radiance; ///< R, G, B, alpha
};

/// Deep samples while samples come in. The result depends on the order of the samples of each
/// pixel, and on nothing else. Memory: 8 bytes a pixel and 56 for each deep sample, of which a
/// pixel has DeepLimits::mostSamples at most. Externally synchronised.
class DeepSums {
public:
    /// No samples.
    void Reset(std::uint32_t width, std::uint32_t height, const DeepLimits& limits);

    /// A sample that shows nothing; it counts all the same.
    void AddNothing(std::uint32_t pixel) { ++_numSamples[pixel]; }
    void Add(std::uint32_t pixel, const DeepHit& hit);

    DeepImage Make() const;

    std::uint64_t Bytes() const;
    /// Samples that have joined another surface than their own, because the pixel had no room.
    std::uint64_t NumCrowded() const { return _numCrowded; }

private:
    /// What has joined in a pixel.
    struct Node {
        std::pair<std::uint32_t, std::uint32_t> surface;
        float first = 0.0F; ///< depth of the sample that came first
        float least = 0.0F;
        float most = 0.0F;
        std::uint32_t next = 0; ///< node of the same pixel
        std::array<double, 4> sum{};
    };
    static_assert(sizeof(Node) == 56);

    static constexpr std::uint32_t kChunkBits = 14;
    static constexpr std::uint32_t kChunkSize = 1U << kChunkBits;

    Node& At(std::uint32_t index) { return (*_chunks[index >> kChunkBits])[index % kChunkSize]; }
    const Node& At(std::uint32_t index) const {
        return (*_chunks[index >> kChunkBits])[index % kChunkSize];
    }
    Node& Find(std::uint32_t pixel, const DeepHit& hit);
    Node& Append(std::uint32_t pixel, const DeepHit& hit);
    void MakePixel(std::uint32_t pixel, std::vector<Node>* nodes, DeepImage* image) const;

    std::uint32_t _width = 0;
    std::uint32_t _height = 0;
    DeepLimits _limits;
    std::vector<std::uint32_t> _numSamples; ///< by pixel
    std::vector<std::uint32_t> _heads;      ///< by pixel: the node that came last
    std::vector<std::unique_ptr<std::array<Node, kChunkSize>>> _chunks;
    std::uint32_t _numNodes = 0;
    std::uint64_t _numCrowded = 0;
};

} // namespace hds
