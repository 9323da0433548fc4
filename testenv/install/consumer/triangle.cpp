// SPDX-License-Identifier: Apache-2.0
// triangle OUT.exr: a triangle under a dome, through hdStream/session/session.h alone.
#include "hdStream/session/session.h"

#include <cstdio>

namespace {

void DescribeScene(hds::Session& session) {
    auto triangle = std::make_shared<hds::GeometryDescription>();
    triangle->points = std::vector<float>{-1, -1, 0, 1, -1, 0, 0, 1, 0};
    triangle->faceVertexCounts = std::vector<std::int32_t>{3};
    triangle->faceVertexIndices = std::vector<std::int32_t>{0, 1, 2};
    hds::Primvar color;
    color.name = "displayColor";
    color.numComponents = 3;
    color.values = std::vector<float>{0.5F, 0.25F, 0.125F};
    triangle->primvars.push_back(color);
    hds::GeometryPrim prim;
    prim.geometry = triangle;
    session.SetGeometry("/Triangle", prim);

    hds::LightPrim dome;
    dome.light.type = hds::LightType::Dome;
    session.SetLight("/Dome", dome);

    hds::CameraPrim camera;
    camera.worldFromCamera[3] = {0, 0, 4, 1};
    camera.horizontalAperture = 2.0F;
    camera.verticalAperture = 2.0F;
    camera.focalLength = 2.0F;
    session.SetCamera("/Camera", camera);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("usage: triangle OUT.exr\n", stderr);
        return 2;
    }
    try {
        hds::Session session;
        DescribeScene(session);
        hds::Settings settings;
        settings.camera = "/Camera";
        settings.imageWidth = settings.imageHeight = 32;
        settings.samples = 4;
        settings.noCache = true;
        session.Render(settings);
        hds::WriteImage(argv[1], session.Layers());
    } catch (const hds::Error& error) {
        std::fprintf(stderr, "triangle: %s\n", error.what());
        return 1;
    }
    return 0;
}
