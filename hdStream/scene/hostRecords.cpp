// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/hostRecords.h"

#include "hdStream/accel/chunkPages.h"
#include "hdStream/accel/chunkedGeometry.h"

namespace hds {

namespace {

/// What makes the source of a prim again, without the path.
constexpr std::uint64_t kRecipe = sizeof(GeometryInputs) + 80;

/// Of an allocation, with the counts of a shared pointer or the links of a map's node about.
constexpr std::uint64_t kBlock = 32;

std::uint64_t TextBytes(const std::string& text) {
    const bool isInside = text.capacity() < sizeof(std::string) / 2;
    return isInside ? 0 : text.capacity() + 1 + kBlock / 2;
}

template <typename T>
std::uint64_t ListBytes(const std::vector<T>& list) {
    return list.empty() ? 0 : list.capacity() * sizeof(T) + kBlock / 2;
}

std::uint64_t BytesOf(const GeometryDescription& geometry) {
    std::uint64_t bytes = sizeof(geometry) + kBlock + ListBytes(geometry.samples) +
                          ListBytes(geometry.primvars) + ListBytes(geometry.subsets);
    bytes += geometry.subdivTags.IsApart() ? sizeof(SubdivTags) + kBlock / 2 : 0;
    bytes += geometry.curves.IsApart() ? sizeof(CurveForm) + kBlock / 2 : 0;
    bytes += geometry.splatSamples.IsApart() ? sizeof(SplatSamples) + kBlock / 2 : 0;
    for (const Primvar& primvar : geometry.primvars) {
        bytes += TextBytes(primvar.name);
    }
    for (const MeshSubset& subset : geometry.subsets) {
        bytes += TextBytes(subset.name);
    }
    return bytes;
}

std::uint64_t BytesOf(const Placement& placement) {
    return TextBytes(placement.instancerPath) + ListBytes(placement.samples);
}

std::uint64_t BytesOf(const GeometrySummary& summary) {
    return ListBytes(summary.attributes) + ListBytes(summary.chunkBounds) +
           ListBytes(summary.numInChunk);
}

} // namespace

std::uint64_t DescribedBytes(const std::string& path, const GeometryPrim& prim) {
    return sizeof(path) + sizeof(prim) + kBlock + TextBytes(path) + TextBytes(prim.materialPath) +
           BytesOf(prim.placement) + ListBytes(prim.subsetMaterialPaths) +
           (prim.geometry ? BytesOf(*prim.geometry) : 0);
}

std::uint64_t DescribedBytes(const std::string& path, const InstancerPrim& prim) {
    return sizeof(path) + sizeof(prim) + kBlock + TextBytes(path) + BytesOf(prim.placement) +
           ListBytes(prim.primvars);
}

std::uint64_t PlannedBytes(const std::string& path, const PlannedGeometry& planned) {
    // The path is in the store and with what makes the source again.
    std::uint64_t bytes = 2 * (sizeof(path) + TextBytes(path)) + kRecipe + sizeof(planned) +
                          4 * kBlock + ListBytes(planned.attributes) + ListBytes(planned.topNodes) +
                          ListBytes(planned.chunks) +
                          planned.chunks.size() * (sizeof(ChunkPages) + kBlock);
    bytes += planned.attributes.size() * (sizeof(std::string) + kBlock / 2); // that are read
    if (planned.geometry) {
        bytes += sizeof(ChunkedGeometry) + kBlock + BytesOf(planned.geometry->Summary());
    }
    return bytes;
}

} // namespace hds
