// SPDX-License-Identifier: Apache-2.0
// What a scene of many small meshes is counted with is about what the allocator has given out for
// it: the oracle is mallinfo2.
#include "hdStream/scene/geometryStore.h"
#include "hdStream/scene/hostRecords.h"

#include <gtest/gtest.h>

#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 33)
#include <malloc.h>

namespace hds {
namespace {

constexpr std::size_t kNumMeshes = 4000;

std::uint64_t AllocatedBytes() {
    const auto info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

/// Whether memory comes from the allocator that is asked: not with sanitizers.
bool IsCounted() {
    const std::uint64_t before = AllocatedBytes();
    const std::vector<char> block(std::size_t{1} << 22U);
    return AllocatedBytes() >= before + block.size();
}

/// One quad each, with a colour; all arrays but points are shared.
SceneDescription ManyMeshes() {
    SceneDescription scene;
    const SharedSpan<std::int32_t> counts(std::vector<std::int32_t>{4});
    const SharedSpan<std::int32_t> indices(std::vector<std::int32_t>{0, 1, 2, 3});
    const SharedSpan<float> points(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    const SharedSpan<float> color(std::vector<float>{0.5F, 0.5F, 0.5F});
    for (std::size_t i = 0; i < kNumMeshes; ++i) {
        auto mesh = std::make_shared<GeometryDescription>();
        mesh->points = points;
        mesh->faceVertexCounts = counts;
        mesh->faceVertexIndices = indices;
        mesh->primvars.push_back({"displayColor", Interpolation::Constant, 3, color, {}, {}});
        scene.geometry["/World/Pebbles/Mesh" + std::to_string(i)].geometry = std::move(mesh);
    }
    return scene;
}

void ExpectWithin(double share, std::uint64_t counted, std::uint64_t taken) {
    const auto per = [](std::uint64_t bytes) { return bytes / kNumMeshes; };
    EXPECT_NEAR(static_cast<double>(counted), static_cast<double>(taken),
                share * static_cast<double>(taken))
        << per(counted) << " and " << per(taken) << " bytes a mesh";
}

TEST(HostRecords, AreWhatTheAllocatorHasGivenOut) {
    if (!IsCounted()) {
        GTEST_SKIP() << "another allocator";
    }
    const std::uint64_t before = AllocatedBytes();
    const SceneDescription scene = ManyMeshes();
    const std::uint64_t described = AllocatedBytes() - before;
    std::uint64_t counted = 0;
    for (const auto& [path, prim] : scene.geometry) {
        counted += DescribedBytes(path, prim);
    }
    ExpectWithin(0.05, counted, described);
    EXPECT_LT(described / kNumMeshes, 1100U); // so that rare parts stay apart

    Warnings warnings;
    GeometryStore store;
    store.Sources().SetLimit(0);
    const std::uint64_t unplanned = AllocatedBytes();
    {
        std::vector<GeometryStore::Drawn> drawn;
        for (const auto& [path, prim] : scene.geometry) {
            auto inputs = std::make_shared<GeometryInputs>();
            inputs->geometry = prim.geometry;
            inputs->primvars = {"displayColor"};
            drawn.emplace_back(&path, std::move(inputs));
        }
        ASSERT_TRUE(store.Prepare(scene, drawn, warnings, {}));
    }
    const std::uint64_t planned = AllocatedBytes() - unplanned;
    ExpectWithin(0.1, store.Bytes(), planned);
    EXPECT_LT(planned / kNumMeshes, 1500U); // so that inputs are there once
}

} // namespace
} // namespace hds
#endif
