// SPDX-License-Identifier: Apache-2.0
// Every setting out of range is a usage error that names its option.
#include "hdStream/session/settingsCheck.h"

#include "hdStream/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace hds {
namespace {

void ExpectNamed(const std::string& option, const std::function<void(Settings*)>& spoil) {
    Settings settings;
    ASSERT_NO_THROW(CheckSettings(settings));
    spoil(&settings);
    try {
        CheckSettings(settings);
        ADD_FAILURE() << option << " was accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::Usage);
        EXPECT_NE(std::string(error.what()).find(option), std::string::npos) << error.what();
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
}

TEST(SettingsCheck, NamesTheOption) {
    ExpectNamed("--imageWidth", [](Settings* s) { s->imageWidth = 0; });
    ExpectNamed("--imageHeight", [](Settings* s) { s->imageHeight = 100000; });
    ExpectNamed("--samples", [](Settings* s) { s->samples = 0; });
    ExpectNamed("--maxDepth", [](Settings* s) { s->maxDepth = 1U << 20U; });
    ExpectNamed("--time", [](Settings* s) { s->timeLimit = -1.0; });
    ExpectNamed("--noise", [](Settings* s) { s->noise = std::nan(""); });
    ExpectNamed("--waveSize", [](Settings* s) { s->waveSize = 1U << 31U; });
    ExpectNamed("--chunkSize", [](Settings* s) { s->chunkBytes = 1; });
    ExpectNamed("pixelAspectRatio", [](Settings* s) { s->pixelAspectRatio = 0.0; });
    ExpectNamed("--subdivision", [](Settings* s) { s->subdivision = "some"; });
    ExpectNamed("--complexity", [](Settings* s) { s->refineLevel = 9; });
    ExpectNamed("displayWindow", [](Settings* s) { s->displayWindow = {0.0, 0.0, 1e300, 1.0}; });
    ExpectNamed("displayWindow", [](Settings* s) { s->displayWindow = {5.0, 0.0, 5.0, 1.0}; });
    ExpectNamed("noSuchAov", [](Settings* s) { s->aovs = {"color", "noSuchAov"}; });
    ExpectNamed("traversal", [](Settings* s) { s->traversal = "sideways"; });
}

} // namespace
} // namespace hds
