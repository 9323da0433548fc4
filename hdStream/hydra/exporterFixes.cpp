// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/exporterFixes.h"

#include "hdStream/hydra/lightParameters.h"
#include "hdStream/hydra/transparentSides.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;
constexpr float kBlendersSun = 4.0F; ///< by which Blender's exporter divides

/// Flux over the range of cosines within the cone, of a radiance that is 1 up to the angle
/// cutoff * (1 - softness) and falls from there to 0 by a smooth step of the angle. In radians.
double FluxOfSoftness(double cutoff, double softness) {
    constexpr int kNumSteps = 256;
    const double start = cutoff * (1.0 - softness);
    const double step = (cutoff - start) / kNumSteps;
    double flux = 1.0 - std::cos(start);
    for (int i = 0; i < kNumSteps; ++i) {
        const double t = (i + 0.5) / kNumSteps;
        flux += (1.0 - t * t * (3.0 - 2.0 * t)) * std::sin(start + (i + 0.5) * step) * step;
    }
    return flux / (1.0 - std::cos(cutoff));
}

/// The softness whose flux is that of a blend: a smooth step of the cosine over that share of the
/// cone's cosines, which lets half of the share through.
float SoftnessOfBlend(float coneAngle, float blend) {
    const double cutoff = std::clamp(double(coneAngle), 0.0, 180.0) * kRadians;
    const double wanted = 1.0 - 0.5 * std::clamp(double(blend), 0.0, 1.0);
    if (!(cutoff > 0.0) || !(blend > 0.0F)) {
        return blend;
    }
    double low = 0.0;
    double high = 1.0; // at which the flux is least
    for (int i = 0; i < 30; ++i) {
        const double middle = 0.5 * (low + high);
        (FluxOfSoftness(cutoff, middle) > wanted ? low : high) = middle;
    }
    return float(0.5 * (low + high));
}

bool EndsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// True for files of linear formats that Blender wrote for an image it had in memory.
bool IsOfBlendersCache(const hds::AssetReference& asset) {
    const std::string& path = asset.authoredPath;
    return path.find("/image_cache/img_") != std::string::npos &&
           (EndsWith(path, ".exr") || EndsWith(path, ".hdr"));
}

/// A colour of glass that is meant of the way in and out becomes its root, which dims light at each
/// surface.
void TintEachWay(const std::string& input, hds::MaterialNode* node,
                 std::vector<hds::MaterialNode>* added) {
    const auto parameter = node->parameters.find(input);
    if (parameter != node->parameters.end()) {
        if (auto* color = std::get_if<std::vector<float>>(&parameter->second)) {
            std::transform(color->begin(), color->end(), color->begin(),
                           [](float c) { return std::sqrt(std::clamp(c, 0.0F, 1.0F)); });
        }
    }
    const auto connection = node->connections.find(input);
    if (connection != node->connections.end()) {
        hds::MaterialNode root;
        root.path = node->path + "_" + input + "Root";
        root.identifier = "ND_power_color3FA";
        root.parameters["in2"] = 0.5;
        root.connections["in1"] = connection->second;
        connection->second = {root.path, "out"};
        added->push_back(std::move(root));
    }
}

} // namespace

HdStreamExporter HdStreamFindExporter(const std::string& name) {
    return name == "blender" ? HdStreamExporter::Blender : HdStreamExporter::None;
}

void HdStreamFixLight(HdStreamExporter exporter, hds::LightDescription* light) {
    if (exporter != HdStreamExporter::Blender) {
        return;
    }
    if (light->type == hds::LightType::Distant) {
        light->intensity *= kBlendersSun;
    }
    light->shaping.coneSoftness =
        SoftnessOfBlend(light->shaping.coneAngle, light->shaping.coneSoftness);
}

void HdStreamFixTemperature(HdStreamExporter exporter, HdSceneDelegate* delegate, const SdfPath& id,
                            hds::LightDescription* light) {
    if (exporter == HdStreamExporter::Blender && HdStreamLeavesTemperatureOut(delegate, id)) {
        light->enableColorTemperature = false;
    }
}

void HdStreamFixMaterial(HdStreamExporter exporter, hds::MaterialNetwork* network) {
    if (exporter != HdStreamExporter::Blender) {
        return;
    }
    HdStreamTakeTransparentOut(network);
    std::vector<hds::MaterialNode> added;
    for (hds::MaterialNode& node : network->nodes) {
        if (node.identifier == "ND_open_pbr_surface_surfaceshader") {
            if (node.connections.count("coat_darkening") == 0) {
                node.parameters.try_emplace("coat_darkening", 0.0);
            }
            TintEachWay("transmission_color", &node, &added);
        }
        const auto file = node.parameters.find("file");
        const auto space = node.parameters.find("colorSpace:file");
        if (file == node.parameters.end() || space == node.parameters.end()) {
            continue;
        }
        const auto* asset = std::get_if<hds::AssetReference>(&file->second);
        if (asset != nullptr && IsOfBlendersCache(*asset)) {
            space->second = std::string("lin_rec709");
        }
    }
    network->nodes.insert(network->nodes.end(), added.begin(), added.end());
}

PXR_NAMESPACE_CLOSE_SCOPE
