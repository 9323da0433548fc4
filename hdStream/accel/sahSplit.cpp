// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/sahSplit.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hds {
namespace {

constexpr int kMaxBins = 32;
constexpr std::size_t kParallelCount = 65536; ///< ranges from here on are binned by several tasks
constexpr std::size_t kBlock = 8192;          ///< references a task of a long range handles

/// Maps centres to bins: bin = (centre - offset) * scale, per axis.
struct BinMapping {
    Float4 offset;
    Float4 scale;
    int numBins = 0;
    bool isUsable[3] = {};

    float offsets[3];
    float scales[3];

    BinMapping(const RangeBounds& bounds, std::size_t count) {
        numBins = count < 12 ? 8 : (count < 1024 ? 16 : kMaxBins);
        alignas(16) float extent[4];
        Store(extent, bounds.centreHi - bounds.centreLo);
        alignas(16) float from[4];
        Store(from, bounds.centreLo);
        alignas(16) float by[4] = {};
        for (int axis = 0; axis < 3; ++axis) {
            // 0.999: the largest centre stays below numBins after rounding.
            const float candidate = static_cast<float>(numBins) * 0.999F / extent[axis];
            isUsable[axis] = extent[axis] > 0.0F && std::isfinite(extent[axis]) &&
                             std::isfinite(candidate) && candidate > 0.0F;
            by[axis] = isUsable[axis] ? candidate : 0.0F;
            // 0 * (centre - 0) is 0, where the extent may be infinite.
            from[axis] = isUsable[axis] ? from[axis] : 0.0F;
            offsets[axis] = from[axis];
            scales[axis] = by[axis];
        }
        offset = LoadBox(from);
        scale = LoadBox(by);
    }

    void Bins(const BoxRef& ref, std::int32_t* bins) const {
        StoreInts(bins, (Centre(ref) - offset) * scale);
    }
    /// The same of one axis, by the same operations.
    std::int32_t Bin(const BoxRef& ref, int axis) const {
        const float centre = ref.lo[axis] * 0.5F + ref.hi[axis] * 0.5F;
        return static_cast<std::int32_t>((centre - offsets[axis]) * scales[axis]);
    }
};

struct Bin {
    Float4 lo, hi;
};

struct BinSet {
    Bin bins[3][kMaxBins];
    std::uint32_t counts[3][kMaxBins];

    explicit BinSet(int numBins) {
        const RangeBounds empty;
        for (int axis = 0; axis < 3; ++axis) {
            for (int i = 0; i < numBins; ++i) {
                bins[axis][i] = {empty.lo, empty.hi};
                counts[axis][i] = 0;
            }
        }
    }

    void Add(const BoxRef* refs, std::size_t count, const BinMapping& mapping) {
        for (std::size_t i = 0; i < count; ++i) {
            alignas(16) std::int32_t index[4];
            mapping.Bins(refs[i], index);
            const Float4 lo = LoadBox(refs[i].lo);
            const Float4 hi = LoadBox(refs[i].hi);
            for (int axis = 0; axis < 3; ++axis) {
                Bin& bin = bins[axis][index[axis]];
                bin.lo = Min(bin.lo, lo);
                bin.hi = Max(bin.hi, hi);
                ++counts[axis][index[axis]];
            }
        }
    }

    void Merge(const BinSet& other, int numBins) {
        for (int axis = 0; axis < 3; ++axis) {
            for (int i = 0; i < numBins; ++i) {
                bins[axis][i].lo = Min(bins[axis][i].lo, other.bins[axis][i].lo);
                bins[axis][i].hi = Max(bins[axis][i].hi, other.bins[axis][i].hi);
                counts[axis][i] += other.counts[axis][i];
            }
        }
    }
};

struct BestSplit {
    int axis = -1; ///< -1: none found
    int bin = 0;   ///< first bin of the right side
    float cost = std::numeric_limits<float>::infinity();
};

/// Scans the borders between the bins of one axis; earlier borders and axes win ties.
void ScanAxis(const BinSet& set, int axis, const BinMapping& mapping, std::size_t minSide,
              BestSplit* best) {
    float rightCost[kMaxBins + 1];
    rightCost[mapping.numBins] = std::numeric_limits<float>::infinity();
    Bin box = {RangeBounds{}.lo, RangeBounds{}.hi};
    std::size_t count = 0;
    for (int i = mapping.numBins - 1; i > 0; --i) {
        if (set.counts[axis][i] == 0) { // as without it
            rightCost[i] = rightCost[i + 1];
            continue;
        }
        const Bin& bin = set.bins[axis][i];
        box = {Min(box.lo, bin.lo), Max(box.hi, bin.hi)};
        count += set.counts[axis][i];
        rightCost[i] = count >= minSide ? HalfArea(box.lo, box.hi) * static_cast<float>(count)
                                        : std::numeric_limits<float>::infinity();
    }
    box = {RangeBounds{}.lo, RangeBounds{}.hi};
    count = 0;
    for (int i = 0; i + 1 < mapping.numBins; ++i) {
        if (set.counts[axis][i] == 0) { // as the border before it
            continue;
        }
        const Bin& bin = set.bins[axis][i];
        box = {Min(box.lo, bin.lo), Max(box.hi, bin.hi)};
        count += set.counts[axis][i];
        if (count < minSide) {
            continue;
        }
        const float cost = HalfArea(box.lo, box.hi) * static_cast<float>(count) + rightCost[i + 1];
        if (cost < best->cost) {
            *best = {axis, i + 1, cost};
        }
    }
}

BestSplit FindSplit(const BoxRef* refs, std::size_t count, const BinMapping& mapping,
                    std::size_t minSide) {
    BinSet set(mapping.numBins);
    if (count < kParallelCount) {
        set.Add(refs, count, mapping);
    } else {
        set = tbb::parallel_reduce(
            tbb::blocked_range<std::size_t>(0, count, kBlock), set,
            [&](const tbb::blocked_range<std::size_t>& range, BinSet part) {
                part.Add(refs + range.begin(), range.size(), mapping);
                return part;
            },
            [&](BinSet a, const BinSet& b) {
                a.Merge(b, mapping.numBins);
                return a;
            });
    }
    BestSplit best;
    for (int axis = 0; axis < 3; ++axis) {
        if (mapping.isUsable[axis]) {
            ScanAxis(set, axis, mapping, minSide, &best);
        }
    }
    return best;
}

/// Two pointers from both ends; grows both sides' bounds on the way.
template <typename IsLeft>
SplitResult PartitionSerial(BoxRef* refs, std::size_t count, const IsLeft& isLeft) {
    SplitResult result;
    std::size_t low = 0;
    std::size_t high = count;
    while (true) {
        while (low < high && isLeft(refs[low])) {
            result.left.Grow(refs[low++]);
        }
        while (low < high && !isLeft(refs[high - 1])) {
            result.right.Grow(refs[--high]);
        }
        if (low >= high) {
            break;
        }
        std::swap(refs[low], refs[high - 1]);
    }
    result.numLeft = low;
    return result;
}

/// Stable partition by blocks of fixed size through `scratch`, which has no room for the last one.
template <typename IsLeft>
SplitResult PartitionParallel(BoxRef* refs, std::size_t count, const IsLeft& isLeft,
                              BoxRef* scratch) {
    const std::size_t numBlocks = (count + kBlock - 1) / kBlock;
    struct Block {
        std::size_t numLeft = 0;
        RangeBounds left, right;
    };
    std::vector<Block> blocks(numBlocks);
    const BoxRef last = refs[count - 1];
    const auto blockEnd = [&](std::size_t b) { return std::min(count, (b + 1) * kBlock); };
    tbb::parallel_for(std::size_t{0}, numBlocks, [&](std::size_t b) {
        Block block;
        for (std::size_t i = b * kBlock; i < blockEnd(b); ++i) {
            const bool left = isLeft(refs[i]);
            block.numLeft += left ? 1 : 0;
            (left ? block.left : block.right).Grow(refs[i]);
            if (i < count - 1) {
                scratch[i] = refs[i];
            }
        }
        blocks[b] = block;
    });
    SplitResult result;
    std::vector<std::size_t> leftStart(numBlocks);
    for (std::size_t b = 0; b < numBlocks; ++b) {
        leftStart[b] = result.numLeft;
        result.numLeft += blocks[b].numLeft;
        result.left.Grow(blocks[b].left);
        result.right.Grow(blocks[b].right);
    }
    tbb::parallel_for(std::size_t{0}, numBlocks, [&](std::size_t b) {
        std::size_t left = leftStart[b];
        std::size_t right = result.numLeft + b * kBlock - leftStart[b];
        for (std::size_t i = b * kBlock; i < blockEnd(b); ++i) {
            const BoxRef& ref = i < count - 1 ? scratch[i] : last;
            refs[isLeft(ref) ? left++ : right++] = ref;
        }
    });
    return result;
}

constexpr std::size_t kFew = 4; ///< longer ranges are binned

/// The cheapest of all ways to share out three or four references.
SplitResult SplitFew(BoxRef* refs, std::size_t count) {
    // Those on one side; the others are complements of these.
    constexpr std::uint32_t kSides[] = {1, 2, 4, 8, 3, 5, 6};
    const std::size_t numSides = count == 3 ? 3 : 7;
    const RangeBounds empty;
    std::uint32_t best = kSides[0];
    float bestCost = std::numeric_limits<float>::infinity();
    for (std::size_t s = 0; s < numSides; ++s) {
        Bin sides[2] = {{empty.lo, empty.hi}, {empty.lo, empty.hi}};
        float counts[2] = {};
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t side = kSides[s] >> i & 1U;
            sides[side].lo = Min(sides[side].lo, LoadBox(refs[i].lo));
            sides[side].hi = Max(sides[side].hi, LoadBox(refs[i].hi));
            counts[side] += 1.0F;
        }
        const float cost = HalfArea(sides[0].lo, sides[0].hi) * counts[0] +
                           HalfArea(sides[1].lo, sides[1].hi) * counts[1];
        if (cost < bestCost) {
            bestCost = cost;
            best = kSides[s];
        }
    }
    BoxRef right[kFew];
    std::size_t numRight = 0;
    SplitResult result;
    for (std::size_t i = 0; i < count; ++i) {
        if ((best >> i & 1U) != 0) {
            result.left.Grow(refs[i]);
            refs[result.numLeft++] = refs[i];
        } else {
            result.right.Grow(refs[i]);
            right[numRight++] = refs[i];
        }
    }
    std::copy(right, right + numRight, refs + result.numLeft);
    return result;
}

/// Cuts at the median of the centres along their widest axis; ties in the centre go by item.
SplitResult SplitAtMedian(BoxRef* refs, std::size_t count, const RangeBounds& bounds) {
    alignas(16) float extent[4];
    Store(extent, bounds.centreHi - bounds.centreLo);
    const int axis = extent[0] >= extent[1] ? (extent[0] >= extent[2] ? 0 : 2)
                                            : (extent[1] >= extent[2] ? 1 : 2);
    const auto key = [axis](const BoxRef& ref) {
        return ref.lo[axis] * 0.5F + ref.hi[axis] * 0.5F;
    };
    SplitResult result;
    result.numLeft = count / 2;
    std::nth_element(refs, refs + result.numLeft, refs + count,
                     [&](const BoxRef& a, const BoxRef& b) {
                         const float ka = key(a);
                         const float kb = key(b);
                         return ka < kb || (ka == kb && a.item < b.item);
                     });
    result.left = ComputeRangeBounds(refs, result.numLeft);
    result.right = ComputeRangeBounds(refs + result.numLeft, count - result.numLeft);
    return result;
}

} // namespace

SplitResult SplitRange(BoxRef* refs, std::size_t count, const RangeBounds& bounds,
                       const SplitOptions& options) {
    if (count == 2) {
        SplitResult pair;
        pair.numLeft = 1;
        pair.left.Grow(refs[0]);
        pair.right.Grow(refs[1]);
        return pair;
    }
    if (options.balanced) {
        return SplitAtMedian(refs, count, bounds);
    }
    if (count <= kFew && options.minSide == 1) {
        return SplitFew(refs, count);
    }
    const BinMapping mapping(bounds, count);
    const BestSplit best = FindSplit(refs, count, mapping, options.minSide);
    if (best.axis < 0) {
        return SplitAtMedian(refs, count, bounds);
    }
    const auto isLeft = [&](const BoxRef& ref) { return mapping.Bin(ref, best.axis) < best.bin; };
    return count >= kParallelCount && options.scratch != nullptr
               ? PartitionParallel(refs, count, isLeft, options.scratch)
               : PartitionSerial(refs, count, isLeft);
}

} // namespace hds
