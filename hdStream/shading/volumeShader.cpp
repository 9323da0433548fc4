// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/volumeShader.h"

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <cmath>
#include <variant>

namespace hds {

namespace {

constexpr int kMaxDepth = 32;
const char* const kDensity = "density";

/// A colour times a field.
struct Coefficient {
    glm::vec3 color{0.0F};
    std::string field; ///< empty: none
};

/// What a distribution node says.
struct Medium {
    Coefficient absorption;
    Coefficient scattering;
    float anisotropy = 0.0F;
};

bool StartsWith(const std::string& text, const std::string& start) {
    return text.compare(0, start.size(), start) == 0;
}

/// Follows one network.
class Reader {
public:
    Reader(const MaterialNetwork& network, const std::function<void(const std::string&)>& warn)
        : _network(network), _warn(warn) {}

    VolumeShading Read() {
        const MaterialNode* root = NodeAt(_network.terminals.at("volume").upstreamPath);
        VolumeShading shading;
        if (root == nullptr) {
            return DefaultVolumeShading();
        }
        if (root->identifier == "arnold:standard_volume" || root->identifier == "standard_volume") {
            return ReadStandardVolume(*root);
        }
        if (root->identifier == "PxrVolume") {
            return ReadPxrVolume(*root);
        }
        if (root->identifier != "ND_volume") {
            _warn("volume shader " + root->identifier + " is not known; drawn as grey smoke");
            return DefaultVolumeShading();
        }
        const Medium medium = MediumOf(Upstream(*root, "vdf"), 0);
        const Coefficient emission = EmissionOf(Upstream(*root, "edf"), 0);
        shading.absorption = medium.absorption.color;
        shading.scattering = medium.scattering.color;
        shading.anisotropy = medium.anisotropy;
        shading.emission = emission.color;
        shading.emissionField = emission.field;
        const std::string& first = medium.absorption.field;
        const std::string& second = medium.scattering.field;
        shading.density = !second.empty() ? second : !first.empty() ? first : kDensity;
        if (!first.empty() && !second.empty() && first != second) {
            _warn("absorption and scattering follow different fields; both follow " + second);
        }
        return shading;
    }

private:
    const MaterialNode* NodeAt(const std::string& path) const {
        const auto found =
            std::find_if(_network.nodes.begin(), _network.nodes.end(),
                         [&](const MaterialNode& node) { return node.path == path; });
        return found == _network.nodes.end() ? nullptr : &*found;
    }

    const MaterialNode* Upstream(const MaterialNode& node, const std::string& input) const {
        const auto found = node.connections.find(input);
        return found == node.connections.end() ? nullptr : NodeAt(found->second.upstreamPath);
    }

    static glm::vec3 Constant(const MaterialNode& node, const std::string& input,
                              glm::vec3 fallback) {
        const auto found = node.parameters.find(input);
        if (found == node.parameters.end()) {
            return fallback;
        }
        if (const auto* number = std::get_if<double>(&found->second)) {
            return glm::vec3(static_cast<float>(*number));
        }
        if (const auto* number = std::get_if<std::int64_t>(&found->second)) {
            return glm::vec3(static_cast<float>(*number));
        }
        if (const auto* vector = std::get_if<std::vector<float>>(&found->second)) {
            if (vector->size() >= 3) {
                return {(*vector)[0], (*vector)[1], (*vector)[2]};
            }
        }
        return fallback;
    }

    static std::string Text(const MaterialNode& node, const std::string& input,
                            const std::string& fallback) {
        const auto found = node.parameters.find(input);
        const auto* text =
            found == node.parameters.end() ? nullptr : std::get_if<std::string>(&found->second);
        return text != nullptr && !text->empty() ? *text : fallback;
    }

    static float Number(const MaterialNode& node, const std::string& input, float fallback) {
        return Constant(node, input, glm::vec3(fallback)).x;
    }

    Coefficient Product(const Coefficient& a, const Coefficient& b) const {
        if (!a.field.empty() && !b.field.empty()) {
            _warn("a product of the fields " + a.field + " and " + b.field +
                  " is drawn as the first");
        }
        return {a.color * b.color, a.field.empty() ? b.field : a.field};
    }

    /// The value of an input.
    Coefficient ValueOf(const MaterialNode& node, const std::string& input, glm::vec3 fallback,
                        int depth) const {
        const MaterialNode* source = Upstream(node, input);
        if (source == nullptr || depth > kMaxDepth) {
            return {Constant(node, input, fallback), ""};
        }
        const std::string& id = source->identifier;
        if (StartsWith(id, "ND_geompropvalue_")) {
            return {glm::vec3(1.0F), Text(*source, "geomprop", kDensity)};
        }
        if (StartsWith(id, "UsdPrimvarReader_")) {
            return {glm::vec3(1.0F), Text(*source, "varname", kDensity)};
        }
        if (StartsWith(id, "ND_multiply_")) {
            return Product(ValueOf(*source, "in1", glm::vec3(0.0F), depth + 1),
                           ValueOf(*source, "in2", glm::vec3(1.0F), depth + 1));
        }
        if (StartsWith(id, "ND_constant_")) {
            return ValueOf(*source, "value", glm::vec3(0.0F), depth + 1);
        }
        if (StartsWith(id, "ND_convert_") || StartsWith(id, "ND_dot_")) {
            return ValueOf(*source, "in", glm::vec3(0.0F), depth + 1);
        }
        _warn("node " + id + " is not known in volumes");
        return {fallback, ""};
    }

    Medium MediumOf(const MaterialNode* node, int depth) const {
        Medium medium;
        if (node == nullptr || depth > kMaxDepth) {
            return medium;
        }
        const std::string& id = node->identifier;
        if (id == "ND_absorption_vdf" || id == "ND_anisotropic_vdf") {
            medium.absorption = ValueOf(*node, "absorption", glm::vec3(0.0F), depth + 1);
        }
        if (id == "ND_anisotropic_vdf") {
            medium.scattering = ValueOf(*node, "scattering", glm::vec3(0.0F), depth + 1);
            medium.anisotropy = Number(*node, "anisotropy", 0.0F);
        } else if (id == "ND_add_vdf") {
            const Medium a = MediumOf(Upstream(*node, "in1"), depth + 1);
            const Medium b = MediumOf(Upstream(*node, "in2"), depth + 1);
            medium.absorption = Sum(a.absorption, b.absorption);
            medium.scattering = Sum(a.scattering, b.scattering);
            const float wa = a.scattering.color.y;
            const float wb = b.scattering.color.y;
            medium.anisotropy =
                wa + wb > 0.0F ? (wa * a.anisotropy + wb * b.anisotropy) / (wa + wb) : 0.0F;
        } else if (StartsWith(id, "ND_multiply_vdf")) {
            const Coefficient factor = ValueOf(*node, "in2", glm::vec3(1.0F), depth + 1);
            medium = MediumOf(Upstream(*node, "in1"), depth + 1);
            medium.absorption = Product(medium.absorption, factor);
            medium.scattering = Product(medium.scattering, factor);
        } else if (id != "ND_absorption_vdf") {
            _warn("node " + id + " is not known in volumes");
        }
        return medium;
    }

    static Coefficient Sum(const Coefficient& a, const Coefficient& b) {
        return {a.color + b.color, a.field.empty() ? b.field : a.field};
    }

    Coefficient EmissionOf(const MaterialNode* node, int depth) const {
        if (node == nullptr || depth > kMaxDepth) {
            return {};
        }
        if (node->identifier == "ND_uniform_edf") {
            return ValueOf(*node, "color", glm::vec3(1.0F), depth + 1);
        }
        if (StartsWith(node->identifier, "ND_multiply_edf")) {
            return Product(EmissionOf(Upstream(*node, "in1"), depth + 1),
                           ValueOf(*node, "in2", glm::vec3(1.0F), depth + 1));
        }
        _warn("node " + node->identifier + " is not known in volumes");
        return {};
    }

    /// Arnold's standard_volume, by its user guide.
    VolumeShading ReadStandardVolume(const MaterialNode& node) const {
        VolumeShading shading;
        const glm::vec3 transparent = Constant(node, "transparent", glm::vec3(0.367879F));
        const float depth = std::max(Number(node, "transparent_depth", 1.0F), 1e-6F);
        const glm::vec3 extinction =
            Number(node, "density", 1.0F) / depth *
            -glm::log(glm::clamp(transparent, glm::vec3(1e-6F), glm::vec3(1.0F)));
        const glm::vec3 albedo = glm::clamp(Number(node, "scatter", 1.0F) *
                                                Constant(node, "scatter_color", glm::vec3(0.5F)),
                                            glm::vec3(0.0F), glm::vec3(1.0F));
        shading.scattering = extinction * albedo;
        shading.absorption = extinction * (glm::vec3(1.0F) - albedo);
        shading.anisotropy = Number(node, "scatter_anisotropy", 0.0F);
        shading.density = Text(node, "density_channel", kDensity);
        const std::string mode = Text(node, "emission_mode", "blackbody");
        if (mode == "channel" || mode == "density") {
            shading.emission =
                Number(node, "emission", 1.0F) * Constant(node, "emission_color", glm::vec3(1.0F));
            shading.emissionField =
                mode == "channel" ? Text(node, "emission_channel", "") : shading.density;
        } else if (mode == "blackbody") {
            shading.blackbody = glm::vec3(Number(node, "blackbody_intensity", 1.0F)) *
                                Constant(node, "emission_color", glm::vec3(1.0F));
            shading.kelvin =
                Number(node, "temperature", 1.0F) * Number(node, "blackbody_kelvin", 5000.0F);
            shading.temperatureField = Text(node, "temperature_channel", "temperature");
        }
        return shading;
    }

    /// RenderMan's PxrVolume, by its documentation: one lobe, without multi-scattering controls.
    VolumeShading ReadPxrVolume(const MaterialNode& node) const {
        VolumeShading shading;
        const float distance = std::max(Number(node, "extinctionDistance", 1.0F), 1e-6F);
        const glm::vec3 extinction =
            glm::max(Number(node, "densityFloat", 1.0F) *
                         Constant(node, "densityColor", glm::vec3(1.0F)) / distance,
                     glm::vec3(0.0F));
        const glm::vec3 albedo = glm::clamp(Constant(node, "diffuseColor", glm::vec3(1.0F)),
                                            glm::vec3(0.0F), glm::vec3(1.0F));
        shading.scattering = extinction * albedo;
        shading.absorption = extinction * (glm::vec3(1.0F) - albedo);
        shading.anisotropy = Number(node, "anisotropy", 0.0F);
        shading.density = Text(node, "densityFloatPrimVar", kDensity);
        shading.emission =
            Number(node, "emitIntensity", 1.0F) * Constant(node, "emitColor", glm::vec3(0.0F));
        shading.emissionField = Text(node, "emitColorPrimVar", shading.density);
        return shading;
    }

    const MaterialNetwork& _network;
    const std::function<void(const std::string&)>& _warn;
};

} // namespace

VolumeShading DefaultVolumeShading() {
    VolumeShading shading;
    shading.scattering = glm::vec3(0.5F);
    shading.absorption = glm::vec3(0.5F);
    shading.density = kDensity;
    return shading;
}

bool IsFinite(const VolumeShading& shading) {
    const glm::vec3 sum = shading.absorption + shading.scattering + shading.emission +
                          shading.blackbody + glm::vec3(shading.kelvin + shading.anisotropy);
    return std::isfinite(sum.x) && std::isfinite(sum.y) && std::isfinite(sum.z) &&
           glm::all(glm::greaterThanEqual(shading.absorption, glm::vec3(0.0F))) &&
           glm::all(glm::greaterThanEqual(shading.scattering, glm::vec3(0.0F))) &&
           glm::all(glm::greaterThanEqual(shading.emission, glm::vec3(0.0F))) &&
           glm::all(glm::greaterThanEqual(shading.blackbody, glm::vec3(0.0F)));
}

VolumeShading ReadVolumeShading(const MaterialNetwork& network,
                                const std::function<void(const std::string&)>& warn) {
    return Reader(network, warn).Read();
}

} // namespace hds
