// SPDX-License-Identifier: Apache-2.0
// Functions of shader values (kernels/shared/programMath.h) as expressions: constants are folded,
// what changes nothing is left out, and coordinates that are scaled and moved by constants stay
// coordinates, so that images are filtered by them. Explained in docs/materials.md.
#pragma once

#include "hdStream/shading/shaderExpression.h"
#include "kernels/shared/programMath.h"

#include <vector>

namespace hds {

/// The value with a scalar in all four components; others stay as they are.
ShaderValue Spread(const ShaderValue& value);

/// The function `code` (HDS_MATH_*) of the operands; scalars among them are spread.
/// \param numComponents of the result; 1: all four components hold it
ShaderValue MakeMath(std::uint32_t code, std::vector<ShaderValue> operands,
                     std::uint32_t numComponents);

/// A constant in all components.
ShaderValue MakeScalar(float value);

/// Whether all components that count are this constant.
bool IsAll(const ShaderValue& value, float constant);

/// Whether both are computed alike, though by nodes of their own; empty values are the same.
bool AreSame(const ShaderValue& a, const ShaderValue& b);

// Arithmetic by components.
ShaderValue Add(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents);
ShaderValue Subtract(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents);
ShaderValue Multiply(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents);
ShaderValue Divide(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents);
ShaderValue Power(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents);
ShaderValue OneMinus(const ShaderValue& value, std::uint32_t numComponents);
/// \param share of the foreground
ShaderValue Mix(const ShaderValue& background, const ShaderValue& foreground,
                const ShaderValue& share, std::uint32_t numComponents);

} // namespace hds
