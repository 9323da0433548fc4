// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/dump.h"

#include "hdStream/base/hash.h"
#include "hdStream/geometry/primvars.h"

#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <type_traits>
#include <utility>
#include <vector>

namespace hds {

namespace {

constexpr std::size_t kMaxListed = 24;

template <typename T>
std::string Number(T value) {
    if constexpr (std::is_integral_v<T>) {
        return std::to_string(value);
    } else {
        char text[40];
        // Adding 0 turns -0 into 0, so that equal values have equal texts.
        std::snprintf(text, sizeof(text), sizeof(T) == 4 ? "%.9g" : "%.17g",
                      static_cast<double>(value) + 0.0);
        return text;
    }
}

template <typename T>
std::string Array(const T* values, std::size_t count) {
    std::string text = "[" + std::to_string(count) + "]";
    if (count <= kMaxListed) {
        for (std::size_t i = 0; i < count; ++i) {
            text += " " + Number(values[i]);
        }
        return text;
    }
    Hasher hasher;
    T low = values[0];
    T high = values[0];
    for (std::size_t i = 0; i < count; ++i) {
        const T value = values[i] + T{}; // -0 hashes as 0
        hasher.Append(&value, sizeof(value));
        low = std::min(low, value);
        high = std::max(high, value);
    }
    return text + " " + Number(low) + ".." + Number(high) + " #" + hasher.Hex();
}

template <typename T>
std::string Array(const SharedSpan<T>& span) {
    return Array(span.data(), span.size());
}

const char* LightTypeName(LightType type) {
    switch (type) {
    case LightType::Distant:
        return "distant";
    case LightType::Sphere:
        return "sphere";
    case LightType::Rect:
        return "rect";
    case LightType::Disk:
        return "disk";
    case LightType::Cylinder:
        return "cylinder";
    case LightType::Dome:
        return "dome";
    case LightType::Mesh:
        return "mesh";
    }
    return "";
}

const char* CullStyleName(CullStyle style) {
    switch (style) {
    case CullStyle::DontCare:
        return "dontCare";
    case CullStyle::Nothing:
        return "nothing";
    case CullStyle::Back:
        return "back";
    case CullStyle::Front:
        return "front";
    case CullStyle::BackUnlessDoubleSided:
        return "backUnlessDoubleSided";
    case CullStyle::FrontUnlessDoubleSided:
        return "frontUnlessDoubleSided";
    }
    return "";
}

/// Collects "  name: value" lines under prim headers.
class Writer {
public:
    void Prim(const std::string& kind, const std::string& path) {
        _text += kind + " " + path + "\n";
    }
    void Line(const std::string& name, const std::string& value) {
        _text += "  " + name + ": " + value + "\n";
    }
    template <typename T>
    void Value(const std::string& name, T value) {
        Line(name, Number(value));
    }
    void Flag(const std::string& name, bool value) { Line(name, value ? "true" : "false"); }
    void Matrix(const std::string& name, const glm::dmat4& matrix) {
        Line(name, Array(glm::value_ptr(matrix), 16));
    }
    /// The first and the last of them, of so few digits that front ends that interpolate in
    /// different ways agree.
    void Samples(const std::vector<TransformSample>& samples) {
        for (const std::size_t i : {std::size_t{0}, samples.size() - 1}) {
            if (samples.size() < 2) {
                return;
            }
            std::string text;
            for (int k = 0; k < 16; ++k) {
                char number[40];
                std::snprintf(number, sizeof(number), " %.5g",
                              std::round(samples[i].matrix[k / 4][k % 4] * 1e6) * 1e-6 + 0.0);
                text += number;
            }
            Line("transform at " + Number(static_cast<float>(samples[i].time)), text.substr(1));
        }
    }
    void Placed(const Placement& placement) {
        Matrix("transform", placement.worldFromObject);
        Samples(placement.samples);
        if (!placement.instancerPath.empty()) {
            Line("instancer", placement.instancerPath);
            Line("instances", Array(placement.instances));
        }
    }
    std::string Take() { return std::move(_text); }

private:
    std::string _text;
};

std::string ParameterText(const ParameterValue& value) {
    struct Visitor {
        std::string operator()(bool v) const { return v ? "true" : "false"; }
        std::string operator()(std::int64_t v) const { return std::to_string(v); }
        std::string operator()(double v) const { return Number(static_cast<float>(v)); }
        std::string operator()(const std::vector<float>& v) const {
            return Array(v.data(), v.size());
        }
        std::string operator()(const std::string& v) const { return '"' + v + '"'; }
        std::string operator()(const AssetReference& v) const { return '@' + v.authoredPath + '@'; }
    };
    return std::visit(Visitor{}, value);
}

using LinkedLights = std::vector<std::pair<std::string, LinkCategories>>;

/// The lights and mesh lights that are linked, by path.
LinkedLights LinkedLightsOf(const SceneDescription& scene) {
    LinkedLights lights;
    const auto add = [&](const std::string& path, const LinkCategories& links) {
        if (!links.lightLink.empty() || !links.shadowLink.empty()) {
            lights.emplace_back(path, links);
        }
    };
    for (const auto& [path, prim] : scene.lights) {
        add(path, prim.links);
    }
    for (const auto& [path, prim] : scene.meshes) {
        if (prim.light) {
            add(path, prim.light->links);
        }
    }
    return lights;
}

/// The lights that do not light geometry in some categories, or whose shadows it does not cast:
/// front ends name categories as they like.
std::string Unlinked(const LinkedLights& lights, const std::set<std::string>& categories,
                     std::string LinkCategories::*link) {
    std::string text;
    for (const auto& [path, links] : lights) {
        if (!(links.*link).empty() && categories.count(links.*link) == 0) {
            text += (text.empty() ? "" : " ") + path;
        }
    }
    return text;
}

void DumpLinks(const std::string& prefix, const LinkedLights& lights,
               const std::set<std::string>& categories, Writer* out) {
    const std::string unlit = Unlinked(lights, categories, &LinkCategories::lightLink);
    const std::string unshadowing = Unlinked(lights, categories, &LinkCategories::shadowLink);
    if (!unlit.empty()) {
        out->Line(prefix + "unlit by", unlit);
    }
    if (!unshadowing.empty()) {
        out->Line(prefix + "no shadows of", unshadowing);
    }
}

void DumpSubdivision(const MeshDescription& mesh, Writer* out) {
    const SubdivTags& tags = mesh.subdivTags;
    out->Line("subdivisionScheme", mesh.subdivisionScheme);
    if (mesh.subdivisionScheme == "none") {
        return;
    }
    out->Line("interpolateBoundary", tags.interpolateBoundary);
    out->Line("faceVaryingLinearInterpolation", tags.faceVaryingLinearInterpolation);
    out->Line("triangleSubdivisionRule", tags.triangleSubdivisionRule);
    if (!tags.creaseIndices.empty()) {
        out->Line("creaseIndices", Array(tags.creaseIndices));
        out->Line("creaseLengths", Array(tags.creaseLengths));
        out->Line("creaseSharpnesses", Array(tags.creaseSharpnesses));
    }
    if (!tags.cornerIndices.empty()) {
        out->Line("cornerIndices", Array(tags.cornerIndices));
        out->Line("cornerSharpnesses", Array(tags.cornerSharpnesses));
    }
}

void DumpFaces(const MeshDescription& mesh, Writer* out) {
    out->Line("faceVertexCounts", Array(mesh.faceVertexCounts));
    out->Line("faceVertexIndices", Array(mesh.faceVertexIndices));
    if (!mesh.holeIndices.empty()) {
        out->Line("holeIndices", Array(mesh.holeIndices));
    }
    DumpSubdivision(mesh, out);
    out->Flag("leftHanded", mesh.leftHanded);
}

void DumpCurves(const MeshDescription& mesh, Writer* out) {
    out->Line("curveVertexCounts", Array(mesh.faceVertexCounts));
    if (!mesh.faceVertexIndices.empty()) {
        out->Line("curveIndices", Array(mesh.faceVertexIndices));
    }
    out->Line("type", mesh.curves.type);
    if (mesh.curves.type != "linear") {
        out->Line("basis", mesh.curves.basis);
    }
    out->Line("wrap", mesh.curves.wrap);
}

const char* KindName(PrimitiveKind kind) {
    switch (kind) {
    case PrimitiveKind::Faces:
        break;
    case PrimitiveKind::Curves:
        return "curves";
    case PrimitiveKind::Points:
        return "points";
    }
    return "mesh";
}

void DumpShaping(const LightDescription& light, Writer* out) {
    const LightShaping& shaping = light.shaping;
    if (IsUnshaped(light)) {
        return;
    }
    out->Value("shaping focus", shaping.focus);
    out->Line("shaping focusTint", Array(shaping.focusTint.data(), shaping.focusTint.size()));
    out->Value("shaping coneAngle", shaping.coneAngle);
    out->Value("shaping coneSoftness", shaping.coneSoftness);
    if (!shaping.iesFile.authoredPath.empty()) {
        out->Line("shaping iesFile", '@' + shaping.iesFile.authoredPath + '@');
        out->Value("shaping iesAngleScale", shaping.iesAngleScale);
        out->Flag("shaping iesNormalize", shaping.iesNormalize);
    }
}

void DumpShadow(const LightShadow& shadow, Writer* out) {
    if (shadow.enable && shadow.distance < 0.0F && shadow.color == LightShadow().color) {
        return;
    }
    out->Flag("shadow enable", shadow.enable);
    out->Line("shadow color", Array(shadow.color.data(), shadow.color.size()));
    out->Value("shadow distance", shadow.distance);
    if (IsFading(shadow)) {
        out->Value("shadow falloff", shadow.falloff);
        out->Value("shadow falloffGamma", shadow.falloffGamma);
    }
}

void DumpLightInputs(const LightDescription& light, Writer* out) {
    out->Line("type", LightTypeName(light.type));
    out->Value("intensity", light.intensity);
    out->Value("exposure", light.exposure);
    out->Value("diffuse", light.diffuse);
    out->Value("specular", light.specular);
    out->Flag("normalize", light.normalize);
    out->Line("color", Array(light.color.data(), light.color.size()));
    out->Flag("enableColorTemperature", light.enableColorTemperature);
    out->Value("colorTemperature", light.colorTemperature);
    out->Flag("visibleToCamera", light.visibleToCamera);
    switch (light.type) {
    case LightType::Distant:
        out->Value("angle", light.angle);
        break;
    case LightType::Sphere:
        out->Value("radius", light.radius);
        out->Flag("treatAsPoint", light.treatAsPoint);
        break;
    case LightType::Disk:
        out->Value("radius", light.radius);
        break;
    case LightType::Rect:
        out->Value("width", light.width);
        out->Value("height", light.height);
        break;
    case LightType::Cylinder:
        out->Value("radius", light.radius);
        out->Value("length", light.length);
        out->Flag("treatAsLine", light.treatAsLine);
        break;
    case LightType::Dome:
        out->Line("textureFormat", light.textureFormat);
        break;
    case LightType::Mesh:
        break;
    }
    if (!light.textureFile.authoredPath.empty()) {
        out->Line("textureFile", '@' + light.textureFile.authoredPath + '@');
    }
    DumpShaping(light, out);
    DumpShadow(light.shadow, out);
}

const char* SyncModeName(MaterialSyncMode mode) {
    switch (mode) {
    case MaterialSyncMode::GlowTintsLight:
        return "materialGlowTintsLight";
    case MaterialSyncMode::Independent:
        return "independent";
    case MaterialSyncMode::NoMaterialResponse:
        return "noMaterialResponse";
    }
    return "";
}

void DumpMesh(const std::string& path, const MeshPrim& prim, const SceneDescription& scene,
              const LinkedLights& lights, Writer* out) {
    // Front ends see dangling bindings, and materials without a surface, differently.
    const auto existing = [&](const std::string& materialPath) {
        return HasSurface(scene, materialPath) ? materialPath : std::string();
    };
    const MeshDescription& mesh = *prim.mesh;
    out->Prim(KindName(mesh.primitives), path);
    out->Placed(prim.placement);
    out->Line("purpose", prim.purpose);
    out->Line("material", existing(prim.materialPath));
    out->Line("points", Array(mesh.points));
    for (const PointSample& sample : mesh.samples) {
        out->Line("points at " + Number(static_cast<float>(sample.time)), Array(sample.points));
    }
    if (mesh.primitives == PrimitiveKind::Faces) {
        DumpFaces(mesh, out);
        out->Flag("doubleSided", prim.doubleSided);
    } else if (mesh.primitives == PrimitiveKind::Curves) {
        DumpCurves(mesh, out);
    }
    if (prim.cullStyle != CullStyle::DontCare) {
        out->Line("cullStyle", CullStyleName(prim.cullStyle));
    }
    std::vector<const Primvar*> primvars;
    for (const Primvar& primvar : mesh.primvars) {
        primvars.push_back(&primvar);
    }
    std::sort(primvars.begin(), primvars.end(),
              [](const Primvar* a, const Primvar* b) { return a->name < b->name; });
    for (const Primvar* primvar : primvars) {
        out->Line("primvar " + primvar->name,
                  std::string(InterpolationName(primvar->interpolation)) + " x" +
                      std::to_string(primvar->numComponents) + " " + Array(primvar->values) +
                      (primvar->indices.empty() ? "" : " indices " + Array(primvar->indices)));
    }
    for (std::size_t i = 0; i < mesh.subsets.size(); ++i) {
        const bool hasMaterial = i < prim.subsetMaterialPaths.size();
        out->Line("subset " + mesh.subsets[i].name,
                  Array(mesh.subsets[i].faces) + " material " +
                      (hasMaterial ? existing(prim.subsetMaterialPaths[i]) : std::string()));
    }
    DumpLinks("", lights, prim.categories, out);
    if (prim.light) {
        out->Line("light", SyncModeName(prim.light->materialSyncMode));
        DumpLightInputs(prim.light->light, out);
    }
}

void DumpInstancer(const std::string& path, const InstancerPrim& prim, const LinkedLights& lights,
                   Writer* out) {
    out->Prim("instancer", path);
    out->Placed(prim.placement);
    out->Line("instanceTransforms", Array(prim.instanceTransforms));
    for (const InstanceSample& sample : prim.samples) {
        out->Line("instanceTransforms at " + Number(static_cast<float>(sample.time)),
                  Array(sample.transforms));
    }
    const bool hasCategories =
        std::any_of(prim.instanceCategories.begin(), prim.instanceCategories.end(),
                    [](const std::set<std::string>& categories) { return !categories.empty(); });
    for (std::size_t i = 0; hasCategories && i < prim.instanceCategories.size(); ++i) {
        DumpLinks("instance " + std::to_string(i) + " ", lights, prim.instanceCategories[i], out);
    }
}

void DumpMaterial(const std::string& path, const MaterialNetwork& network, Writer* out) {
    out->Prim("material", path);
    for (const auto& [terminal, source] : network.terminals) {
        out->Line("terminal " + terminal, source.upstreamPath + "." + source.upstreamOutput);
    }
    std::vector<const MaterialNode*> nodes;
    for (const MaterialNode& node : network.nodes) {
        nodes.push_back(&node);
    }
    std::sort(nodes.begin(), nodes.end(),
              [](const MaterialNode* a, const MaterialNode* b) { return a->path < b->path; });
    for (const MaterialNode* node : nodes) {
        out->Line("node " + node->path, node->identifier);
        for (const auto& [name, value] : node->parameters) {
            out->Line("  " + name, ParameterText(value));
        }
        for (const auto& [name, source] : node->connections) {
            out->Line("  " + name, "<- " + source.upstreamPath + "." + source.upstreamOutput);
        }
    }
}

void DumpLight(const std::string& path, const LightPrim& prim, Writer* out) {
    out->Prim("light", path);
    out->Placed(prim.placement);
    DumpLightInputs(prim.light, out);
    for (std::size_t i = 0; i < prim.portals.size(); ++i) {
        const std::string name = "portal " + std::to_string(i);
        out->Matrix(name, prim.portals[i].worldFromPortal);
        out->Value(name + " width", prim.portals[i].width);
        out->Value(name + " height", prim.portals[i].height);
    }
}

void DumpCamera(const std::string& path, const CameraPrim& camera, Writer* out) {
    out->Prim("camera", path);
    out->Matrix("transform", camera.worldFromCamera);
    out->Samples(camera.samples);
    out->Line("projection", camera.orthographic ? "orthographic" : "perspective");
    const float values[] = {camera.horizontalAperture,
                            camera.verticalAperture,
                            camera.horizontalApertureOffset,
                            camera.verticalApertureOffset,
                            camera.focalLength,
                            camera.nearClip,
                            camera.farClip,
                            camera.fStop,
                            camera.focusDistance,
                            camera.exposureScale};
    const char* names[] = {"horizontalAperture",
                           "verticalAperture",
                           "horizontalApertureOffset",
                           "verticalApertureOffset",
                           "focalLength",
                           "nearClip",
                           "farClip",
                           "fStop",
                           "focusDistance",
                           "exposureScale"};
    for (std::size_t i = 0; i < std::size(values); ++i) {
        out->Value(names[i], values[i]);
    }
    if (camera.shutter.IsOpen()) {
        const double ends[] = {camera.shutter.open, camera.shutter.close};
        out->Line("shutter", Array(ends, 2));
    }
    for (const glm::dvec4& plane : camera.clippingPlanes) {
        out->Line("clippingPlane", Array(glm::value_ptr(plane), 4));
    }
}

/// Visible, and so are all instancers above.
bool IsShown(const SceneDescription& scene, const Placement& placement) {
    const Placement* present = &placement;
    for (std::size_t level = 0; level <= scene.instancers.size(); ++level) {
        if (!present->visible) {
            return false;
        }
        const auto parent = scene.instancers.find(present->instancerPath);
        if (parent == scene.instancers.end()) {
            return true;
        }
        present = &parent->second.placement;
    }
    return true; // a cycle, which commit warns about
}

/// Materials of the meshes that are shown.
std::set<std::string> BoundMaterials(const SceneDescription& scene) {
    std::set<std::string> bound;
    for (const auto& [path, prim] : scene.meshes) {
        if (IsShown(scene, prim.placement)) {
            bound.insert(prim.materialPath);
            bound.insert(prim.subsetMaterialPaths.begin(), prim.subsetMaterialPaths.end());
        }
    }
    return bound;
}

} // namespace

std::string DumpScene(const SceneDescription& scene) {
    Writer out;
    const LinkedLights lights = LinkedLightsOf(scene);
    for (const auto& [path, prim] : scene.cameras) {
        DumpCamera(path, prim, &out);
    }
    for (const auto& [path, prim] : scene.instancers) {
        if (IsShown(scene, prim.placement)) {
            DumpInstancer(path, prim, lights, &out);
        }
    }
    for (const auto& [path, prim] : scene.lights) {
        if (IsShown(scene, prim.placement)) {
            DumpLight(path, prim, &out);
        }
    }
    const std::set<std::string> bound = BoundMaterials(scene);
    for (const auto& [path, network] : scene.materials) {
        if (bound.count(path) > 0 && HasSurface(scene, path)) {
            DumpMaterial(path, *network, &out);
        }
    }
    for (const auto& [path, prim] : scene.meshes) {
        if (IsShown(scene, prim.placement)) {
            DumpMesh(path, prim, scene, lights, &out);
        }
    }
    return out.Take();
}

} // namespace hds
