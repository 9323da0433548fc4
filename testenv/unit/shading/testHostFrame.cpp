// SPDX-License-Identifier: Apache-2.0
// The frame as networks are told it, and what the nodes that ask for it give.
#include "hdStream/shading/hostFrame.h"

#include "hdStream/shading/materialCompiler.h"
#include "testenv/unit/shading/imageQueries.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <limits>
#include <optional>

namespace hds {
namespace {

/// Emits what a node "/m/n" gives, behind a node that passes it on.
MaterialNetwork Network(const char* id) {
    MaterialNetwork network;
    network.nodes.push_back({"/m/s", "ND_surface_unlit", {}, {}});
    network.nodes.push_back({"/m/dot", "ND_dot_float", {}, {}});
    network.nodes.push_back({"/m/n", id, {}, {}});
    network.nodes[0].connections["emission"] = {"/m/dot", "out"};
    network.nodes[1].connections["in"] = {"/m/n", "out"};
    network.terminals["surface"] = {"/m/s", "out"};
    return network;
}

float Emitted(const MaterialNetwork& network, Warnings& warnings) {
    const CompiledMaterial material = CompileMaterial(network, "/m", test::Images(), warnings);
    return material.constants.constants[HDS_INPUT_EMISSIVE_COLOR].x;
}

TEST(HostFrameTest, NodesGiveTheFrameAndTheSecondsOfIt) {
    Warnings warnings;
    MaterialNetwork frame = Network("ND_frame_float");
    MaterialNetwork time = Network("ND_time_float");
    for (const double at : {0.0, 1.0, 1001.25, -12.5}) {
        ASSERT_TRUE(TellFrame(at, &frame));
        ASSERT_TRUE(TellFrame(at, &time));
        EXPECT_FLOAT_EQ(Emitted(frame, warnings), static_cast<float>(at));
        time.nodes[2].parameters.erase("fps");
        EXPECT_FLOAT_EQ(Emitted(time, warnings), static_cast<float>(at / 24.0));
        time.nodes[2].parameters["fps"] = 29.97;
        EXPECT_FLOAT_EQ(Emitted(time, warnings), static_cast<float>(at / 29.97));
    }
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST(HostFrameTest, NetworksThatDoNotAskAreLeftAsTheyAre) {
    MaterialNetwork network = Network("ND_constant_float");
    EXPECT_FALSE(TellFrame(7.0, &network));
    for (const MaterialNode& node : network.nodes) {
        EXPECT_TRUE(node.parameters.empty());
    }
}

TEST(HostFrameTest, WhatIsNotKnownIsZeroWithOneWarning) {
    for (const std::optional<double> frame :
         {std::optional<double>(), std::optional<double>(-DBL_MAX),
          std::optional<double>(std::numeric_limits<double>::quiet_NaN())}) {
        for (const char* id : {"ND_frame_float", "ND_time_float"}) {
            Warnings warnings;
            MaterialNetwork network = Network(id);
            TellFrame(5.0, &network);
            EXPECT_TRUE(TellFrame(frame, &network)) << id;
            EXPECT_EQ(Emitted(network, warnings), 0.0F) << id;
            ASSERT_EQ(warnings.Lines().size(), 1U) << id;
            EXPECT_NE(warnings.Lines()[0].find("the frame, which is not known"), std::string::npos);
        }
    }
}

} // namespace
} // namespace hds
