// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/transparentSides.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

using Connection = hds::MaterialNode::Connection;

constexpr double kLeastCover = 1e-6; ///< of what is divided by it

/// A number of a network: a constant, or what a node gives.
struct Number {
    double constant = 0.0;
    std::optional<Connection> from = {};

    bool Is(double value) const { return !from && constant == value; }
};

bool AreSame(const Number& a, const Number& b) {
    if (a.from && b.from) {
        return a.from->upstreamPath == b.from->upstreamPath &&
               a.from->upstreamOutput == b.from->upstreamOutput;
    }
    return !a.from && !b.from && a.constant == b.constant;
}

/// \return empty where nothing is connected.
std::string Upstream(const hds::MaterialNode& node, const char* input) {
    const auto connection = node.connections.find(input);
    return connection != node.connections.end() ? connection->second.upstreamPath : std::string();
}

Number InputOf(const hds::MaterialNode& node, const char* input, double fallback) {
    const auto connection = node.connections.find(input);
    if (connection != node.connections.end()) {
        return {0.0, connection->second};
    }
    const auto parameter = node.parameters.find(input);
    const double* value =
        parameter != node.parameters.end() ? std::get_if<double>(&parameter->second) : nullptr;
    return {value != nullptr ? std::clamp(*value, 0.0, 1.0) : fallback};
}

void SetInput(hds::MaterialNode* node, const char* input, const Number& value) {
    node->connections.erase(input);
    node->parameters.erase(input);
    if (value.from) {
        node->connections[input] = *value.from;
    } else {
        node->parameters[input] = value.constant;
    }
}

/// What the exporter makes of a Transparent BSDF: a diffuse one without a roughness, which no other
/// node of Blender's becomes.
bool IsTransparent(const hds::MaterialNode& node) {
    return node.identifier == "ND_oren_nayar_diffuse_bsdf" &&
           node.parameters.count("roughness") == 0 && node.connections.count("roughness") == 0;
}

/// What a Transparent BSDF of a constant colour does not let through.
double CoverOfColor(const hds::MaterialNode& node) {
    const auto parameter = node.parameters.find("color");
    const auto* color = parameter != node.parameters.end()
                            ? std::get_if<std::vector<float>>(&parameter->second)
                            : nullptr;
    if (color == nullptr || color->size() < 3) {
        return 0.0;
    }
    const double cover = 1.0 - ((*color)[0] + (*color)[1] + (*color)[2]) / 3.0;
    return cover > kLeastCover ? std::min(cover, 1.0) : 0.0; // of white, exactly
}

/// The path without what ends it: nodes of one node of Blender's differ in that alone.
std::string StemOf(const std::string& path) {
    return path.substr(0, path.rfind('_'));
}

class TransparentSides {
public:
    explicit TransparentSides(hds::MaterialNetwork* network) : _network(*network) {
        for (hds::MaterialNode& node : _network.nodes) {
            _nodes[node.path] = &node;
        }
    }

    void TakeOut() {
        for (hds::MaterialNode& node : _network.nodes) {
            if (node.identifier == "ND_surface") {
                Tell(&node);
            }
        }
        for (hds::MaterialNode& node : _network.nodes) {
            if (IsTransparent(node)) {
                SetInput(&node, "weight", {0.0}); // it reflects nothing
            }
        }
        _network.nodes.insert(_network.nodes.end(), _added.begin(), _added.end());
    }

private:
    hds::MaterialNode* Find(const std::string& path) const {
        const auto found = _nodes.find(path);
        return found != _nodes.end() ? found->second : nullptr;
    }

    /// How much of a surface a BSDF covers.
    struct Cover {
        Number share{1.0};
        /// The opacity that the exporter writes has it. Most BSDFs have none there, and count as
        /// if nothing were where something else has one.
        bool isTold = false;
    };

    /// The surface gets the opacity that its BSDF has, and mixes below it get their shares.
    void Tell(hds::MaterialNode* surface) {
        const std::string bsdf = Upstream(*surface, "bsdf");
        const bool isTold =
            surface->parameters.count("opacity") != 0 || surface->connections.count("opacity") != 0;
        const Cover cover = CoverOf(bsdf);
        if (!bsdf.empty() && !cover.isTold && (isTold || !cover.share.Is(1.0))) {
            SetInput(surface, "opacity", cover.share);
        }
    }

    Cover CoverOf(const std::string& path) {
        const auto [known, isNew] = _covers.try_emplace(path); // as in a cycle
        hds::MaterialNode* node = Find(path);
        if (!isNew || node == nullptr) {
            return known->second;
        }
        if (IsTransparent(*node)) {
            known->second = {OpacityOf(*node, CoverOfColor(*node)), true};
        } else if (node->identifier == "ND_layer_bsdf") { // Principled
            known->second = {OpacityOf(*node, 1.0), true};
        } else if (node->identifier == "ND_mix_bsdf") {
            known->second = WeighMix(node);
        } else if (node->identifier == "ND_multiply_bsdfF") {
            known->second = WeighAlone(node);
        } else if (node->identifier == "ND_add_bsdf") {
            known->second = MeanOf(*node);
        }
        return known->second;
    }

    /// What the exporter's node says of a BSDF, which is its namesake. \param constant where there
    /// is none.
    Number OpacityOf(const hds::MaterialNode& bsdf, double constant) const {
        const hds::MaterialNode* node = Find(StemOf(bsdf.path) + "_opacity");
        return node != nullptr ? Number{0.0, Connection{node->path, "out"}} : Number{constant};
    }

    Cover WeighMix(hds::MaterialNode* mix) {
        const std::string side = Upstream(*mix, "fg");
        const std::string other = Upstream(*mix, "bg");
        const Number before = InputOf(*mix, "mix", 0.0);
        const Cover ofSide = CoverOf(side); // one after the other: both may add nodes
        const Cover ofOther = CoverOf(other);
        const Sides sides = Weigh(*mix, before, ofSide, ofOther);
        if (sides.areAsBefore) {
            return sides.cover;
        }
        SetInput(mix, "mix", sides.share);
        hds::MaterialNode* emission = EmissionOf(*mix);
        if (emission != nullptr && emission->identifier == "ND_mix_edf") {
            SetInput(emission, "mix", sides.share);
        } else if (emission != nullptr && emission->identifier == "ND_multiply_edfF") {
            const std::string stem = StemOf(Upstream(*emission, "in1"));
            if (sides.share.Is(0.0) || sides.share.Is(1.0)) {
                SetInput(emission, "in2", {1.0}); // nothing transparent emits
            } else if (stem == StemOf(side) ||
                       (stem != StemOf(other) && AreSame(before, InputOf(*emission, "in2", 1.0)))) {
                SetInput(emission, "in2", sides.share);
            } else {
                SetInput(emission, "in2", OneMinus(*mix, sides.share));
            }
        }
        return sides.cover;
    }

    /// A mix whose other side has no BSDF: it emits, and covers all of its share.
    Cover WeighAlone(hds::MaterialNode* mix) {
        const std::string side = Upstream(*mix, "in1");
        const Sides sides = Weigh(*mix, InputOf(*mix, "in2", 1.0), CoverOf(side), Cover());
        if (sides.areAsBefore) {
            return sides.cover;
        }
        SetInput(mix, "in2", sides.share);
        hds::MaterialNode* emission = EmissionOf(*mix);
        const bool isMix = emission != nullptr && emission->identifier == "ND_mix_edf";
        if (isMix || (emission != nullptr && emission->identifier == "ND_multiply_edfF")) {
            const bool isSide = StemOf(Upstream(*emission, isMix ? "fg" : "in1")) == StemOf(side);
            SetInput(emission, isMix ? "mix" : "in2",
                     isSide ? sides.share : OneMinus(*mix, sides.share));
        }
        return sides.cover;
    }

    /// As the exporter has it: opacity cannot say what a sum is.
    Cover MeanOf(const hds::MaterialNode& sum) {
        const Cover a = CoverOf(Upstream(sum, "in1"));
        const Cover b = CoverOf(Upstream(sum, "in2"));
        const bool isTold = a.isTold && b.isTold;
        if (a.share.Is(1.0) && b.share.Is(1.0)) {
            return {{1.0}, isTold};
        }
        const Number both =
            Make(sum, "ND_add_float", a.share, b.share, a.share.constant + b.share.constant);
        return {Multiply(sum, both, {0.5}), isTold};
    }

    struct Sides {
        Cover cover;      ///< of both
        Number share;     ///< of the first side, of what both cover
        bool areAsBefore; ///< they cover all, or nothing
    };

    Sides Weigh(const hds::MaterialNode& mix, const Number& before, const Cover& cover,
                const Cover& otherCover) {
        const bool isTold = cover.isTold && otherCover.isTold;
        const Number& a = cover.share;
        const Number& b = otherCover.share;
        if ((a.Is(1.0) && b.Is(1.0)) || (a.Is(0.0) && b.Is(0.0))) {
            return {{a, isTold}, before, true};
        }
        const Number covered = Multiply(mix, before, a);
        const Number otherCovered = Multiply(mix, OneMinus(mix, before), b);
        if (a.Is(0.0)) {
            return {{otherCovered, isTold}, {0.0}, false};
        }
        if (b.Is(0.0)) {
            return {{covered, isTold}, {1.0}, false};
        }
        const Number both = Make(mix, "ND_add_float", covered, otherCovered,
                                 covered.constant + otherCovered.constant);
        const Number divisor =
            Make(mix, "ND_max_float", both, {kLeastCover}, std::max(both.constant, kLeastCover));
        return {{both, isTold},
                Make(mix, "ND_divide_float", covered, divisor,
                     covered.constant / std::max(divisor.constant, kLeastCover)),
                false};
    }

    Number Multiply(const hds::MaterialNode& mix, const Number& a, const Number& b) {
        if (a.Is(1.0) || b.Is(0.0)) {
            return b;
        }
        if (b.Is(1.0) || a.Is(0.0)) {
            return a;
        }
        return Make(mix, "ND_multiply_float", a, b, a.constant * b.constant);
    }
    Number OneMinus(const hds::MaterialNode& mix, const Number& a) {
        return Make(mix, "ND_subtract_float", {1.0}, a, 1.0 - a.constant);
    }

    /// \param constant of two constants. \param mix whose path begins that of the new node.
    Number Make(const hds::MaterialNode& mix, const char* identifier, const Number& a,
                const Number& b, double constant) {
        if (!a.from && !b.from) {
            return {constant};
        }
        hds::MaterialNode node;
        node.path = mix.path + "_cover" + std::to_string(_added.size());
        node.identifier = identifier;
        SetInput(&node, "in1", a);
        SetInput(&node, "in2", b);
        _added.push_back(node);
        return {0.0, Connection{node.path, "out"}};
    }

    /// The node of what a mix emits, which is its namesake.
    hds::MaterialNode* EmissionOf(const hds::MaterialNode& mix) const {
        return Find(StemOf(mix.path) + "_EDF");
    }

    hds::MaterialNetwork& _network;
    std::map<std::string, hds::MaterialNode*> _nodes;
    std::map<std::string, Cover> _covers; ///< by path
    std::vector<hds::MaterialNode> _added;
};

} // namespace

void HdStreamTakeTransparentOut(hds::MaterialNetwork* network) {
    TransparentSides(network).TakeOut();
}

PXR_NAMESPACE_CLOSE_SCOPE
