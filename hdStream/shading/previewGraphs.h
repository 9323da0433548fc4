// SPDX-License-Identifier: Apache-2.0
// UsdPreviewSurface, and colours as surfaces, put together of MaterialX's closures: what a mix of
// surfaces takes. Internal to the expansion of graphs (surfaceGraphs.h).
#pragma once

#include "hdStream/shading/graphRows.h"
#include "hdStream/shading/materialNetwork.h"

namespace hds {

/// `ND_convert_*_surfaceshader`.
/// Source: MaterialX 1.39, stdlib_ng.mtlx.
std::vector<NodeGraph> ConvertGraphs();

bool IsPreviewSurface(const MaterialNode& node);

/// A UsdPreviewSurface as closures, of what it says: where a lobe is at its default it has none.
/// Opacity is the share for which the surface is there.
/// Source: OpenUSD's previewSurface.glslfx (docs/shading.md); MaterialX 1.39,
/// bxdf/usd_preview_surface.mtlx, deviates: a metal is Schlick's term there too.
NodeGraph PreviewGraph(const MaterialNode& shader);

} // namespace hds
