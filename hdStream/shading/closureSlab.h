// SPDX-License-Identifier: Apache-2.0
// Closures of MaterialX as layered surfaces side by side, of which each hit takes one by chance.
// What fits one layered surface becomes one. Part of the material compiler. Explained in
// docs/materials.md.
#pragma once

#include "hdStream/shading/layeredMaterial.h"
#include "hdStream/shading/shaderMath.h"

#include <memory>
#include <vector>

namespace hds {

/// What lies on something, from the lowest to the top: reflections and sheens.
using LayerStack = std::vector<std::shared_ptr<const LayeredMaterial>>;

/// One of the surfaces that a hit chooses from.
struct ClosureSlab {
    LayeredMaterial layered; ///< no opacity, no emission
    ShaderValue share;       ///< its probability; a scalar
    ShaderValue factor;      ///< of all that it reflects and transmits; a colour
    /// The part of the factor that makes up for being chosen less often than it is there.
    ShaderValue scale = MakeScalar(1.0F);
    bool isScaled = false;      ///< the factor may be above 1, and what is put on it has none of it
    bool hasBase = false;       ///< what lies below it is another slab, with this one in its covers
    LayerStack covers = {};     ///< what lies on it, and is chosen apart
    ShaderValue isCovered = {}; ///< 0 where these are not there; empty: they are everywhere
};

/// Their shares add up to 1, unless there are none.
using ClosureSlabs = std::vector<ClosureSlab>;

/// A surface that neither reflects nor transmits, alone.
ClosureSlab BlackSlab();

ClosureSlabs MixSlabs(ClosureSlabs background, ClosureSlabs foreground, const ShaderValue& mix);
ClosureSlabs AddSlabs(ClosureSlabs a, ClosureSlabs b);
ClosureSlabs MultiplySlabs(ClosureSlabs slabs, const ShaderValue& factor);
/// `top` on `base`, which gets what the top does not take.
ClosureSlabs LayerSlabs(const ClosureSlabs& top, const ClosureSlabs& base);

/// One surface whose inputs are those of a slab that is chosen at each hit.
LayeredMaterial ChooseSlab(ClosureSlabs slabs);

} // namespace hds
