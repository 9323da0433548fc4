// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/volumeShader.h"

#include "hdStream/shading/shaderNetwork.h"
#include "hdStream/shading/volumeCoefficient.h"

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <cmath>
#include <set>
#include <variant>

namespace hds {

namespace {

constexpr int kMaxDepth = 32;
constexpr int kMaxWays = 4096;
const char* const kDensity = "density";
const char* const kVolume = "ND_volume";
const char* const kMixVolume = "ND_mix_volumeshader";

/// What a distribution node says.
struct Medium {
    VolumeCoefficient absorption;
    VolumeCoefficient scattering;
    float anisotropy = 0.0F;
    VolumeCoefficient turned; ///< scattering times anisotropy
    bool turnsVary = false;   ///< the anisotropy is no constant
};

VolumeCoefficient Constant(glm::vec3 color) {
    return VolumeCoefficient(color);
}

/// The terms of coefficients.
std::vector<VolumeTerm> TermsOf(const Medium& medium, const VolumeCoefficient& emission) {
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
    add(medium.absorption, &VolumeTerm::absorption);
    add(medium.scattering, &VolumeTerm::scattering);
    add(emission, &VolumeTerm::emission);
    if (medium.turnsVary) {
        add(medium.turned, &VolumeTerm::turned);
    }
    return terms;
}

bool StartsWith(const std::string& text, const std::string& start) {
    return text.compare(0, start.size(), start) == 0;
}

bool IsField(const MaterialNode& node) {
    return StartsWith(node.identifier, "ND_geompropvalue_") ||
           StartsWith(node.identifier, "UsdPrimvarReader_");
}

/// Follows one network.
class Reader {
public:
    Reader(const MaterialNetwork& network, VolumePatterns* patterns,
           const std::function<void(const std::string&)>& warn)
        : _network(network), _patterns(patterns), _warn(warn) {}

    VolumeShading Read() {
        const MaterialNode* root = FindTerminalShader(_network, "volume");
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
        if (root->identifier != kVolume && root->identifier != kMixVolume) {
            _warn("volume shader " + root->identifier + " is not known; drawn as grey smoke");
            return DefaultVolumeShading();
        }
        SetCoefficients(MediumOf(root, 0), EmissionOf(root, 0), kDensity, &shading);
        return shading;
    }

private:
    /// Counts the ways through the network: there may be exponentially many, or a cycle.
    bool MayGoOn() const {
        if (++_numWays == kMaxWays) {
            _warn("network with a cycle, or too large: a part of it is left out");
        }
        return _numWays < kMaxWays;
    }

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

    /// A volume or a distribution that is mixed.
    const MaterialNode* Shader(const MaterialNode& node, const std::string& input) const {
        return FindInputShader(_network, node, input);
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

    /// The first field of a coefficient, those that its patterns read included; empty: none.
    std::string FirstField(const VolumeCoefficient& coefficient) const {
        for (const FieldProduct& product : coefficient.Products()) {
            for (const std::string& name : product.fields) {
                const std::optional<std::size_t> number = PatternNumber(name);
                if (!number) {
                    return name;
                }
                const std::set<std::string> fields = FieldsOf(_patterns->Values()[*number]);
                if (!fields.empty()) {
                    return *fields.begin();
                }
            }
        }
        return "";
    }

    /// One that has no field follows the density.
    VolumeCoefficient Following(const VolumeCoefficient& coefficient,
                                const std::string& density) const {
        return FirstField(coefficient).empty() ? coefficient * VolumeCoefficient(density)
                                               : coefficient;
    }

    /// Whether the plain form does for a coefficient: a constant, or one times its field.
    bool IsPlain(const VolumeCoefficient& coefficient) const {
        return !coefficient.HasFields() || coefficient.IsMultipleOf(FirstField(coefficient));
    }

    /// Says what coefficients are: in the plain form where that does. \param density name of the
    /// field where none is named.
    void SetCoefficients(const Medium& medium, const VolumeCoefficient& emission,
                         const std::string& density, VolumeShading* shading) const {
        shading->absorption = medium.absorption.AtOne();
        shading->scattering = medium.scattering.AtOne();
        shading->emission = emission.AtOne();
        shading->anisotropy = medium.anisotropy;
        const std::string first = FirstField(medium.absorption);
        const std::string second = FirstField(medium.scattering);
        // Where only one follows a field, and follows just that, the other follows it too.
        const bool isPlain = !medium.turnsVary && IsPlain(medium.absorption) &&
                             IsPlain(medium.scattering) &&
                             (first.empty() || second.empty() || first == second);
        shading->density = !isPlain          ? density
                           : !second.empty() ? second
                           : !first.empty()  ? first
                                             : density;
        shading->emissionField = FirstField(emission);
        if (isPlain && IsPlain(emission)) {
            return;
        }
        Medium placed = medium;
        placed.absorption = Following(medium.absorption, shading->density);
        placed.scattering = Following(medium.scattering, shading->density);
        if (second.empty()) {
            placed.turned = medium.turned * VolumeCoefficient(shading->density);
        }
        shading->terms = TermsOf(placed, Following(emission, shading->density));
        shading->turnsVary = medium.turnsVary;
        for (glm::vec3* sum : {&shading->absorption, &shading->scattering, &shading->emission}) {
            *sum = glm::max(*sum, glm::vec3(0.0F));
        }
    }

    /// Whether a node makes sums and products, constants or fields.
    bool IsOfTerms(const MaterialNode& node) const {
        static const char* const kStarts[] = {"ND_multiply_", "ND_add_",     "ND_subtract_",
                                              "ND_invert_",   "ND_mix_",     "ND_combine3_",
                                              "ND_constant_", "ND_convert_", "ND_dot_"};
        if (StartsWith(node.identifier, "ND_divide_")) {
            const MaterialNode* divisor = Upstream(node, "in2");
            return divisor == nullptr || StartsWith(divisor->identifier, "ND_constant_");
        }
        return IsField(node) ||
               std::any_of(std::begin(kStarts), std::end(kStarts),
                           [&](const char* start) { return StartsWith(node.identifier, start); });
    }

    /// Adds the nodes that feed a node, and itself.
    void AddSources(const MaterialNode& node, std::set<const MaterialNode*>* sources) const {
        if (!sources->insert(&node).second) {
            return;
        }
        for (const auto& [input, connection] : node.connections) {
            if (const MaterialNode* source = NodeAt(connection.upstreamPath)) {
                AddSources(*source, sources);
            }
        }
    }

    /// Whether what feeds an input is a pattern: it computes more than sums and products, and
    /// either here or of no field. What else computes is a sum of products of patterns and fields.
    bool IsPattern(const MaterialNode& source) const {
        std::set<const MaterialNode*> sources;
        AddSources(source, &sources);
        const bool computes =
            !std::all_of(sources.begin(), sources.end(),
                         [&](const MaterialNode* one) { return IsOfTerms(*one); });
        return computes && (!IsOfTerms(source) ||
                            std::none_of(sources.begin(), sources.end(),
                                         [](const MaterialNode* one) { return IsField(*one); }));
    }

    VolumeCoefficient ValueOfPattern(const MaterialNode& node, const std::string& input,
                                     glm::vec3 fallback) const {
        const ShaderValue value =
            _patterns->Evaluate(node, input, {fallback.x, fallback.y, fallback.z, 1.0F});
        if (IsConstant(value)) {
            const std::array<float, 4>& constant = ConstantOf(value);
            return Constant({constant[0], constant[1], constant[2]});
        }
        return VolumeCoefficient(PatternName(_patterns->Add(value)));
    }

    /// The value of an input.
    VolumeCoefficient ValueOf(const MaterialNode& node, const std::string& input,
                              glm::vec3 fallback, int depth) const {
        const MaterialNode* source = Upstream(node, input);
        if (source == nullptr || depth > kMaxDepth || !MayGoOn()) {
            return Constant(Parameter(node, input, fallback));
        }
        if (_patterns != nullptr && IsPattern(*source)) {
            return ValueOfPattern(node, input, fallback);
        }
        return ValueOfNode(*source, fallback, depth + 1);
    }

    /// Sets how much what scatters turns light.
    void SetTurns(const MaterialNode& node, const std::string& input, int depth,
                  Medium* medium) const {
        const VolumeCoefficient anisotropy = ValueOf(node, input, glm::vec3(0.0F), depth);
        medium->anisotropy = anisotropy.AtOne().x;
        medium->turned = medium->scattering * anisotropy;
        medium->turnsVary = anisotropy.HasFields() && medium->turned.HasFields();
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

    static Medium SumOf(const Medium& a, const Medium& b) {
        Medium sum;
        sum.absorption = a.absorption + b.absorption;
        sum.scattering = a.scattering + b.scattering;
        const float wa = a.scattering.AtOne().y;
        const float wb = b.scattering.AtOne().y;
        sum.anisotropy =
            wa + wb > 0.0F ? (wa * a.anisotropy + wb * b.anisotropy) / (wa + wb) : 0.0F;
        sum.turned = a.turned + b.turned;
        sum.turnsVary = a.turnsVary || b.turnsVary;
        return sum;
    }

    static Medium ProductOf(Medium medium, const VolumeCoefficient& factor) {
        medium.absorption = medium.absorption * factor;
        medium.scattering = medium.scattering * factor;
        medium.turned = medium.turned * factor;
        return medium;
    }

    /// What a mix takes of its front; the back has what is left.
    VolumeCoefficient ShareOf(const MaterialNode& mix, int depth) const {
        const VolumeCoefficient share = ValueOf(mix, "mix", glm::vec3(0.0F), depth);
        return share.HasFields()
                   ? share
                   : Constant(glm::clamp(share.AtOne(), glm::vec3(0.0F), glm::vec3(1.0F)));
    }

    static VolumeCoefficient Rest(const VolumeCoefficient& share) {
        return Constant(glm::vec3(1.0F)) - share;
    }

    /// Of a distribution, or of a volume.
    Medium MediumOf(const MaterialNode* node, int depth) const {
        Medium medium;
        if (node == nullptr || depth > kMaxDepth || !MayGoOn()) {
            return medium;
        }
        const std::string& id = node->identifier;
        if (id == kVolume) {
            return MediumOf(Upstream(*node, "vdf"), depth + 1);
        }
        if (id == kMixVolume || id == "ND_mix_vdf") {
            const VolumeCoefficient share = ShareOf(*node, depth + 1);
            return SumOf(ProductOf(MediumOf(Shader(*node, "bg"), depth + 1), Rest(share)),
                         ProductOf(MediumOf(Shader(*node, "fg"), depth + 1), share));
        }
        if (id == "ND_absorption_vdf" || id == "ND_anisotropic_vdf") {
            medium.absorption = ValueOf(*node, "absorption", glm::vec3(0.0F), depth + 1);
        }
        if (id == "ND_anisotropic_vdf") {
            medium.scattering = ValueOf(*node, "scattering", glm::vec3(0.0F), depth + 1);
            SetTurns(*node, "anisotropy", depth + 1, &medium);
        } else if (id == "ND_add_vdf") {
            medium = SumOf(MediumOf(Upstream(*node, "in1"), depth + 1),
                           MediumOf(Upstream(*node, "in2"), depth + 1));
        } else if (StartsWith(id, "ND_multiply_vdf")) {
            medium = ProductOf(MediumOf(Upstream(*node, "in1"), depth + 1),
                               ValueOf(*node, "in2", glm::vec3(1.0F), depth + 1));
        } else if (id != "ND_absorption_vdf") {
            _warn("node " + id + " is not known in volumes");
        }
        return medium;
    }

    VolumeCoefficient EmissionOf(const MaterialNode* node, int depth) const {
        if (node == nullptr || depth > kMaxDepth || !MayGoOn()) {
            return {};
        }
        if (node->identifier == kVolume) {
            return EmissionOf(Upstream(*node, "edf"), depth + 1);
        }
        if (node->identifier == kMixVolume || node->identifier == "ND_mix_edf") {
            const VolumeCoefficient share = ShareOf(*node, depth + 1);
            return EmissionOf(Shader(*node, "bg"), depth + 1) * Rest(share) +
                   EmissionOf(Shader(*node, "fg"), depth + 1) * share;
        }
        if (node->identifier == "ND_add_edf") {
            return EmissionOf(Upstream(*node, "in1"), depth + 1) +
                   EmissionOf(Upstream(*node, "in2"), depth + 1);
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

    /// Of an extinction, and of what part of it scatters. \param anisotropy input of the node.
    void SetMedium(const MaterialNode& node, const char* anisotropy,
                   const VolumeCoefficient& extinction, const VolumeCoefficient& albedo,
                   const VolumeCoefficient& emission, const std::string& density,
                   VolumeShading* shading) const {
        Medium medium;
        medium.absorption = extinction * (Constant(glm::vec3(1.0F)) - albedo);
        medium.scattering = extinction * albedo;
        SetTurns(node, anisotropy, 0, &medium);
        SetCoefficients(medium, emission, density, shading);
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
            node, "scatter_anisotropy",
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
        SetMedium(node, "anisotropy", extinction,
                  Albedo(ValueOf(node, "diffuseColor", glm::vec3(1.0F), 0)),
                  ValueOf(node, "emitIntensity", glm::vec3(1.0F), 0) *
                      Channelled(node, "emitColor", glm::vec3(0.0F), "emitColorPrimVar"),
                  channel, &shading);
        return shading;
    }

    const MaterialNetwork& _network;
    VolumePatterns* _patterns; ///< null: there are none
    mutable int _numWays = 0;
    const std::function<void(const std::string&)>& _warn;
};

bool IsTermFinite(const VolumeTerm& term) {
    const glm::vec3 sum = glm::abs(term.absorption) + glm::abs(term.scattering) +
                          glm::abs(term.emission) + glm::abs(term.turned);
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

VolumeShading ReadVolumeShading(const MaterialNetwork& network, VolumePatterns* patterns,
                                const std::function<void(const std::string&)>& warn) {
    return Reader(network, patterns, warn).Read();
}

} // namespace hds
