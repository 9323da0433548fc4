// SPDX-License-Identifier: Apache-2.0
// What a slab of closures is made of, and its factor. Part of the material compiler. Explained in
// docs/materials.md.
#pragma once

#include "hdStream/shading/closureSlab.h"

#include <initializer_list>

namespace hds {

/// Whether an input is set, and not to 0.
bool Has(const LayeredMaterial& layered, std::uint32_t input);

/// Whether it has none of these.
bool HasNone(const LayeredMaterial& layered, std::initializer_list<std::uint32_t> inputs);

/// The value of an input, or its default.
ShaderValue ValueOf(const LayeredMaterial& layered, std::uint32_t input);
std::uint32_t NumComponentsOf(std::uint32_t input);

/// Whether an input is computed alike in both.
bool AreSame(const LayeredMaterial& a, const LayeredMaterial& b, std::uint32_t input);
/// Whether all inputs are.
bool AreSame(const LayeredMaterial& a, const LayeredMaterial& b);
bool AreSame(const LayerStack& a, const LayerStack& b);

/// Whether no light comes from it, as of closures of weight 0.
bool IsNothing(const LayeredMaterial& layered);
/// Diffuse reflection and transmission, and nothing else.
bool IsDiffuse(const LayeredMaterial& layered);
/// A reflection that lets through what it does not reflect.
bool IsReflection(const LayeredMaterial& layered);
bool IsSheen(const LayeredMaterial& layered);
/// Reflections and sheens, and nothing below them.
bool IsSeeThrough(const LayeredMaterial& layered);
/// Metal, and nothing beside it or above it.
bool IsMetal(const LayeredMaterial& layered);
/// Metal by Schlick's term, and nothing beside it.
bool IsSchlickMetal(const LayeredMaterial& layered);
/// Metal by Schlick's term that reflects all, so that it has nothing to let through.
bool IsWhiteMetal(const LayeredMaterial& layered);

/// Puts the factor of a slab into the colours of its lobes, since what comes to lie on top of it
/// does not have it. Of metal the colours of the front and of the edge have it, of subsurface
/// scattering its colour.
void FoldFactor(ClosureSlab* slab);

/// Whether FoldFactor leaves the slab as it is.
bool IsFoldable(const ClosureSlab& slab);

} // namespace hds
