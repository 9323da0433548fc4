// SPDX-License-Identifier: Apache-2.0
// Every program of the wavefront builds with no feature, with all, and with each alone, whatever
// kernels/shared/features.def lists: a feature that breaks compilation fails here before any GPU
// sees it.
#include "hdStream/integrator/stageKernels.h"
#include "testenv/support/deviceFixture.h"

namespace hds::test {
namespace {

/// Features, and how a failure names them.
struct NamedFeatures {
    std::string name;
    KernelFeatures f;
};

KernelFeatures AllFeatures() {
    KernelFeatures f;
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) f.member = on;
#define HDS_PROGRAM_FEATURE(member, doc) f.member = true;
#include "kernels/shared/features.def"
    return f;
}

/// No feature, all, each alone, and all in each of the other forms.
std::vector<NamedFeatures> MakeSets() {
    std::vector<NamedFeatures> sets = {{"none", {}}, {"all", AllFeatures()}};
    sets.front().f.firstHits = true; // the program is built, with no feature
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) \
    {                                                         \
        KernelFeatures f = sets.front().f;                    \
        f.member = on;                                        \
        sets.push_back({#member, f.WithNeeds()});             \
    }
#define HDS_VARIANT(member, macro, needs, doc)                               \
    for (const std::size_t base : {0, 1}) {                                  \
        KernelFeatures f = sets[base].f;                                     \
        f.member = true;                                                     \
        sets.push_back({sets[base].name + " with " #member, f.WithNeeds()}); \
    }
#include "kernels/shared/features.def"
    return sets;
}

class Roots : public DeviceFixture {
protected:
    void ExpectAllBuild(const NamedFeatures& set) {
        const KernelFeatures& f = set.f;
        const ProgramDefines defines = f.Defines();
        const std::string& label = set.name;
#define HDS_PROGRAM(name, root, condition)                                                 \
    if (condition) {                                                                       \
        EXPECT_NO_THROW(Program(device, root, defines)) << root << " features: " << label; \
    }
#include "kernels/shared/features.def"
    }

    /// The programs that have code for 8 paths at once, with it.
    void ExpectWideBuild(const NamedFeatures& set) {
        ProgramDefines defines = set.f.Defines();
        defines["HDS_ITEMS_PER_WORK_ITEM"] = "32";
        for (const char* root : {"integrator/frame.cl", "integrator/shade.cl"}) {
            EXPECT_NO_THROW(Program(device, root, defines)) << root << " features: " << set.name;
        }
    }

    /// Number of fields of a path's state that kernels see.
    std::uint32_t NumPathFields(const KernelFeatures& f) {
        const auto program = Build("#include \"integrator/pathState.clh\"\n"
                                   "kernel void count(global uint* n) { *n = pathField_count; }\n",
                                   f.Defines());
        const Buffer count = Allocate(sizeof(std::uint32_t));
        program->GetKernel("count").Launch(1, count);
        return Download<std::uint32_t>(count, 1).front();
    }
};

TEST_F(Roots, BuildWithEachFeature) {
    for (const NamedFeatures& set : MakeSets()) {
        ExpectAllBuild(set);
    }
}

TEST_F(Roots, HostCountsTheFieldsOfPaths) {
    for (const NamedFeatures& set : MakeSets()) {
        EXPECT_EQ(StageKernels::PathStateBytes(set.f), 16U * NumPathFields(set.f)) << set.name;
    }
}

/// What HDS_SHADE_WIDE (kernels/integrator/shadeScatter.clh) excludes is off.
TEST_F(Roots, BuildForEightPaths) {
    if (!device->Properties().isCpu) {
        GTEST_SKIP() << "the form of 8 paths is for CPUs";
    }
    NamedFeatures wide{"all that is wide", AllFeatures()};
    wide.f.lobes &= ~HDS_LOBES_ALONE;
    wide.f.lightControls = wide.f.lightMotion = wide.f.lightFilters = false;
    wide.f.rayVisibility = wide.f.catchers = wide.f.pathLimits = wide.f.terminator = false;
    wide.f.lightPaths = 0;
    NamedFeatures preview{"all that is wide but layered surfaces", wide.f};
    preview.f.lobes = 0;
    preview.f.media = false;
    preview.f.mediaStack = false;
    preview.f.glassShadows = false;
    preview.f.volumes = false;
    NamedFeatures base{"none but the base of layered surfaces", {}};
    base.f.lobes = HDS_LOBE_BASE;
    base.f = base.f.WithNeeds();
    for (const NamedFeatures& set :
         {NamedFeatures{"none", {}}, NamedFeatures{"all", AllFeatures()}, wide, preview, base}) {
        ExpectWideBuild(set);
    }
}

/// Of layered surfaces: the base alone, each lobe beside it.
TEST_F(Roots, BuildWithEachLobe) {
    for (std::uint32_t lobe = HDS_LOBE_BASE; (lobe & HDS_LOBES_ALL) != 0; lobe <<= 1U) {
        NamedFeatures set{"lobe " + std::to_string(lobe), {}};
        set.f.programs = true;
        set.f.lobes = HDS_LOBE_BASE | lobe;
        set.f.firstHits = true;
        ExpectAllBuild(set);
    }
}

} // namespace
} // namespace hds::test
