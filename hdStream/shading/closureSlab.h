// SPDX-License-Identifier: Apache-2.0
// Closures of MaterialX as layered surfaces side by side, of which each hit takes one by chance.
// What fits one layered surface becomes one. Part of the material compiler. Explained in
// docs/materials.md.
#pragma once

#include "hdStream/shading/layeredMaterial.h"

#include <functional>
#include <string>
#include <vector>

namespace hds {

/// One of the surfaces that a hit chooses from.
struct ClosureSlab {
    LayeredMaterial layered; ///< no opacity, no emission
    ShaderValue share;       ///< its probability; a scalar
    ShaderValue factor;      ///< of all that it reflects and transmits; a colour
};

/// Their shares add up to 1, unless there are none.
using ClosureSlabs = std::vector<ClosureSlab>;

using ClosureWarning = std::function<void(const std::string&)>;

/// A surface that neither reflects nor transmits, alone.
ClosureSlab BlackSlab();

/// Whether a reflectance at normal incidence is a constant grey that dielectrics have.
bool IsDark(const ShaderValue& front);
/// The index whose reflectance at normal incidence that is; of a colour, its mean's.
ShaderValue IndexOf(const ShaderValue& front);

ClosureSlabs MixSlabs(ClosureSlabs background, ClosureSlabs foreground, const ShaderValue& mix);
ClosureSlabs AddSlabs(ClosureSlabs a, ClosureSlabs b);
ClosureSlabs MultiplySlabs(ClosureSlabs slabs, const ShaderValue& factor);
/// `top` on `base`, which gets what the top does not take.
ClosureSlabs LayerSlabs(const ClosureSlabs& top, const ClosureSlabs& base,
                        const ClosureWarning& warn);

/// One surface whose inputs are those of a slab that is chosen at each hit.
LayeredMaterial ChooseSlab(ClosureSlabs slabs);

} // namespace hds
