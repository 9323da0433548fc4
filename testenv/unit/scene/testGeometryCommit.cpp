// SPDX-License-Identifier: Apache-2.0
// Prepared meshes keep every triangle exactly once within the chunk bound; their names in the cache
// follow what they are made of.
#include "hdStream/scene/geometryCommit.h"

#include "hdStream/scene/geometryKey.h"

#include "testenv/support/pageView.h"
#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

namespace hds {
namespace {

/// A grid of quads in the plane z = 0.
GeometryDescription Grid(std::int32_t size, const std::string& scheme) {
    GeometryDescription mesh;
    std::vector<float> points;
    std::vector<std::int32_t> counts;
    std::vector<std::int32_t> indices;
    for (std::int32_t y = 0; y <= size; ++y) {
        for (std::int32_t x = 0; x <= size; ++x) {
            points.insert(points.end(), {static_cast<float>(x), static_cast<float>(y), 0.0F});
        }
    }
    for (std::int32_t y = 0; y < size; ++y) {
        for (std::int32_t x = 0; x < size; ++x) {
            const std::int32_t corner = y * (size + 1) + x;
            counts.push_back(4);
            indices.insert(indices.end(),
                           {corner, corner + 1, corner + size + 2, corner + size + 1});
        }
    }
    mesh.points = std::move(points);
    mesh.faceVertexCounts = std::move(counts);
    mesh.faceVertexIndices = std::move(indices);
    mesh.subdivisionScheme = scheme;
    return mesh;
}

PlannedGeometry Prepare(const GeometryDescription& mesh, GeometryInputs inputs) {
    static Warnings warnings; // outlives the meshes
    inputs.geometry = std::make_shared<GeometryDescription>(mesh);
    return PlanGeometry("/grid", std::make_shared<const GeometryInputs>(inputs), nullptr, warnings);
}

TEST(GeometryCommit, EveryTriangleIsInOneChunkWithinTheBound) {
    for (const std::uint64_t chunkBytes :
         {std::uint64_t{4096}, std::uint64_t{16384}, std::uint64_t{1} << 20U}) {
        GeometryInputs inputs;
        inputs.chunkBytes = chunkBytes;
        const PlannedGeometry mesh = Prepare(Grid(40, "none"), inputs);
        std::vector<int> seen(40 * 40, 0);
        for (const std::shared_ptr<ChunkPages>& chunk : mesh.chunks) {
            const std::uint64_t bound =
                chunk->Bytes(HDS_PAGE_GEOMETRY) + chunk->Bytes(HDS_PAGE_ATTRIBUTES);
            EXPECT_FALSE(chunk->IsExact());
            EXPECT_EQ(chunk->Prepare({true, true}), ChunkPages::Made::Built);
            const std::uint64_t bytes =
                chunk->Bytes(HDS_PAGE_GEOMETRY) + chunk->Bytes(HDS_PAGE_ATTRIBUTES);
            EXPECT_TRUE(chunk->IsExact());
            EXPECT_EQ(bytes, chunk->DataBytes());
            EXPECT_LE(bytes, bound);
            EXPECT_LE(bytes, chunkBytes);
        }
        const auto cut = mesh.geometry->Hold();
        const ChunkPlan& plan = cut->plan;
        for (std::size_t i = 0; i < plan.NumChunks(); ++i) {
            const ChunkGeometry geometry = cut->source->Gather(plan.groups.data() + plan.begin[i],
                                                               plan.begin[i + 1] - plan.begin[i]);
            EXPECT_EQ(geometry.triangles.size(), plan.counts[i]);
            for (const std::uint32_t face : geometry.faces) {
                ++seen.at(face);
            }
        }
        EXPECT_EQ(seen, std::vector<int>(seen.size(), 2));
        EXPECT_EQ(mesh.topNodes.empty(), mesh.chunks.size() == 1);
    }
}

/// The prepared grid with a store in `folder`, and a chunk of it made ready.
PlannedGeometry PrepareStored(const GeometryDescription& grid, const std::string& folder,
                              Warnings* warnings) {
    PageStoreOptions options;
    options.directory = folder;
    GeometryInputs inputs;
    inputs.chunkBytes = 4096;
    inputs.geometry = std::make_shared<GeometryDescription>(grid);
    return PlanGeometry("/grid", std::make_shared<const GeometryInputs>(inputs),
                        std::make_shared<PageStore>(options, warnings), *warnings);
}

TEST(GeometryCommit, ASecondRunTakesTheSummaryFromTheStore) {
    const test::TemporaryFolder folder;
    Warnings warnings;
    const GeometryDescription grid = Grid(40, "none");
    const PlannedGeometry first = PrepareStored(grid, folder.Path(), &warnings);
    ASSERT_GT(first.chunks.size(), 10U);
    EXPECT_EQ(first.chunks[3]->Prepare({true, true}), ChunkPages::Made::Built);
    const auto page = first.chunks[3]->Data(HDS_PAGE_GEOMETRY);

    const PlannedGeometry second = PrepareStored(grid, folder.Path(), &warnings);
    EXPECT_EQ(SerializeSummary(second.geometry->Summary()),
              SerializeSummary(first.geometry->Summary()));
    ASSERT_EQ(second.topNodes.size(), first.topNodes.size());
    EXPECT_EQ(std::memcmp(second.topNodes.data(), first.topNodes.data(),
                          first.topNodes.size() * sizeof(first.topNodes[0])),
              0);
    EXPECT_EQ(second.chunks[3]->Prepare({true, true}), ChunkPages::Made::Loaded);
    EXPECT_EQ(second.chunks[3]->Data(HDS_PAGE_GEOMETRY), page);
    EXPECT_EQ(second.chunks[4]->Prepare({true, true}), ChunkPages::Made::Built)
        << "made by the source, after all";
    EXPECT_TRUE(first.chunks[4]->Prepare({true, true}) == ChunkPages::Made::Built ||
                first.chunks[4]->Data(HDS_PAGE_GEOMETRY) ==
                    second.chunks[4]->Data(HDS_PAGE_GEOMETRY));
}

TEST(GeometryCommit, AMeshWithWarningsWarnsAgainInTheNextRun) {
    const test::TemporaryFolder folder;
    GeometryDescription grid = Grid(40, "none");
    std::vector<float> points(grid.points.begin(), grid.points.end());
    points[3] = std::numeric_limits<float>::quiet_NaN();
    grid.points = std::move(points);
    for (int run = 0; run < 2; ++run) {
        Warnings warnings;
        const PlannedGeometry mesh = PrepareStored(grid, folder.Path(), &warnings);
        EXPECT_GT(mesh.chunks.size(), 1U);
        EXPECT_EQ(warnings.Lines().size(), 1U);
        EXPECT_TRUE(warnings.Has("/grid"));
        EXPECT_FALSE(warnings.Has("/gri"));
    }
}

TEST(GeometryCommit, BytesThatAreNoSummaryGiveNone) {
    GeometrySummary summary;
    summary.numTriangles = 7;
    summary.attributes = {{"st", 2}, {"displayColor", 3}};
    summary.chunkBounds.resize(3);
    summary.numInChunk = {1, 2, 4};
    const std::vector<std::uint8_t> bytes = SerializeSummary(summary);
    const auto again = ParseSummary(bytes);
    ASSERT_TRUE(again);
    EXPECT_EQ(SerializeSummary(*again), bytes);
    EXPECT_EQ(again->attributes[1].name, "displayColor");
    EXPECT_EQ(again->numInChunk, summary.numInChunk);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
        EXPECT_FALSE(ParseSummary({bytes.begin(), bytes.begin() + std::ptrdiff_t(length)}));
    }
    for (std::size_t i = 0; i + 8 <= bytes.size(); i += 4) {
        std::vector<std::uint8_t> wrong = bytes;
        std::fill_n(wrong.begin() + std::ptrdiff_t(i), 8, std::uint8_t{0xff});
        ParseSummary(wrong); // whatever it gives, it reads nothing beyond the end
    }
    std::vector<std::uint8_t> odd = bytes;
    odd[sizeof(summary.origin)] = 2; // isLeftHanded
    EXPECT_FALSE(ParseSummary(odd));
}

TEST(GeometryCommit, SurfacesAreDicedAsAsked) {
    GeometryInputs inputs;
    EXPECT_EQ(Prepare(Grid(4, "catmullClark"), inputs).numTriangles, 32U);
    inputs.dicing.Edit().emplace();
    inputs.dicing.Edit()->level = 2;
    EXPECT_EQ(Prepare(Grid(4, "catmullClark"), inputs).numTriangles, 32U * 16U);
}

// The same mesh has the same name in the cache; whatever its pages depend on gives another.
TEST(GeometryCommit, KeysFollowEveryInput) {
    GeometryInputs inputs;
    inputs.geometry = std::make_shared<GeometryDescription>(Grid(3, "catmullClark"));
    std::vector<PageKey> keys = {MakeGeometryKey(inputs)};
    const auto add = [&](const GeometryInputs& changed) {
        keys.push_back(MakeGeometryKey(changed));
    };
    GeometryInputs other = inputs;
    other.geometry = std::make_shared<GeometryDescription>(Grid(3, "catmullClark"));
    EXPECT_EQ(MakeGeometryKey(other), keys[0]);
    other.geometry = std::make_shared<GeometryDescription>(Grid(3, "loop"));
    add(other);
    GeometryDescription left = Grid(3, "catmullClark");
    left.leftHanded = true;
    other.geometry = std::make_shared<GeometryDescription>(left);
    add(other);
    other = inputs;
    other.chunkBytes = 4096;
    add(other);
    other = inputs;
    other.displacements = {{0.25F, ""}};
    add(other);
    other.displacements = {{0.25F, "height"}};
    add(other);
    other = inputs;
    other.dicing.Edit().emplace();
    add(other);
    other.dicing.Edit()->isAdaptive = true;
    add(other);
    other.dicing.Edit()->view.cameraFromObject[3][2] = -5.0;
    add(other);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            EXPECT_NE(keys[i], keys[k]) << i << " and " << k;
        }
    }
}

} // namespace
} // namespace hds
