// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/programDepth.h"

#include <algorithm>

namespace hds {

namespace {

using Kind = ShaderExpression::Kind;

bool AreConstant(const ShaderExpression& expression, std::size_t first) {
    return std::all_of(expression.operands.begin() + static_cast<std::ptrdiff_t>(first),
                       expression.operands.end(), IsConstant);
}

} // namespace

std::uint32_t ProgramDepth::Of(const ShaderExpression& expression) {
    const auto known = _known.find(&expression);
    if (known != _known.end()) {
        return known->second;
    }
    const std::uint32_t depth = Find(expression);
    _known[&expression] = depth;
    return depth;
}

std::uint32_t ProgramDepth::Find(const ShaderExpression& expression) {
    switch (expression.kind) {
    case Kind::Math:
    case Kind::ToSpace:
        return OfOperands(expression, 0, 0);
    case Kind::Texture:
        return AreConstant(expression, 1) ? OfCoordinates(expression.operands[0])
                                          : std::max(OfOperands(expression, 1, 0),
                                                     3 + OfCoordinates(expression.operands[0]));
    case Kind::Transform2d:
    case Kind::Affine:
        return FindMapped(expression);
    case Kind::Tangent:
        return OfCoordinates(expression.operands[0]);
    case Kind::Shifted:
        return std::max(OfCoordinates(expression.operands[1]),
                        Of(*expression.operands[0].expression));
    default:
        return 1;
    }
}

std::uint32_t ProgramDepth::OfOperands(const ShaderExpression& expression, std::size_t first,
                                       std::uint32_t below) {
    std::uint32_t depth = 1;
    for (std::size_t i = first; i < expression.operands.size(); ++i, ++below) {
        depth = std::max(depth, below + Of(*expression.operands[i].expression));
    }
    return depth;
}

std::uint32_t ProgramDepth::OfCoordinates(const ShaderValue& value) {
    const ShaderExpression& expression = *value.expression;
    const bool isMapped = value.channel == HDS_CHANNEL_ALL &&
                          (expression.kind == Kind::Transform2d || expression.kind == Kind::Affine);
    return isMapped ? FindMapped(expression) : std::max(2U, Of(expression));
}

std::uint32_t ProgramDepth::FindMapped(const ShaderExpression& expression) {
    const auto known = _knownCoordinates.find(&expression);
    if (known != _knownCoordinates.end()) {
        return known->second;
    }
    std::uint32_t depth = OfCoordinates(expression.operands[0]);
    if (!AreConstant(expression, 1)) {
        depth = std::max(depth, OfOperands(expression, 1, 2));
    }
    _knownCoordinates[&expression] = depth;
    return depth;
}

} // namespace hds
