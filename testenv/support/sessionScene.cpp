// SPDX-License-Identifier: Apache-2.0
#include "testenv/support/sessionScene.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <cmath>
#include <cstring>

namespace hds::test {

std::shared_ptr<const GeometryDescription> MakeGrid(int size, float bump) {
    auto mesh = std::make_shared<GeometryDescription>();
    std::vector<float> points;
    std::vector<std::int32_t> counts;
    std::vector<std::int32_t> indices;
    for (int z = 0; z <= size; ++z) {
        for (int x = 0; x <= size; ++x) {
            const float u = static_cast<float>(x) / static_cast<float>(size);
            const float v = static_cast<float>(z) / static_cast<float>(size);
            points.insert(
                points.end(),
                {2.0F * u - 1.0F, bump * std::sin(9.0F * u) * std::cos(7.0F * v), 2.0F * v - 1.0F});
        }
    }
    for (int z = 0; z < size; ++z) {
        for (int x = 0; x < size; ++x) {
            const int corner = z * (size + 1) + x;
            counts.push_back(4);
            indices.insert(indices.end(),
                           {corner, corner + size + 1, corner + size + 2, corner + 1});
        }
    }
    mesh->points = std::move(points);
    mesh->faceVertexCounts = std::move(counts);
    mesh->faceVertexIndices = std::move(indices);
    return mesh;
}

std::shared_ptr<const GeometryDescription> MakeQuad() {
    auto mesh = std::make_shared<GeometryDescription>();
    mesh->points = std::vector<float>{-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    mesh->faceVertexCounts = std::vector<std::int32_t>{4};
    mesh->faceVertexIndices = std::vector<std::int32_t>{0, 1, 2, 3};
    return mesh;
}

std::shared_ptr<const MaterialNetwork> MakeMaterial(float red, float green, float blue,
                                                    float emission) {
    auto network = std::make_shared<MaterialNetwork>();
    MaterialNode node;
    node.path = "/surface";
    node.identifier = "UsdPreviewSurface";
    node.parameters["diffuseColor"] = std::vector<float>{red, green, blue};
    if (emission > 0.0F) {
        node.parameters["emissiveColor"] = std::vector<float>{emission, emission, emission};
    }
    network->nodes.push_back(node);
    network->terminals["surface"] = {"/surface", "surface"};
    return network;
}

std::shared_ptr<const GeometryDescription> MakeGridOfAmounts(int size, float bump,
                                                             std::uint32_t numComponents) {
    auto grid = std::make_shared<GeometryDescription>(*MakeGrid(size, bump));
    const std::vector<float> values(grid->points.size() / 3 * numComponents, 0.4F + bump);
    grid->primvars = {{"amount", Interpolation::Vertex, numComponents, values, {}}};
    return grid;
}

std::shared_ptr<const MaterialNetwork> MakeAmountReader() {
    auto network = std::make_shared<MaterialNetwork>(*MakeMaterial(0.5F, 0.5F, 0.5F));
    network->nodes[0].connections["diffuseColor"] = {"/reader", "result"};
    network->nodes.push_back({"/reader", "UsdPrimvarReader_float", {}, {}});
    network->nodes.back().parameters["varname"] = std::string("amount");
    return network;
}

void AddInstancesAndSun(const std::string& path, GeometryPrim prim, SceneDescription* scene) {
    InstancerPrim many;
    many.instanceTransforms.translations = std::vector<float>{0, 1, 0, 0, 2, 0, 0, 3, 0};
    scene->instancers[path] = many;
    prim.placement.instancerPath = path;
    prim.placement.instances = std::vector<std::int32_t>{0, 2};
    scene->geometry[path + "/leaf"] = std::move(prim);
    LightPrim sun;
    sun.light.type = LightType::Distant;
    scene->lights["/sun"] = sun;
}

glm::dmat4 Move(double x, double y, double z) {
    return glm::translate(glm::dmat4(1.0), glm::dvec3(x, y, z));
}

void FillSession(Session* session) {
    GeometryPrim ground;
    ground.geometry = MakeGrid(24, 0.1F);
    ground.placement.worldFromObject = glm::scale(glm::dmat4(1.0), glm::dvec3(4.0, 1.0, 4.0));
    session->SetGeometry("/ground", ground);
    GeometryPrim wall;
    wall.geometry = MakeQuad();
    wall.placement.worldFromObject = Move(0.0, 1.0, -2.0);
    wall.materialPath = "/red";
    session->SetGeometry("/wall", wall);
    GeometryPrim ball;
    ball.geometry = MakeGrid(12, 0.4F);
    ball.placement.worldFromObject = Move(-1.5, 0.8, 0.0);
    session->SetGeometry("/ball", ball);
    InstancerPrim many;
    std::vector<double> transforms;
    for (int i = 0; i < 5; ++i) {
        const glm::dmat4 matrix =
            glm::scale(Move(1.0 + 0.4 * i, 0.5, 1.0 - 0.6 * i), glm::dvec3(0.2));
        transforms.insert(transforms.end(), glm::value_ptr(matrix), glm::value_ptr(matrix) + 16);
    }
    many.instanceTransforms = std::move(transforms);
    session->SetInstancer("/many", many);
    GeometryPrim leaf;
    leaf.geometry = MakeGrid(6, 0.5F);
    leaf.placement.instancerPath = "/many";
    leaf.placement.instances = std::vector<std::int32_t>{0, 1, 3, 4};
    session->SetGeometry("/many/leaf", leaf);
    LightPrim sun;
    sun.light.type = LightType::Distant;
    sun.light.intensity = 3.0F;
    sun.light.angle = 20.0F;
    sun.placement.worldFromObject = glm::rotate(glm::dmat4(1.0), -0.9, glm::dvec3(1.0, 0.2, 0.0));
    session->SetLight("/sun", sun);
    LightPrim lamp;
    lamp.light.type = LightType::Sphere;
    lamp.light.radius = 0.3F;
    lamp.light.intensity = 10.0F;
    lamp.placement.worldFromObject = Move(1.0, 3.0, 1.0);
    session->SetLight("/lamp", lamp);
    session->SetMaterial("/red", MakeMaterial(0.8F, 0.1F, 0.1F));
    session->SetMaterial("/glow", MakeMaterial(0.1F, 0.1F, 0.1F, 4.0F));
    CameraPrim camera;
    camera.worldFromCamera = glm::rotate(Move(0.0, 2.0, 6.0), -0.25, glm::dvec3(1.0, 0.0, 0.0));
    camera.focalLength = 2.0F;
    camera.nearClip = 0.1F;
    camera.farClip = 100.0F;
    session->SetCamera("/camera", camera);
}

Settings MakeSettings() {
    Settings settings;
    settings.camera = "/camera";
    settings.imageWidth = 48;
    settings.imageHeight = 32;
    settings.samples = 3;
    settings.maxDepth = 2;
    settings.noCache = true; // PoCL would compile every kernel twice to hand out what is kept
    settings.aovs = {"color", "depth", "primId", "instanceId"};
    return settings;
}

bool SameLayers(const std::vector<ImageLayer>& a, const std::vector<ImageLayer>& b) {
    if (a.size() != b.size()) {
        return false;
    }
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (a[i].name != b[i].name || a[i].width != b[i].width || a[i].height != b[i].height ||
            a[i].ids != b[i].ids || a[i].values.size() != b[i].values.size() ||
            (!a[i].values.empty() && std::memcmp(a[i].values.data(), b[i].values.data(),
                                                 a[i].values.size() * sizeof(float)) != 0)) {
            return false;
        }
    }
    return true;
}

} // namespace hds::test
