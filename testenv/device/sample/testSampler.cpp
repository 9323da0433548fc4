// SPDX-License-Identifier: Apache-2.0
// kernels/sample/sampler.clh: range, the (0,2)-net property of every power-of-two prefix, and
// independence of pixels, dimensions, seeds and forks.
#include "testenv/support/deviceFixture.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace hds::test {
namespace {

const char* const kSource = R"(
#include "sample/sampler.clh"
kernel void points(uint x, uint y, uint seed, uint dimension, uint firstSample, uint forkId,
                   global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    HdsSampler sampler = sampler_init(x, y, firstSample + i, seed);
    if (forkId != 0u) sampler = sampler_fork(sampler, forkId);
    vstore2(sampler_get2(sampler, dimension), i, out);
}
kernel void firsts(uint dimension, global float* out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) out[i] = sampler_get1(sampler_init(3u, 4u, i, 5u), dimension);
}
kernel void table(global uint* out) {
    out[0] = HDS_DIM_FILTER;
    out[1] = HDS_DIM_LENS;
    uint n = 2u;
    for (uint depth = 0u; depth < 20u; ++depth) {
        for (uint k = 0u; k < HDS_DIM_BOUNCE_COUNT; ++k) out[n++] = HDS_DIM_BOUNCE(depth, k);
    }
}
)";

struct Key {
    std::uint32_t x = 0;
    std::uint32_t y = 0;
    std::uint32_t seed = 0;
    std::uint32_t dimension = 0;
    std::uint32_t fork = 0;
};

class SamplerTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device) {
            _program = Build(kSource);
        }
    }
    std::vector<float> Points(const Key& key, std::uint32_t first, std::uint32_t count) {
        const Buffer out = Allocate(count * 2 * sizeof(float));
        _program->GetKernel("points").Launch(count, key.x, key.y, key.seed, key.dimension, first,
                                             key.fork, out, count);
        return Download<float>(out, std::size_t(count) * 2);
    }
    std::unique_ptr<Program> _program;
};

/// True when every elementary interval of area 1 / count holds exactly one point.
bool IsNet(const std::vector<float>& points, int log2Count) {
    const std::size_t count = std::size_t(1) << log2Count;
    for (int bitsX = 0; bitsX <= log2Count; ++bitsX) {
        std::vector<int> cells(count, 0);
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t x = std::size_t(std::ldexp(points[2 * i], bitsX));
            const std::size_t y = std::size_t(std::ldexp(points[2 * i + 1], log2Count - bitsX));
            ++cells[(y << bitsX) + x];
        }
        if (std::any_of(cells.begin(), cells.end(), [](int n) { return n != 1; })) {
            return false;
        }
    }
    return true;
}

TEST_F(SamplerTest, EveryPowerOfTwoPrefixIsANet) {
    for (std::uint32_t dimension = 0; dimension < 12; ++dimension) {
        const std::vector<float> points = Points({17, 211, 3, dimension, 0}, 0, 1024);
        for (int k = 0; k <= 10; ++k) {
            EXPECT_TRUE(IsNet(points, k)) << "dimension " << dimension << ", 2^" << k;
        }
    }
}

TEST_F(SamplerTest, AlignedBlocksOfSamplesAreNets) {
    const std::vector<float> points = Points({5, 6, 7, 8, 0}, 3 * 256, 256);
    EXPECT_TRUE(IsNet(points, 8));
}

TEST_F(SamplerTest, ForkedSamplersKeepTheNet) {
    EXPECT_TRUE(IsNet(Points({17, 211, 3, 2, 99}, 0, 256), 8));
}

TEST_F(SamplerTest, ValuesStayBelowOneAndFillTheUnitInterval) {
    constexpr std::uint32_t kCount = 1 << 20;
    const std::vector<float> points = Points({1, 2, 3, 4, 0}, 0, kCount);
    const auto range = std::minmax_element(points.begin(), points.end());
    EXPECT_GE(*range.first, 0.0F);
    EXPECT_LE(*range.second, 1.0F - 0x1p-24F);
    EXPECT_LT(*range.first, 2.0F / kCount); // a stratified set has a point in the first stratum
    EXPECT_GT(*range.second, 1.0F - 2.0F / kCount);
}

TEST_F(SamplerTest, FirstHalfEqualsSingleValue) {
    constexpr std::uint32_t kCount = 256;
    const Buffer out = Allocate(kCount * sizeof(float));
    _program->GetKernel("firsts").Launch(kCount, std::uint32_t(9), out, kCount);
    const std::vector<float> singles = Download<float>(out, kCount);
    const std::vector<float> pairs = Points({3, 4, 5, 9, 0}, 0, kCount);
    for (std::size_t i = 0; i < kCount; ++i) {
        ASSERT_EQ(singles[i], pairs[2 * i]);
    }
}

/// Correlation of two equally long sequences.
double Correlation(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += (double(a[i]) - 0.5) * (double(b[i]) - 0.5);
    }
    return 12.0 * sum / double(a.size());
}

TEST_F(SamplerTest, KeysAreIndependent) {
    constexpr std::uint32_t kCount = 4096;
    const Key base{100, 200, 0, 3, 0};
    const Key others[] = {{101, 200, 0, 3, 0}, {100, 201, 0, 3, 0}, {200, 100, 0, 3, 0},
                          {100, 200, 1, 3, 0}, {100, 200, 0, 4, 0}, {100, 200, 0, 3, 1},
                          {100, 200, 0, 3, 2}};
    const std::vector<float> reference = Points(base, 0, kCount);
    for (const Key& key : others) {
        const std::vector<float> points = Points(key, 0, kCount);
        // 8192 independent values correlate by 1 / sqrt(8192) = 0.011; 5 sigma.
        EXPECT_LT(std::abs(Correlation(reference, points)), 0.055)
            << key.x << ' ' << key.y << ' ' << key.seed << ' ' << key.dimension << ' ' << key.fork;
    }
}

TEST_F(SamplerTest, FirstSamplesOfManyPixelsAreUniform) {
    // One sample a pixel over a 64 x 64 tile: chi-square of a 16 x 16 histogram, 255 degrees of
    // freedom, 99.9 % below 330.5.
    std::vector<double> bins(256, 0.0);
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            const std::vector<float> p = Points({x, y, 0, 2, 0}, 0, 1);
            ++bins[std::size_t(p[0] * 16) * 16 + std::size_t(p[1] * 16)];
        }
    }
    double statistic = 0.0;
    for (const double n : bins) {
        statistic += (n - 16.0) * (n - 16.0) / 16.0;
    }
    EXPECT_LT(statistic, 330.5);
}

TEST_F(SamplerTest, DimensionTableHasNoCollisions) {
    constexpr std::size_t kCount = 2 + 20 * 5;
    const Buffer out = Allocate(kCount * sizeof(std::uint32_t));
    _program->GetKernel("table").Launch(1, out);
    const std::vector<std::uint32_t> dimensions = Download<std::uint32_t>(out, kCount);
    EXPECT_EQ(std::set<std::uint32_t>(dimensions.begin(), dimensions.end()).size(), kCount);
}

} // namespace
} // namespace hds::test
