// SPDX-License-Identifier: Apache-2.0
// Reflectances at normal incidence, which closures of MaterialX are authored by or stand for. Part
// of the material compiler. Explained in docs/materials.md.
#pragma once

#include "hdStream/shading/shaderExpression.h"

namespace hds {

/// Of a conductor of index n and extinction k, at most what has an index (Gulbrandsen 2014, eq. 1).
ShaderValue ConductorReflectance(const ShaderValue& n, const ShaderValue& k);

/// Whether a reflectance is a constant grey that dielectrics have.
bool IsDielectricGrey(const ShaderValue& front);

/// The index of a dielectric that reflects so; of a colour, its mean's.
ShaderValue IndexOfReflectance(const ShaderValue& front);

} // namespace hds
