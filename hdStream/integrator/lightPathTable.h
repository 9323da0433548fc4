// SPDX-License-Identifier: Apache-2.0
// The automaton of a render's light path expressions as kernels read it. Explained in docs/film.md.
#pragma once

#include "hdStream/film/lightPaths.h"

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// The words of kernels/shared/lightPaths.h.
/// \param groups of the scene's lights, by number from 1 on
/// \throws Error (Usage) when the table is larger than any device takes.
std::vector<std::uint32_t> MakeLightPathTable(const LightPathAutomaton& automaton,
                                              const std::vector<std::string>& groups);

/// Sums that a path keeps for so many expressions: a power of two, so that few kernels differ.
std::uint32_t NumLightPathSums(std::size_t numExpressions);

} // namespace hds
