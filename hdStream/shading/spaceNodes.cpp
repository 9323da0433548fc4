// SPDX-License-Identifier: Apache-2.0
// MaterialX's nodes that carry points, vectors and normals between the spaces of a prim, and the
// direction of view, which may be in each of them. Model space is object space: points are what
// they are after all deformations. Definitions: stdlib 1.39. The table of what there is:
// docs/materials.md.
#include "hdStream/shading/patternNode.h"

#include <array>
#include <optional>
#include <string>

namespace hds {

namespace {

using Kind = ShaderExpression::Kind;

/// HDS_SPACE_*; nothing: it is none of them.
std::optional<std::uint32_t> SpaceOf(const std::string& name) {
    if (name == "world") {
        return HDS_SPACE_WORLD;
    }
    return name == "object" || name == "model" ? std::optional<std::uint32_t>(HDS_SPACE_OBJECT)
                                               : std::nullopt;
}

class SpaceNode : public PatternNode {
public:
    using PatternNode::PatternNode;

    /// \tparam kCarries HDS_CARRIES_*
    template <std::uint32_t kCarries>
    ShaderValue Transform() {
        constexpr bool isNormal = kCarries == HDS_CARRIES_NORMAL;
        const ShaderValue in = Vector("in", {0.0F, 0.0F, isNormal ? 1.0F : 0.0F, 0.0F}, 3);
        const std::optional<std::uint32_t> from = SpaceInput("fromspace");
        const std::optional<std::uint32_t> to = SpaceInput("tospace");
        const ShaderValue out =
            from && to && *from != *to ? MakeGeometry(Kind::ToSpace, *to | kCarries, {in}) : in;
        return isNormal ? MakeMath(HDS_MATH_NORMALIZE, {out}, 3) : out;
    }
    /// In world space where nothing is said.
    ShaderValue ViewDirection() {
        const std::optional<std::uint32_t> space = SpaceInput("space");
        const ShaderValue view = MakeGeometry(Kind::View, 0);
        return space.value_or(HDS_SPACE_WORLD) == HDS_SPACE_WORLD
                   ? view
                   : MakeMath(HDS_MATH_NORMALIZE,
                              {MakeGeometry(Kind::ToSpace, *space | HDS_CARRIES_VECTOR, {view})},
                              3);
    }

private:
    /// Nothing: none is authored, or one that there is not, which has a warning.
    std::optional<std::uint32_t> SpaceInput(const char* input) {
        const std::string name = _network.Text(_node, input);
        const std::optional<std::uint32_t> space = SpaceOf(name);
        if (!name.empty() && !space) {
            _network.Warn(std::string(input) + " of " + _node.path + " is " + name +
                          ", which is no space that is known; it counts as not authored");
        }
        return space;
    }
};

constexpr PatternType kTypes[] = {
    {"transformpoint", kPattern<&SpaceNode::Transform<HDS_CARRIES_POINT>>},
    {"transformvector", kPattern<&SpaceNode::Transform<HDS_CARRIES_VECTOR>>},
    {"transformnormal", kPattern<&SpaceNode::Transform<HDS_CARRIES_NORMAL>>},
    {"viewdirection", kPattern<&SpaceNode::ViewDirection>},
};

} // namespace

PatternTable SpaceNodes() {
    return PatternTable(kTypes);
}

} // namespace hds
