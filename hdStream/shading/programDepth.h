// SPDX-License-Identifier: Apache-2.0
// How many places of the stack an expression takes while it is evaluated. Part of the writer of
// programs. Explained in docs/shading.md.
#pragma once

#include "hdStream/shading/shaderExpression.h"

#include <cstdint>
#include <map>

namespace hds {

/// Places that a program takes for an expression, with its value, where operands are evaluated in
/// order. What a register holds counts as evaluated anew. Externally synchronised; expressions must
/// outlive it.
class ProgramDepth {
public:
    std::uint32_t Of(const ShaderExpression& expression);

private:
    std::uint32_t Find(const ShaderExpression& expression);
    std::uint32_t OfCoordinates(const ShaderValue& value);
    /// Of coordinates of a kind whose derivatives are known.
    std::uint32_t FindMapped(const ShaderExpression& expression);
    /// Of operands from one on, evaluated one after another above `below` others.
    std::uint32_t OfOperands(const ShaderExpression& expression, std::size_t first,
                             std::uint32_t below);

    std::map<const ShaderExpression*, std::uint32_t> _known;
    std::map<const ShaderExpression*, std::uint32_t> _knownCoordinates;
};

} // namespace hds
