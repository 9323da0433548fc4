// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/dump.h"

#include "hdStream/base/hash.h"

#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <array>
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
    const SharedSpan<T> held = span.Held();
    return Array(held.data(), held.size());
}

template <typename T, std::size_t N>
std::string Array(const std::array<T, N>& values) {
    return Array(values.data(), N);
}

std::string Text(const std::string& text) {
    return text;
}
std::string Text(const AssetReference& asset) {
    return '@' + asset.authoredPath + '@' +
           (asset.colorSpace.empty() ? "" : ' ' + asset.colorSpace);
}
template <typename T>
std::string Text(const T& value) {
    if constexpr (std::is_same_v<T, bool>) {
        return value ? "true" : "false";
    } else if constexpr (std::is_enum_v<T>) {
        return TextOf(value);
    } else if constexpr (std::is_arithmetic_v<T>) {
        return Number(value);
    } else {
        return Array(value);
    }
}

// What is left out because nothing depends on it.

bool IsRestricted(const LightShadow& shadow) {
    return !shadow.enable || !(shadow.distance < 0.0F) || shadow.color != LightShadow().color;
}

template <typename Member>
bool IsWorthALine(const LightShadow& shadow, const Field<LightShadow, Member>& field) {
    const bool isOfFading = field.Is(&LightShadow::falloff) || field.Is(&LightShadow::falloffGamma);
    return !isOfFading || IsFading(shadow);
}

template <typename Member>
bool IsWorthALine(const LightShaping& shaping, const Field<LightShaping, Member>& field) {
    const bool isOfProfile = field.Is(&LightShaping::iesFile) ||
                             field.Is(&LightShaping::iesAngleScale) ||
                             field.Is(&LightShaping::iesNormalize);
    return !isOfProfile || !shaping.iesFile.authoredPath.empty();
}

template <typename Member>
bool IsWorthALine(const LightDescription& light, const Field<LightDescription, Member>& field) {
    return field.IsFor(light.type) &&
           (!field.Is(&LightDescription::textureFile) || !light.textureFile.authoredPath.empty()) &&
           (!field.Is(&LightDescription::group) || !light.group.empty()) &&
           (!field.Is(&LightDescription::colorSpace) || !light.colorSpace.empty()) &&
           (!field.Is(&LightDescription::shaping) || !IsUnshaped(light)) &&
           (!field.Is(&LightDescription::shadow) || IsRestricted(light.shadow));
}

template <typename Member>
bool IsWorthALine(const SubdivTags& tags, const Field<SubdivTags, Member>& field) {
    const bool isOfCreases = field.Is(&SubdivTags::creaseIndices) ||
                             field.Is(&SubdivTags::creaseLengths) ||
                             field.Is(&SubdivTags::creaseSharpnesses);
    const bool isOfCorners =
        field.Is(&SubdivTags::cornerIndices) || field.Is(&SubdivTags::cornerSharpnesses);
    return (!isOfCreases || !tags.creaseIndices.empty()) &&
           (!isOfCorners || !tags.cornerIndices.empty());
}

template <typename Member>
bool IsWorthALine(const CurveForm& curves, const Field<CurveForm, Member>& field) {
    return !field.Is(&CurveForm::basis) || curves.type != "linear";
}

template <typename Member>
bool IsWorthALine(const GeometryDescription& geometry,
                  const Field<GeometryDescription, Member>& field) {
    const bool isCurves = geometry.primitives == PrimitiveKind::Curves;
    return field.IsFor(geometry.primitives) &&
           (!field.Is(&GeometryDescription::holeIndices) || !geometry.holeIndices.empty()) &&
           (!field.Is(&GeometryDescription::subdivTags) || geometry.subdivisionScheme != "none") &&
           (!field.Is(&GeometryDescription::faceVertexIndices) || !isCurves ||
            !geometry.faceVertexIndices.empty());
}

template <typename Member>
bool IsWorthALine(const CameraLens& lens, const Field<CameraLens, Member>& field) {
    return lens.*field.member != CameraLens().*field.member;
}

template <typename T, typename Member>
bool IsWorthALine(const T& /*object*/, const Field<T, Member>& /*field*/) {
    return true;
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
    /// A line for a value, or lines for what a struct or a list of samples holds.
    template <typename T>
    void Value(const std::string& name, const T& value) {
        if constexpr (kHasFields<T> && !std::is_same_v<T, AssetReference>) {
            Fields(value, name + " ");
        } else {
            Line(name, Text(value));
        }
    }
    void Value(const std::string& name, const glm::dmat4& matrix) { Matrix(name, matrix); }
    void Value(const std::string& /*name*/, const std::vector<TransformSample>& samples) {
        Samples(samples);
    }
    void Value(const std::string& /*name*/, const std::vector<glm::dvec4>& planes) {
        for (const glm::dvec4& plane : planes) {
            Line("clippingPlane", Array(glm::value_ptr(plane), 4));
        }
    }
    void Value(const std::string& /*name*/, const std::vector<LensSample>& samples) {
        for (const LensSample& sample : samples) {
            const float values[] = {sample.focalLength,           sample.fStop,
                                    sample.focusDistance,         sample.horizontalAperture,
                                    sample.verticalAperture,      sample.horizontalApertureOffset,
                                    sample.verticalApertureOffset};
            Line("lens at " + Number(static_cast<float>(sample.time)), Array(values, 7));
        }
    }
    void Samples(const std::vector<LightSample>& samples) {
        for (const LightSample& sample : samples) {
            const float values[] = {sample.intensity, sample.exposure, sample.color[0],
                                    sample.color[1],  sample.color[2], sample.colorTemperature,
                                    sample.angle,     sample.radius,   sample.width,
                                    sample.height,    sample.length};
            Line("light at " + Number(static_cast<float>(sample.time)), Array(values, 11));
        }
    }
    /// The members of a struct that are worth a line.
    template <typename T>
    void Fields(const T& object, const std::string& prefix = "") {
        ForEachField<T>([&](const auto& field) {
            if (!field.notInDump && IsWorthALine(object, field)) {
                Value(prefix + field.name, object.*field.member);
            }
        });
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
        std::string operator()(bool v) const { return Text(v); }
        std::string operator()(std::int64_t v) const { return Text(v); }
        std::string operator()(double v) const { return Number(static_cast<float>(v)); }
        std::string operator()(const std::vector<float>& v) const {
            return Array(v.data(), v.size());
        }
        std::string operator()(const std::string& v) const { return '"' + v + '"'; }
        std::string operator()(const AssetReference& v) const { return Text(v); }
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
    for (const auto& [path, prim] : scene.geometry) {
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

void DumpUnlit(const std::string& prefix, const LinkedLights& lights,
               const std::set<std::string>& categories, Writer* out) {
    const std::string unlit = Unlinked(lights, categories, &LinkCategories::lightLink);
    if (!unlit.empty()) {
        out->Line(prefix + "unlit by", unlit);
    }
}

void DumpLinks(const std::string& prefix, const LinkedLights& lights,
               const std::set<std::string>& categories, Writer* out) {
    DumpUnlit(prefix, lights, categories, out);
    const std::string unshadowing = Unlinked(lights, categories, &LinkCategories::shadowLink);
    if (!unshadowing.empty()) {
        out->Line(prefix + "no shadows of", unshadowing);
    }
}

/// Lines of geometry by the types of what it holds. Primvars and subsets come after what the prim
/// says.
class GeometryLines {
public:
    GeometryLines(const GeometryDescription& geometry, Writer* out)
        : _geometry(geometry), _out(*out) {}

    void Write() const {
        ForEachField<GeometryDescription>([&](const auto& field) {
            if (!field.notInDump && IsWorthALine(_geometry, field)) {
                Value(field.name, _geometry.*field.member);
            }
        });
    }

private:
    void Value(const std::string& /*name*/, PrimitiveKind /*kind*/) const {} // in the header
    void Value(const std::string& /*name*/, const std::vector<Primvar>& /*list*/) const {}
    void Value(const std::string& /*name*/, const std::vector<MeshSubset>& /*list*/) const {}
    void Value(const std::string& name, const std::vector<PointSample>& samples) const {
        const std::string what = name == "samples" ? "points at " : "normals at ";
        for (const PointSample& sample : samples) {
            _out.Line(what + Number(static_cast<float>(sample.time)), Array(sample.points));
        }
    }
    void Value(const std::string& /*name*/, const std::vector<FloatSample>& samples) const {
        Samples("widths", samples);
    }
    void Value(const std::string& /*name*/, const Apart<SplatSamples>& samples) const {
        Samples("orientations", samples->orientations);
        Samples("scales", samples->scales);
        Samples("opacities", samples->opacities);
    }
    void Samples(const std::string& what, const std::vector<FloatSample>& samples) const {
        for (const FloatSample& sample : samples) {
            _out.Line(what + " at " + Number(static_cast<float>(sample.time)),
                      Array(sample.values));
        }
    }
    void Value(const std::string& /*name*/, const std::vector<ShutterKey>& /*keys*/) const {}
    void Value(const std::string& /*name*/, const Apart<SubdivTags>& tags) const {
        _out.Fields(*tags);
    }
    void Value(const std::string& /*name*/, const Apart<CurveForm>& curves) const {
        _out.Fields(*curves);
    }
    void Value(const std::string& name, const SharedSpan<std::int32_t>& indices) const {
        const bool isOfCurves = _geometry.primitives == PrimitiveKind::Curves;
        _out.Value(!isOfCurves                  ? name
                   : name == "faceVertexCounts" ? "curveVertexCounts"
                                                : "curveIndices",
                   indices);
    }
    template <typename T>
    void Value(const std::string& name, const T& value) const {
        _out.Value(name, value);
    }

    const GeometryDescription& _geometry;
    Writer& _out;
};

/// In the order of their names.
void DumpPrimvars(const std::vector<Primvar>& list, Writer* out) {
    std::vector<const Primvar*> primvars;
    for (const Primvar& primvar : list) {
        primvars.push_back(&primvar);
    }
    std::sort(primvars.begin(), primvars.end(),
              [](const Primvar* a, const Primvar* b) { return a->name < b->name; });
    for (const Primvar* primvar : primvars) {
        out->Line("primvar " + primvar->name,
                  std::string(TextOf(primvar->interpolation)) + " x" +
                      std::to_string(primvar->numComponents) + " " + Array(primvar->values) +
                      (primvar->indices.empty() ? "" : " indices " + Array(primvar->indices)) +
                      (primvar->colorSpace.empty() ? "" : " in " + primvar->colorSpace));
    }
}

void DumpGeometry(const std::string& path, const GeometryPrim& prim, const SceneDescription& scene,
                  const LinkedLights& lights, Writer* out) {
    // Front ends see dangling bindings, and materials without a surface, differently.
    const auto existing = [&](const std::string& materialPath) {
        return IsMaterial(scene, materialPath) ? materialPath : std::string();
    };
    const GeometryDescription& geometry = *prim.geometry;
    out->Prim(TextOf(geometry.primitives), path);
    out->Placed(prim.placement);
    out->Line("purpose", prim.purpose);
    out->Line("material", existing(prim.materialPath));
    GeometryLines(geometry, out).Write();
    if (geometry.primitives == PrimitiveKind::Faces) {
        out->Value("doubleSided", prim.doubleSided);
    }
    if (prim.cullStyle != CullStyle::DontCare) {
        out->Value("cullStyle", prim.cullStyle);
    }
    DumpPrimvars(geometry.primvars, out);
    for (std::size_t i = 0; i < geometry.subsets.size(); ++i) {
        const bool hasMaterial = i < prim.subsetMaterialPaths.size();
        out->Line("subset " + geometry.subsets[i].name,
                  Array(geometry.subsets[i].faces) + " material " +
                      (hasMaterial ? existing(prim.subsetMaterialPaths[i]) : std::string()));
    }
    DumpLinks("", lights, prim.categories, out);
    if (prim.light) {
        out->Value("light", prim.light->materialSyncMode);
        out->Fields(prim.light->light);
    }
}

void DumpInstancer(const std::string& path, const InstancerPrim& prim, const LinkedLights& lights,
                   Writer* out) {
    out->Prim("instancer", path);
    out->Placed(prim.placement);
    out->Line("instanceTransforms", Array(prim.instanceTransforms.Matrices()));
    for (const InstanceSample& sample : prim.samples) {
        out->Line("instanceTransforms at " + Number(static_cast<float>(sample.time)),
                  Array(sample.transforms));
    }
    DumpPrimvars(prim.primvars, out);
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
    out->Fields(prim.light);
    out->Samples(prim.samples);
    for (std::size_t i = 0; i < prim.portals.size(); ++i) {
        const std::string name = "portal " + std::to_string(i);
        out->Matrix(name, prim.portals[i].worldFromPortal);
        out->Value(name + " width", prim.portals[i].width);
        out->Value(name + " height", prim.portals[i].height);
    }
    for (const LightFilter& filter : prim.filters) {
        out->Line("filter " + filter.node.path, filter.node.identifier);
        for (const auto& [name, value] : filter.node.parameters) {
            out->Line("  " + name, ParameterText(value));
        }
        for (const auto& [name, source] : filter.node.connections) {
            out->Line("  " + name, "<- " + source.upstreamPath + "." + source.upstreamOutput);
        }
        out->Matrix("  worldFromFilter", filter.worldFromFilter);
    }
}

void DumpVolume(const std::string& path, const VolumePrim& prim, const SceneDescription& scene,
                const LinkedLights& lights, Writer* out) {
    out->Prim("volume", path);
    out->Placed(prim.placement);
    out->Line("purpose", prim.purpose);
    out->Line("material", HasVolume(scene, prim.materialPath) ? prim.materialPath : "");
    for (const auto& [name, field] : prim.fields) {
        out->Line("field " + name,
                  Text(field.asset) + " " + field.gridName + " " + Number(field.gridIndex));
    }
    DumpUnlit("", lights, prim.categories, out); // it casts shadows of all
}

void DumpCamera(const std::string& path, const CameraPrim& camera, Writer* out) {
    out->Prim("camera", path);
    ForEachField<CameraPrim>([&](const auto& field) {
        if (field.Is(&CameraPrim::worldFromCamera)) {
            out->Matrix("transform", camera.worldFromCamera);
        } else if (field.Is(&CameraPrim::orthographic)) {
            out->Line("projection", camera.orthographic ? "orthographic" : "perspective");
        } else if (field.Is(&CameraPrim::shutter)) {
            const double ends[] = {camera.shutter.open, camera.shutter.close};
            if (camera.shutter.IsOpen()) {
                out->Line("shutter", Array(ends, 2));
            }
        } else {
            out->Value(field.name, camera.*field.member);
        }
    });
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

/// Materials of the prims that are shown.
std::set<std::string> BoundMaterials(const SceneDescription& scene) {
    std::set<std::string> bound;
    for (const auto& [path, prim] : scene.geometry) {
        if (IsShown(scene, prim.placement)) {
            bound.insert(prim.materialPath);
            bound.insert(prim.subsetMaterialPaths.begin(), prim.subsetMaterialPaths.end());
        }
    }
    for (const auto& [path, prim] : scene.volumes) {
        if (IsShown(scene, prim.placement)) {
            bound.insert(prim.materialPath);
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
        if (bound.count(path) > 0 && IsMaterial(scene, path)) {
            DumpMaterial(path, *network, &out);
        }
    }
    for (const auto& [path, prim] : scene.geometry) {
        if (IsShown(scene, prim.placement)) {
            DumpGeometry(path, prim, scene, lights, &out);
        }
    }
    for (const auto& [path, prim] : scene.volumes) {
        if (IsShown(scene, prim.placement)) {
            DumpVolume(path, prim, scene, lights, &out);
        }
    }
    return out.Take();
}

} // namespace hds
