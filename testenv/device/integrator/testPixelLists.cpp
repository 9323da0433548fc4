// SPDX-License-Identifier: Apache-2.0
// Lists of pixels stay on the device while renders are of the same pixels, and no longer.
#include "hdStream/integrator/pixelLists.h"
#include "testenv/support/deviceFixture.h"

#include <memory>

namespace hds::test {
namespace {

class PixelListsTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            lists = std::make_unique<PixelLists>(device);
            before = device->AllocatedBytes();
        }
    }

    void Begin(std::uint32_t width, const std::vector<FilmSums>& start = {}) {
        RenderOptions options;
        options.imageWidth = width;
        options.imageHeight = kHeight;
        options.samples = 4;
        options.interactive = true;
        schedule.Begin(options, start);
        lists->Begin(schedule);
    }

    std::uint64_t Bytes() const { return device->AllocatedBytes() - before; }

    static constexpr std::uint32_t kHeight = 48;
    SampleSchedule schedule;
    std::unique_ptr<PixelLists> lists;
    std::uint64_t before = 0; ///< bytes
};

TEST_F(PixelListsTest, ThoseOfAnotherSizeGoWhenARenderBegins) {
    constexpr std::uint64_t kBytes = std::uint64_t{64} * kHeight * sizeof(std::uint32_t);
    Begin(64);
    EXPECT_EQ(Download<std::uint32_t>(lists->All(schedule), 64 * kHeight), schedule.AllPixels());
    const std::uint64_t one = Bytes();
    EXPECT_GE(one, kBytes);
    lists->Get(schedule, PixelList::Preview);
    const std::uint64_t both = Bytes();
    EXPECT_GE(both, 2 * kBytes);
    Begin(64);
    EXPECT_EQ(Bytes(), both) << "the same pixels";
    Begin(16);
    EXPECT_EQ(Bytes(), 0U);
}

TEST_F(PixelListsTest, ThoseOfOneRenderGoWithIt) {
    Begin(64);
    lists->All(schedule);
    const std::uint64_t kept = Bytes();
    FilmSums part;
    part.width = 64;
    part.height = kHeight;
    part.endSample = 1;
    part.pixels.resize(64 * kHeight);
    for (shared::HdsFilmPixel& pixel : part.pixels) {
        pixel.numSamples = 1;
    }
    part.pixels[5].numSamples = 2; // it was stopped in its second pass
    Begin(64, {part});
    lists->Get(schedule, PixelList::Late);
    EXPECT_GT(Bytes(), kept);
    Begin(64);
    EXPECT_EQ(Bytes(), kept);
}

} // namespace
} // namespace hds::test
