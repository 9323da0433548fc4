// SPDX-License-Identifier: Apache-2.0
// The table of kernels' features: what makes two sets of kernels different, and that kernels test
// no macro that nobody defines, which would be 0 in silence; what each row needs.
#include "hdStream/device/embeddedKernels.h"
#include "hdStream/integrator/kernelFeatures.h"

#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <string>

namespace hds::test {
namespace {

TEST(KernelFeatures, EachRowMakesADifference) {
    const KernelFeatures none;
    EXPECT_TRUE(none == KernelFeatures());
    std::set<ProgramDefines> defines{none.Defines()};
    std::size_t numRows = 1;
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) \
    {                                                         \
        KernelFeatures f;                                     \
        f.member = on;                                        \
        EXPECT_FALSE(f == none) << #member;                   \
        defines.insert(f.Defines());                          \
        ++numRows;                                            \
    }
#define HDS_VARIANT(member, macro, needs, doc) \
    HDS_FEATURE(bool, member, macro, false, true, needs, doc)
#include "kernels/shared/features.def"
    EXPECT_EQ(defines.size(), numRows);
    KernelFeatures aovs;
    aovs.firstHits = true;
    EXPECT_FALSE(aovs == none);
    EXPECT_EQ(aovs.Defines(), none.Defines()) << "other programs stay as they are";
}

/// Words of `expression` in `text`, by its first group.
std::set<std::string> Find(const std::string& text, const char* expression) {
    const std::regex regex(expression);
    std::set<std::string> words;
    for (std::sregex_iterator i(text.begin(), text.end(), regex), end; i != end; ++i) {
        words.insert((*i)[1]);
    }
    return words;
}

TEST(KernelFeatures, KernelsTestNoUnknownMacro) {
    std::set<std::string> known = {"HDS_ITEMS_PER_WORK_ITEM"};
    for (const auto& [name, value] : KernelFeatures().Defines()) {
        known.insert(name);
    }
    std::set<std::string> used;
    for (std::size_t i = 0; i < NumEmbeddedKernels(); ++i) {
        const std::string text(reinterpret_cast<const char*>(EmbeddedKernels()[i].bytes),
                               EmbeddedKernels()[i].size);
        known.merge(Find(text, "# *define (HDS_[A-Z0-9_]+)"));
        for (const std::string& line : Find(text, "\n# *(?:el)?if ([^\n]+)")) {
            used.merge(Find(line, "(HDS_[A-Z0-9_]+)"));
        }
        used.merge(Find(text, "(HDS_FEATURE_[A-Z0-9_]+)"));
    }
    EXPECT_GT(used.size(), 20U);
    for (const std::string& name : used) {
        EXPECT_EQ(known.count(name), 1U) << name;
    }
}

using Names = std::set<std::string>;

Names NamesOfOn(const KernelFeatures& f) {
    Names names;
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) \
    if (f.member != (off)) {                                  \
        names.insert(#member);                                \
    }
#define HDS_VARIANT(member, macro, needs, doc) \
    HDS_FEATURE(bool, member, macro, false, true, needs, doc)
#include "kernels/shared/features.def"
    return names;
}

/// What each feature puts on beside itself, by name.
std::map<std::string, Names> AllNeeds() {
    std::map<std::string, Names> all;
    const auto add = [&](const char* name, const KernelFeatures& f) {
        all[name] = NamesOfOn(f.WithNeeds());
        EXPECT_EQ(all[name].erase(name), 1U) << name;
        EXPECT_TRUE(f.WithNeeds() == f.WithNeeds().WithNeeds()) << name << ": needs have needs";
    };
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) \
    {                                                         \
        KernelFeatures f;                                     \
        f.member = on;                                        \
        add(#member, f);                                      \
    }
#define HDS_VARIANT(member, macro, needs, doc) \
    HDS_FEATURE(bool, member, macro, false, true, needs, doc)
#include "kernels/shared/features.def"
    return all;
}

TEST(KernelFeatures, HaveWhatTheyNeed) {
    const std::map<std::string, Names> expected = {
        {"patterns", {"programs"}},                      // is code of programs
        {"closures", {"patterns", "programs"}},          // are chosen from by programs that compute
        {"numTexturePools", {"textures"}},               // hold their texels
        {"textureStreaming", {"textures"}},              // whose lines are missing
        {"texturedEmission", {"cutouts", "meshLights"}}, // of a mesh, asked for as candidates are
        {"lightMotion", {"lightControls", "motion"}},    // keys are among the controls
        {"lightFilters", {"lightControls"}},             // and so are filters
        {"catchers", {"rayVisibility"}},        // others are unseen in the scene of catchers alone
        {"splats", {"curves", "cutouts"}},      // are solids that let rays pass
        {"deep", {"mattes"}},                   // keeps depths where these keep surfaces
        {"media", {"lobes"}},                   // lie below layered surfaces
        {"dispersion", {"lobes"}},              // is of layered surfaces that refract
        {"glassShadows", {"cutouts", "lobes"}}, // are asked for as candidates are
        {"mediaStack", {"cutouts", "lobes", "media"}}, // whose boundaries are passed as cut-outs
        {"volumes", {"cutouts", "lobes", "media", "textures"}}, // bricks are lines; events of media
        {"volumeMotion", // moves what volumes hold by the time of a path
         {"cutouts", "lobes", "media", "motion", "textures", "volumes"}},
        {"volumeTerms", // what is read at a collision
         {"cutouts", "lobes", "media", "textures", "volumes"}},
        {"volumePatterns", // programs that are run at a collision
         {"cutouts", "lobes", "media", "patterns", "programs", "textures", "volumeTerms",
          "volumes"}},
        {"workingSpace", // converts the glow of volumes
         {"cutouts", "lobes", "media", "textures", "volumes"}},
        {"flat", {"simd8"}},                                // is walked as that form walks
        {"flatInstances", {"flat", "simd8"}},               // and beside it instances are
        {"flatCopies", {"flat", "simd8"}},                  // or trees in it
        {"requestsFirst", {"streaming"}},                   // asks for pages that are missing
        {"pageHash", {"instanceChunks", "streaming"}},      // looks those of many instances up
        {"transforms", {"patterns", "programs"}},           // are what programs compute
        {"autobump", {"patterns", "programs", "textures"}}, // looks aside by ray cones
    };
    for (const auto& [name, needs] : AllNeeds()) {
        const auto found = expected.find(name);
        EXPECT_EQ(needs, found == expected.end() ? Names() : found->second) << name;
    }
}

} // namespace
} // namespace hds::test
