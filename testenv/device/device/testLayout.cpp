// SPDX-License-Identifier: Apache-2.0
// Shared structs have the same size and offsets on the device as on the host.
#include "kernels/shared/frame.h"
#include "kernels/shared/geometry.h"
#include "kernels/shared/light.h"
#include "kernels/shared/material.h"
#include "kernels/shared/texture.h"
#include "testenv/support/deviceFixture.h"

#include <cstddef>

namespace hds::test {
namespace {

class Layout : public DeviceFixture {};

struct Field {
    const char* type;
    const char* member;
    std::size_t offset;
    std::size_t size;
};

#define HDS_TEST_FIELD(type, member)                                         \
    Field {                                                                  \
#type, #member, offsetof(shared::type, member), sizeof(shared::type) \
    }

TEST_F(Layout, MatchesTheHost) {
    const Field fields[] = {
        HDS_TEST_FIELD(HdsBvhNode, childBase),   HDS_TEST_FIELD(HdsBvhNode, qhi),
        HDS_TEST_FIELD(HdsInstance, object),     HDS_TEST_FIELD(HdsInstance, instanceRank),
        HDS_TEST_FIELD(HdsObject, numItems),     HDS_TEST_FIELD(HdsPrim, numPrimvars),
        HDS_TEST_FIELD(HdsPageHeader, vertices), HDS_TEST_FIELD(HdsTriangle, vertices),
        HDS_TEST_FIELD(HdsHit, pathIndex),       HDS_TEST_FIELD(HdsMaterial, slots),
        HDS_TEST_FIELD(HdsMaterial, flags),      HDS_TEST_FIELD(HdsLight, type),
        HDS_TEST_FIELD(HdsLight, strength),      HDS_TEST_FIELD(HdsLightTriangle, error),
        HDS_TEST_FIELD(HdsFrameParams, flags),   HDS_TEST_FIELD(HdsFrameParams, clipPlanes),
        HDS_TEST_FIELD(HdsWave, numSamples),     HDS_TEST_FIELD(HdsFilmPixel, numSamples),
        HDS_TEST_FIELD(HdsAovOffsets, centre),   HDS_TEST_FIELD(HdsTexture, mipBlock),
    };
    std::string text =
        "#include \"shared/frame.h\"\n#include \"shared/geometry.h\"\n#include \"shared/light.h\"\n"
        "#include \"shared/material.h\"\n#include \"shared/texture.h\"\nkernel void probe(global "
        "uint* out) {\n";
    for (std::size_t i = 0; i < std::size(fields); ++i) {
        const std::string type = fields[i].type;
        text += "  { private " + type + " x; out[" + std::to_string(2 * i) +
                "] = (uint)((private uchar*)&x." + fields[i].member +
                " - (private uchar*)&x); out[" + std::to_string(2 * i + 1) + "] = (uint)sizeof(" +
                type + "); }\n";
    }
    text += "}\n";
    Buffer out = Allocate(2 * std::size(fields) * sizeof(std::uint32_t));
    const auto program = Build(text);
    program->GetKernel("probe").Launch(1, out);
    const auto values = Download<std::uint32_t>(out, 2 * std::size(fields));
    for (std::size_t i = 0; i < std::size(fields); ++i) {
        EXPECT_EQ(values[2 * i], fields[i].offset) << fields[i].type << "." << fields[i].member;
        EXPECT_EQ(values[2 * i + 1], fields[i].size) << fields[i].type;
    }
}

} // namespace
} // namespace hds::test
