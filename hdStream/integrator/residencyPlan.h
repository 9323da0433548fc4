// SPDX-License-Identifier: Apache-2.0
// Where geometry is to live and how large pools are. It knows no device: sizes come in, a plan goes
// out. When geometry that streams becomes resident: makeResident.h. Explained in docs/streaming.md.
#pragma once

#include "hdStream/integrator/renderOptions.h"

#include <cstdint>

namespace hds {

/// Geometry of so many bytes is prepared and loaded in a moment (a fifth of a second on two cores):
/// "auto" does so before the first ray. Explained in docs/streaming.md.
constexpr std::uint64_t kLittleBytes = 16U << 20U;

/// The kinds of pools of geometry.
enum class PoolKind { Resident, Streaming, Mapped };

/// What is decided about the geometry of a scene before any of it is loaded.
struct ResidencyPlan {
    PoolKind pool = PoolKind::Resident;
    std::uint64_t budgetBytes = 0; ///< of a streaming pool
    /// The pool asks for all pages, or its size for the sizes of all: they are better prepared
    /// before.
    bool needsAllPages = false;
};

/// \param totalBytes of all pages, as far as that is known. \param deviceBytes of memory.
ResidencyPlan PlanResidency(const ResidencyOptions& options, std::uint64_t totalBytes,
                            std::uint64_t deviceBytes);

/// Bytes of a pool for textures that stream. \param totalBytes of all lines; looked at for a share
/// of them only.
std::uint64_t TextureBudget(const ResidencyOptions& options, std::uint64_t totalBytes,
                            std::uint64_t deviceBytes);

/// Bytes of a pool for volumes alone; 0: they share that for textures. \param totalBytes of all
/// bricks.
std::uint64_t VolumeBudget(const ResidencyOptions& options, std::uint64_t totalBytes);

} // namespace hds
