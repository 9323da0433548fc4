// SPDX-License-Identifier: Apache-2.0
// Expressions of a material -> expressions for one prim: primvars that it lacks give way to their
// fallbacks. Part of the material compiler.
#pragma once

#include "hdStream/shading/shaderExpression.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>

namespace hds {

/// Slot of a primvar that has at least so many components, or HDS_NONE.
using SlotCallback =
    std::function<std::uint32_t(const std::string& primvar, std::uint32_t numComponents)>;

/// Resolves values of one material for one prim. What fed several values still does. Externally
/// synchronised; the callback and the values must outlive it.
class ValueResolver {
public:
    explicit ValueResolver(const SlotCallback& findSlot) : _findSlot(findSlot) {}

    /// The value with every primvar that the prim lacks replaced by its fallback, folded where that
    /// gives constants. \param numComponents that are needed of a primvar.
    ShaderValue Resolve(const ShaderValue& value, std::uint32_t numComponents);

private:
    ShaderValue ResolveOperands(const ShaderExpression& expression, const ShaderValue& whole);

    const SlotCallback& _findSlot;
    std::map<const ShaderExpression*, ShaderValue> _resolved; ///< all but constants and primvars
};

} // namespace hds
