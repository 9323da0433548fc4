// SPDX-License-Identifier: Apache-2.0
// What the tests of the render delegate share: the fixture, scenes of a few prims, comparisons.
#pragma once

#include "hostOracle.h"

#include <pxr/base/gf/rotation.h>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace hydraHost {

/// Fails where the plug-in does not load. These tests are built where it is built, and whoever
/// names another renderer in $HDSTREAM_TEST_RENDERER wants that one.
class HydraTest : public ::testing::Test {
protected:
    void SetUp() override;
};

/// Settings of quick renders whose pixels are boxes: few samples, no bounces, no disk cache.
HdRenderSettingsMap QuickSettings(int samples = 2);

/// Options of a host with QuickSettings and these AOVs.
HostOptions Quick(const std::vector<AovRequest>& aovs = {HdAovTokens->color}, int samples = 2);

/// A camera at z = 5, a white dome, and nothing to see.
SceneData EmptyScene();

/// EmptyScene, a tilted quad "/quad", a cube "/cube" and a pentagon-and-triangle mesh "/ngons",
/// apart from each other, each with a material of its own below "/materials".
SceneData ThreeMeshes();

/// Compares an AOV at all unambiguous pixels of the data window; at least half must be such.
/// \param expected called for hits and misses alike.
void ExpectInts(const Image& image, const Oracle& oracle,
                const std::function<int(const OracleHit&)>& expected);
void ExpectFloats(const Image& image, const Oracle& oracle, int component, double tolerance,
                  const std::function<double(const OracleHit&)>& expected);

/// Renders a host's present scene with a fresh delegate, same settings and AOVs of the options.
Image RenderFresh(Host& host, const HostOptions& options, const TfToken& aov = HdAovTokens->color);

/// When the shutter of EmptyScene's camera opens and closes, in frames.
void SetShutter(Host& host, double open, double close);

/// Warnings in the statistics that contain a text.
int NumWarnings(Host& host, const std::string& text);

} // namespace hydraHost
