// SPDX-License-Identifier: Apache-2.0
// Every program root builds with every single feature, with none and with all: a feature that
// breaks compilation fails here before any GPU sees it.
#include "testenv/support/deviceFixture.h"

namespace hds::test {
namespace {

class Roots : public DeviceFixture {};

const char* const kRoots[] = {"integrator/frame.cl", "integrator/intersect.cl",
                              "integrator/shade.cl", "integrator/shadow.cl",
                              "integrator/aov.cl",   "texture/cacheFill.cl"};
const char* const kFeatures[] = {
    "HDS_FEATURE_CUTOUT",     "HDS_FEATURE_GROUPS",        "HDS_TRAVERSAL_WIDE",
    "HDS_FEATURE_PROGRAMS",   "HDS_FEATURE_TEXTURES",      "HDS_FEATURE_TEXTURE_STREAMING",
    "HDS_TEXTURE_PLAIN",      "HDS_FEATURE_LIGHT_SHAPING", "HDS_FEATURE_LIGHT_CONTROLS",
    "HDS_FEATURE_CURVES",     "HDS_FEATURE_MESH_LIGHTS",   "HDS_FEATURE_LIGHT_TREE",
    "HDS_FEATURE_LIGHT_GLOW", "HDS_FEATURE_MOTION",        "HDS_FEATURE_LIGHT_PORTALS"};

ProgramDefines MakeDefines(unsigned bits, unsigned numPools) {
    ProgramDefines defines{{"HDS_NUM_POOLS", std::to_string(numPools)}};
    for (unsigned i = 0; i < std::size(kFeatures); ++i) {
        defines[kFeatures[i]] = (bits >> i & 1U) != 0 ? "1" : "0";
    }
    return defines;
}

TEST_F(Roots, BuildWithEachFeature) {
    for (const char* root : kRoots) {
        for (const unsigned bits :
             {0U, 1U, 2U, 4U, 8U, 24U, 48U, 63U, 88U, 128U, 256U, 257U, 512U, 1024U, 2048U,
              1024U + 4096U + 1U, 8192U, 8192U + 512U, 16384U}) {
            EXPECT_NO_THROW(Program(device, root, MakeDefines(bits, 1)))
                << root << " features " << bits;
        }
    }
}

/// Of layered surfaces: none, the base alone, each lobe beside it, all.
TEST_F(Roots, BuildWithEachLobe) {
    for (const char* root : {"integrator/shade.cl", "integrator/shadow.cl", "integrator/aov.cl"}) {
        for (const unsigned lobes : {1U, 3U, 5U, 9U, 17U, 33U, 63U}) {
            ProgramDefines defines = MakeDefines(lobes == 63U ? 9U : 1U, 1);
            defines["HDS_LOBES"] = std::to_string(lobes) + "u";
            EXPECT_NO_THROW(Program(device, root, defines)) << root << " lobes " << lobes;
        }
    }
}

TEST_F(Roots, BuildWithAllPools) {
    EXPECT_NO_THROW(Program(device, "integrator/shade.cl",
                            MakeDefines(63 + 512 + 1024 + 2048 + 4096 + 8192, 8)));
}

} // namespace
} // namespace hds::test
