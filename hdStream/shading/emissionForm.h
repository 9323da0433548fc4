// SPDX-License-Identifier: Apache-2.0
// How light that a surface emits depends on the direction to the viewer: factors of emission, as
// MaterialX's EDFs and coats have them. Part of the material compiler. Explained in
// docs/materials.md.
#pragma once

#include "hdStream/shading/shaderExpression.h"

namespace hds {

/// The cosine between the surface's normal and the direction to the viewer, below 0 at the back.
ShaderValue ViewCosine();

/// From `color0` along the normal to `color90` across it (generalized_schlick_edf), on both sides.
ShaderValue SchlickEmission(const ShaderValue& color0, const ShaderValue& color90,
                            const ShaderValue& exponent);

/// 1 inside of a cone about the surface's normal, and falling smoothly, by the cosine, to 0 at the
/// outer one; 0 at once where that is no wider (conical_edf). Angles are whole, in degrees.
ShaderValue ConicalEmission(const ShaderValue& innerAngle, const ShaderValue& outerAngle);

/// What a coat lets through of light that is emitted below it (Standard Surface, OpenPBR).
/// \param tint of a whole coat
ShaderValue CoatedEmission(const ShaderValue& emission, const ShaderValue& coat,
                           const ShaderValue& coatIor, const ShaderValue& tint);

} // namespace hds
