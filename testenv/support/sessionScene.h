// SPDX-License-Identifier: Apache-2.0
// A small scene for tests of sessions: meshes, an instancer, lights, a camera; cheap to render.
#pragma once

#include "hdStream/session/session.h"

namespace hds::test {

/// A bumpy grid of size x size quads, 2 units wide, in the plane y = 0.
std::shared_ptr<const GeometryDescription> MakeGrid(int size, float bump);

/// A quad of 2 x 2 units in the plane z = 0, facing +z.
std::shared_ptr<const GeometryDescription> MakeQuad();

/// A UsdPreviewSurface of that colour.
std::shared_ptr<const MaterialNetwork> MakeMaterial(float red, float green, float blue,
                                                    float emission = 0.0F);

/// A grid with the primvar "amount" of so many numbers a point, which are other ones of each bump.
std::shared_ptr<const GeometryDescription> MakeGridOfAmounts(int size, float bump,
                                                             std::uint32_t numComponents);

/// A UsdPreviewSurface that is as bright as the primvar "amount" of its prim says.
std::shared_ptr<const MaterialNetwork> MakeAmountReader();

/// An instancer of three instances at `path`, the first and the last of which place `prim` at
/// path/leaf, and a sun.
void AddInstancesAndSun(const std::string& path, GeometryPrim prim, SceneDescription* scene);

/// A transform that moves by (x, y, z).
glm::dmat4 Move(double x, double y, double z);

/// Fills the session: "/ground", "/wall", "/ball" (hidden or not is the test's affair), "/many"
/// with prototype "/many/leaf", "/sun", "/lamp", materials "/red" and "/glow", camera "/camera".
void FillSession(Session* session);

/// Settings for FillSession: 48 x 32 pixels, few samples, AOVs color, depth, primId, instanceId.
Settings MakeSettings();

/// Equal names, sizes and bits.
bool SameLayers(const std::vector<ImageLayer>& a, const std::vector<ImageLayer>& b);

} // namespace hds::test
