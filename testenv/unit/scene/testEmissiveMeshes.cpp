// SPDX-License-Identifier: Apache-2.0
// Emissive meshes over commits that share a cache, and those of too many triangles to be sampled.
#include "hdStream/scene/commit.h"
#include "testenv/unit/texture/textureFixtures.h"

namespace hds {
namespace {

/// Quads of a square.
std::shared_ptr<const GeometryDescription> Grid(std::int32_t size) {
    auto mesh = std::make_shared<GeometryDescription>();
    std::vector<float> points;
    std::vector<float> st;
    for (std::int32_t i = 0; i < (size + 1) * (size + 1); ++i) {
        const float s = static_cast<float>(i % (size + 1)) / static_cast<float>(size);
        const float t = static_cast<float>(i / (size + 1)) / static_cast<float>(size);
        points.insert(points.end(), {s, t, 0.0F});
        st.insert(st.end(), {s, t});
    }
    std::vector<std::int32_t> indices;
    for (std::int32_t i = 0; i < size * size; ++i) {
        const std::int32_t corner = i / size * (size + 1) + i % size;
        indices.insert(indices.end(), {corner, corner + 1, corner + size + 2, corner + size + 1});
    }
    mesh->points = std::move(points);
    mesh->faceVertexIndices = std::move(indices);
    mesh->faceVertexCounts = std::vector<std::int32_t>(
        static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 4);
    mesh->subdivisionScheme = "none";
    mesh->primvars = {{"st", Interpolation::Vertex, 2, std::move(st), {}}};
    return mesh;
}

class EmissiveMeshesTest : public TextureTest {
protected:
    /// A texture times a factor.
    std::shared_ptr<const MaterialNetwork> Glow(const std::string& file, float factor) {
        auto network = std::make_shared<MaterialNetwork>();
        network->nodes.resize(3);
        network->nodes[0] = {"/m/s", "UsdPreviewSurface", {}, {{"emissiveColor", {"/m/t", "rgb"}}}};
        network->nodes[1] = {"/m/t", "UsdUVTexture", {}, {{"st", {"/m/r", "result"}}}};
        network->nodes[1].parameters["file"] = AssetReference{file, file, 0, 0};
        network->nodes[1].parameters["scale"] = std::vector<float>(4, factor);
        network->nodes[2] = {"/m/r", "UsdPrimvarReader_float2", {}, {}};
        network->nodes[2].parameters["varname"] = std::string("st");
        network->terminals["surface"] = {"/m/s", "surface"};
        return network;
    }

    std::unique_ptr<CommittedScene> Commit(CommitCache* cache) {
        CommitOptions options;
        options.purposes = {"default"};
        return CommitScene(scene, options, cache, warnings);
    }

    SceneDescription scene;
};

TEST_F(EmissiveMeshesTest, EditsOfAFactorKeepNothingOfBefore) {
    const std::string file = WriteImage("glow.png", 16, 16, 3, OIIO::TypeUInt8);
    scene.geometry["/a"].geometry = Grid(2);
    scene.geometry["/a"].materialPath = "/m";
    CommitCache cache(warnings);
    // Factors that are alike to six digits behind the point are not the same.
    for (const float factor : {3.0F, 2.0F, 4e-7F, 2e-8F}) {
        scene.materials["/m"] = Glow(file, factor);
        const auto edited = Commit(&cache);
        EXPECT_EQ(cache.emissionImages.size(), 1U);
        CommitCache empty(warnings);
        const auto fresh = Commit(&empty);
        ASSERT_FALSE(edited->lights->lights.empty());
        ASSERT_EQ(edited->lights->lights.size(), fresh->lights->lights.size());
        for (std::size_t i = 0; i < edited->lights->lights.size(); ++i) {
            EXPECT_EQ(edited->lights->lights[i].strength, fresh->lights->lights[i].strength)
                << factor;
        }
    }
    scene.geometry.clear();
    Commit(&cache);
    EXPECT_TRUE(cache.emissionImages.empty());
}

TEST_F(EmissiveMeshesTest, ALightOfTooManyTrianglesIsSeenAsItIs) {
    scene.geometry["/a"].geometry = Grid(725);
    auto light = std::make_shared<MeshLight>();
    light->light.type = LightType::Mesh;
    light->light.intensity = 6.0F;
    light->materialSyncMode = MaterialSyncMode::NoMaterialResponse;
    for (const bool isNormalized : {false, true}) {
        light->light.normalize = isNormalized; // by an area of 1
        scene.geometry["/a"].light = std::make_shared<const MeshLight>(*light);
        CommitCache cache(warnings);
        const auto committed = Commit(&cache);
        ASSERT_EQ(committed->lights->lights.size(), 1U);
        const shared::HdsLight& found = committed->lights->lights[0];
        EXPECT_NEAR(found.radiance[0], 6.0F, 1e-4F) << isNormalized;
        EXPECT_NE(found.flags & HDS_LIGHT_REPLACES, 0U);
        EXPECT_EQ(found.dataSize[0], 0U) << "not sampled";
        ASSERT_EQ(committed->lightByEntry.size(), 1U);
        EXPECT_NE(committed->lightByEntry[0], HDS_NONE);
    }
    ASSERT_EQ(warnings.Lines().size(), 1U);
    EXPECT_EQ(warnings.Lines()[0].rfind("/a", 0), 0U);
}

} // namespace
} // namespace hds
