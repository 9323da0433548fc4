// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/volumeShader.h"

#include "hdStream/shading/volumeCoefficient.h"

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

/// What a distribution node says.
struct Medium {
    VolumeCoefficient absorption;
    VolumeCoefficient scattering;
    float anisotropy = 0.0F;
};

VolumeCoefficient Constant(glm::vec3 color) {
    return VolumeCoefficient(color);
}

/// One that has no field follows the density.
VolumeCoefficient Following(const VolumeCoefficient& coefficient, const std::string& density) {
    return coefficient.HasFields() ? coefficient : coefficient * VolumeCoefficient(density);
}

/// The terms of three coefficients.
std::vector<VolumeTerm> TermsOf(const VolumeCoefficient& absorption,
                                const VolumeCoefficient& scattering,
                                const VolumeCoefficient& emission) {
    std::vector<VolumeTerm> terms;
    const auto add = [&](const VolumeCoefficient& coefficient, glm::vec3 VolumeTerm::*member) {
        for (const FieldProduct& product : coefficient.Products()) {
            auto term = std::find_if(terms.begin(), terms.end(), [&](const VolumeTerm& mine) {
                return mine.fields == product.fields;
            });
            if (term == terms.end()) {
                term = terms.insert(terms.end(), VolumeTerm{product.fields});
            }
            (*term).*member = product.color;
        }
    };
    add(absorption, &VolumeTerm::absorption);
    add(scattering, &VolumeTerm::scattering);
    add(emission, &VolumeTerm::emission);
    return terms;
}

/// Says what three coefficients are: in the plain form where that does. \param density name of the
/// field where none is named.
void SetCoefficients(const VolumeCoefficient& absorption, const VolumeCoefficient& scattering,
                     const VolumeCoefficient& emission, const std::string& density,
                     VolumeShading* shading) {
    shading->absorption = absorption.AtOne();
    shading->scattering = scattering.AtOne();
    shading->emission = emission.AtOne();
    const std::string first = absorption.FirstField();
    const std::string second = scattering.FirstField();
    // Where only one follows a field, and follows just that, the other follows it too.
    const bool isPlain = (first.empty() || absorption.IsMultipleOf(first)) &&
                         (second.empty() || scattering.IsMultipleOf(second)) &&
                         (first.empty() || second.empty() || first == second);
    shading->density = !isPlain          ? density
                       : !second.empty() ? second
                       : !first.empty()  ? first
                                         : density;
    shading->emissionField = emission.FirstField();
    const bool isEmissionPlain =
        !emission.HasFields() || emission.IsMultipleOf(shading->emissionField);
    if (!isPlain || !isEmissionPlain) {
        shading->terms =
            TermsOf(Following(absorption, shading->density),
                    Following(scattering, shading->density), Following(emission, shading->density));
        for (glm::vec3* sum : {&shading->absorption, &shading->scattering, &shading->emission}) {
            *sum = glm::max(*sum, glm::vec3(0.0F));
        }
    }
}

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
        const VolumeCoefficient emission = EmissionOf(Upstream(*root, "edf"), 0);
        shading.anisotropy = medium.anisotropy;
        SetCoefficients(medium.absorption, medium.scattering, emission, kDensity, &shading);
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

    static glm::vec3 Parameter(const MaterialNode& node, const std::string& input,
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
        return Parameter(node, input, glm::vec3(fallback)).x;
    }

    /// The value of an input.
    VolumeCoefficient ValueOf(const MaterialNode& node, const std::string& input,
                              glm::vec3 fallback, int depth) const {
        const MaterialNode* source = Upstream(node, input);
        if (source == nullptr || depth > kMaxDepth) {
            return Constant(Parameter(node, input, fallback));
        }
        return ValueOfNode(*source, fallback, depth + 1);
    }

    VolumeCoefficient ValueOfNode(const MaterialNode& node, glm::vec3 fallback, int depth) const {
        const auto value = [&](const char* input, float otherwise) {
            return ValueOf(node, input, glm::vec3(otherwise), depth);
        };
        const std::string& id = node.identifier;
        if (StartsWith(id, "ND_geompropvalue_")) {
            return VolumeCoefficient(Text(node, "geomprop", kDensity));
        }
        if (StartsWith(id, "UsdPrimvarReader_")) {
            return VolumeCoefficient(Text(node, "varname", kDensity));
        }
        if (StartsWith(id, "ND_multiply_")) {
            return value("in1", 0.0F) * value("in2", 1.0F);
        }
        if (StartsWith(id, "ND_add_")) {
            return value("in1", 0.0F) + value("in2", 0.0F);
        }
        if (StartsWith(id, "ND_subtract_")) {
            return value("in1", 0.0F) - value("in2", 0.0F);
        }
        if (StartsWith(id, "ND_invert_")) {
            return value("amount", 1.0F) - value("in", 0.0F);
        }
        if (StartsWith(id, "ND_mix_")) {
            const VolumeCoefficient share = value("mix", 0.0F);
            return value("bg", 0.0F) * (Constant(glm::vec3(1.0F)) - share) +
                   value("fg", 0.0F) * share;
        }
        if (StartsWith(id, "ND_divide_")) {
            const VolumeCoefficient divisor = value("in2", 1.0F);
            if (!divisor.HasFields()) {
                return value("in1", 0.0F) / divisor.AtOne();
            }
        }
        if (StartsWith(id, "ND_combine3_")) {
            return value("in1", 0.0F) * Constant({1.0F, 0.0F, 0.0F}) +
                   value("in2", 0.0F) * Constant({0.0F, 1.0F, 0.0F}) +
                   value("in3", 0.0F) * Constant({0.0F, 0.0F, 1.0F});
        }
        if (StartsWith(id, "ND_constant_")) {
            return value("value", 0.0F);
        }
        if (StartsWith(id, "ND_convert_") || StartsWith(id, "ND_dot_")) {
            return value("in", 0.0F);
        }
        _warn("node " + id + " is not known in volumes");
        return Constant(fallback);
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
            medium.absorption = a.absorption + b.absorption;
            medium.scattering = a.scattering + b.scattering;
            const float wa = a.scattering.AtOne().y;
            const float wb = b.scattering.AtOne().y;
            medium.anisotropy =
                wa + wb > 0.0F ? (wa * a.anisotropy + wb * b.anisotropy) / (wa + wb) : 0.0F;
        } else if (StartsWith(id, "ND_multiply_vdf")) {
            const VolumeCoefficient factor = ValueOf(*node, "in2", glm::vec3(1.0F), depth + 1);
            medium = MediumOf(Upstream(*node, "in1"), depth + 1);
            medium.absorption = medium.absorption * factor;
            medium.scattering = medium.scattering * factor;
        } else if (id != "ND_absorption_vdf") {
            _warn("node " + id + " is not known in volumes");
        }
        return medium;
    }

    VolumeCoefficient EmissionOf(const MaterialNode* node, int depth) const {
        if (node == nullptr || depth > kMaxDepth) {
            return {};
        }
        if (node->identifier == "ND_uniform_edf") {
            return ValueOf(*node, "color", glm::vec3(1.0F), depth + 1);
        }
        if (StartsWith(node->identifier, "ND_multiply_edf")) {
            return EmissionOf(Upstream(*node, "in1"), depth + 1) *
                   ValueOf(*node, "in2", glm::vec3(1.0F), depth + 1);
        }
        _warn("node " + node->identifier + " is not known in volumes");
        return {};
    }

    /// An input of a host's shader that is a colour: a constant or a network, times a field that
    /// is named by another input.
    VolumeCoefficient Channelled(const MaterialNode& node, const std::string& input,
                                 glm::vec3 fallback, const std::string& channel) const {
        const std::string field = Text(node, channel, "");
        const VolumeCoefficient value = ValueOf(node, input, fallback, 0);
        return field.empty() ? value : value * VolumeCoefficient(field);
    }

    /// Of an extinction, and of what part of it scatters.
    static void SetMedium(const VolumeCoefficient& extinction, const VolumeCoefficient& albedo,
                          const VolumeCoefficient& emission, const std::string& density,
                          VolumeShading* shading) {
        SetCoefficients(extinction * (Constant(glm::vec3(1.0F)) - albedo), extinction * albedo,
                        emission, density, shading);
    }

    /// Constants outside of [0, 1] are no albedo.
    static VolumeCoefficient Albedo(const VolumeCoefficient& color) {
        return color.HasFields()
                   ? color
                   : Constant(glm::clamp(color.AtOne(), glm::vec3(0.0F), glm::vec3(1.0F)));
    }

    /// Arnold's standard_volume, by its user guide.
    VolumeShading ReadStandardVolume(const MaterialNode& node) const {
        VolumeShading shading;
        const glm::vec3 transparent = Parameter(node, "transparent", glm::vec3(0.367879F));
        const float depth = std::max(Number(node, "transparent_depth", 1.0F), 1e-6F);
        const glm::vec3 extinction =
            -glm::log(glm::clamp(transparent, glm::vec3(1e-6F), glm::vec3(1.0F)));
        const std::string channel = Text(node, "density_channel", kDensity);
        const VolumeCoefficient density = ValueOf(node, "density", glm::vec3(1.0F), 0);
        shading.anisotropy = Number(node, "scatter_anisotropy", 0.0F);
        const std::string mode = Text(node, "emission_mode", "blackbody");
        VolumeCoefficient emission;
        if (mode == "channel" || mode == "density") {
            emission = ValueOf(node, "emission", glm::vec3(1.0F), 0) *
                       Channelled(node, "emission_color", glm::vec3(1.0F),
                                  mode == "channel" ? "emission_channel" : "");
            if (mode == "density") {
                emission = emission * VolumeCoefficient(channel);
            }
        } else if (mode == "blackbody") {
            shading.blackbody = glm::vec3(Number(node, "blackbody_intensity", 1.0F)) *
                                Parameter(node, "emission_color", glm::vec3(1.0F));
            shading.kelvin =
                Number(node, "temperature", 1.0F) * Number(node, "blackbody_kelvin", 5000.0F);
            shading.temperatureField = Text(node, "temperature_channel", "temperature");
        }
        SetMedium(
            density / glm::vec3(depth) * Constant(extinction) * VolumeCoefficient(channel),
            Albedo(ValueOf(node, "scatter", glm::vec3(1.0F), 0) *
                   Channelled(node, "scatter_color", glm::vec3(0.5F), "scatter_color_channel")),
            emission, channel, &shading);
        return shading;
    }

    /// RenderMan's PxrVolume, by its documentation: one lobe, without multi-scattering controls.
    VolumeShading ReadPxrVolume(const MaterialNode& node) const {
        VolumeShading shading;
        const float distance = std::max(Number(node, "extinctionDistance", 1.0F), 1e-6F);
        const std::string channel = Text(node, "densityFloatPrimVar", kDensity);
        VolumeCoefficient extinction =
            ValueOf(node, "densityFloat", glm::vec3(1.0F), 0) *
            Channelled(node, "densityColor", glm::vec3(1.0F), "densityColorPrimVar");
        if (!extinction.HasFields()) {
            extinction = Constant(glm::max(extinction.AtOne(), glm::vec3(0.0F)));
        }
        extinction = extinction / glm::vec3(distance) * VolumeCoefficient(channel);
        shading.anisotropy = Number(node, "anisotropy", 0.0F);
        SetMedium(extinction, Albedo(ValueOf(node, "diffuseColor", glm::vec3(1.0F), 0)),
                  ValueOf(node, "emitIntensity", glm::vec3(1.0F), 0) *
                      Channelled(node, "emitColor", glm::vec3(0.0F), "emitColorPrimVar"),
                  channel, &shading);
        return shading;
    }

    const MaterialNetwork& _network;
    const std::function<void(const std::string&)>& _warn;
};

bool IsTermFinite(const VolumeTerm& term) {
    const glm::vec3 sum =
        glm::abs(term.absorption) + glm::abs(term.scattering) + glm::abs(term.emission);
    return std::isfinite(sum.x) && std::isfinite(sum.y) && std::isfinite(sum.z);
}

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
           std::all_of(shading.terms.begin(), shading.terms.end(), IsTermFinite) &&
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
