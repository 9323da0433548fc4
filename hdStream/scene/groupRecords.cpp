// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/groupRecords.h"

#include "kernels/shared/motionKeys.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <iterator>
#include <map>

namespace hds {

namespace {

/// In a list of instances: places nothing, but counts for the ranks of those after it, for prims
/// of which the front end has made several with instances of one list (primvars per instance).
constexpr std::int32_t kGap = -1;
/// Records that move are written so many at a time, for their keys are kept that long.
constexpr std::uint32_t kMovingBlock = 16384;

glm::dmat4 MatrixAt(const SharedSpan<double>& transforms, std::int32_t index) {
    return glm::make_mat4(transforms.data() + 16 * static_cast<std::size_t>(index));
}

bool IsUsable(const glm::dmat4& transform, const Bounds& bounds) {
    return IsUsableTransform(transform) && IsWithinReach(transform, bounds);
}

/// Where a record is.
struct Boxes {
    Bounds open;
    Bounds close;
    bool isUsable = false;
    bool moves = false;
};

Boxes BoxesOf(const MovingTransform& groupFromObject, const LeafObject& leaf) {
    Boxes boxes;
    const std::vector<glm::dmat4> keys = KeysFromDevice(groupFromObject, leaf);
    boxes.moves = !keys.empty();
    if (boxes.moves) {
        const std::array<Bounds, 2> ends = TransformEnds(keys, leaf.bounds);
        boxes.open = ends[0];
        boxes.close = ends[1];
        boxes.isUsable = true;
        return boxes;
    }
    const glm::dmat4 transform = GroupFromDevice(groupFromObject.AtFrame(), leaf);
    boxes.isUsable = IsUsable(transform, leaf.bounds);
    if (boxes.isUsable) {
        boxes.open = boxes.close = TransformBounds(transform, leaf.bounds);
    }
    return boxes;
}

/// What may have a scale of 0 for a part of its way, as things do that grow: such a key gets a
/// little of the shape of the nearest one that can be inverted, too small to be seen. Where none
/// can be, the keys stay.
void FillSingular(std::vector<glm::dmat4>* keys) {
    if (std::all_of(keys->begin(), keys->end(), IsUsableTransform)) {
        return;
    }
    constexpr int kSizeExponent = -16;
    const std::vector<glm::dmat4> given = *keys;
    std::vector<std::size_t> usable;
    for (std::size_t i = 0; i < given.size(); ++i) {
        if (IsUsableTransform(given[i])) {
            usable.push_back(i);
        }
    }
    for (std::size_t i = 0; i < given.size() && usable.size() < given.size(); ++i) {
        const auto distance = [i](std::size_t j) { return j < i ? i - j : j - i; };
        const auto nearest =
            std::min_element(usable.begin(), usable.end(), [&](std::size_t a, std::size_t b) {
                return distance(a) < distance(b);
            });
        if (nearest == usable.end() || *nearest == i) {
            continue;
        }
        for (int column = 0; column < 3; ++column) {
            (*keys)[i][column] += std::ldexp(1.0, kSizeExponent) * given[*nearest][column];
        }
    }
}

/// Keeps those values whose flag is set, if there are values.
void Compact(const std::vector<std::uint8_t>& isKept, std::size_t first,
             std::vector<Bounds>* values) {
    if (values->empty()) {
        return;
    }
    std::size_t end = first;
    for (std::size_t i = 0; i < isKept.size(); ++i) {
        if (isKept[i] != 0) {
            (*values)[end++] = (*values)[first + i];
        }
    }
    values->resize(end);
}

/// The linear part of the device's rows.
glm::dmat3 LinearOf(const AffineRows& rows) {
    glm::dmat3 linear;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            linear[column][row] = rows[static_cast<std::size_t>(4 * row + column)];
        }
    }
    return linear;
}

/// Whether the device may invert all between these keys in few operations.
bool ArePlain(const AffineRows* keys, std::uint32_t numSegments) {
    for (std::uint32_t i = 0; i < numSegments; ++i) {
        const glm::dmat3 from = LinearOf(keys[i]);
        const glm::dmat3 to = LinearOf(keys[i + 1]);
        for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0}) {
            const glm::dmat3 linear = (1.0 - part) * from + part * to;
            double product = 1.0;
            for (int column = 0; column < 3; ++column) {
                const double length = glm::length(linear[column]);
                if (!(length * HDS_MOTION_MOST_SIZE >= 1.0 && length <= HDS_MOTION_MOST_SIZE)) {
                    return false;
                }
                product *= length;
            }
            if (!(product <= HDS_MOTION_MOST_SHEAR * std::abs(glm::determinant(linear)))) {
                return false;
            }
        }
    }
    return true;
}

/// The keys of a record become the device's.
void AppendKeys(const std::vector<glm::dmat4>& keys, shared::HdsInstance* instance,
                std::vector<AffineRows>* motionKeys) {
    const auto first = static_cast<std::uint32_t>(motionKeys->size());
    auto segments = static_cast<std::uint32_t>(keys.size() - 1);
    instance->flags &= ~HDS_INSTANCE_IN_PLACE;
    instance->flags |= HDS_INSTANCE_MOVES;
    std::transform(keys.begin(), keys.end(), std::back_inserter(*motionKeys), RowsFromMatrix);
    const glm::dmat3 linear = LinearOf((*motionKeys)[first]);
    const bool slides =
        std::all_of(motionKeys->begin() + first, motionKeys->end(),
                    [&linear](const AffineRows& rows) { return LinearOf(rows) == linear; });
    if (slides) {
        segments |= HDS_MOTION_SLIDES;
        const glm::dmat3 inverse = glm::inverse(linear);
        for (int i = 0; i < 9; ++i) {
            instance->objectFromParent[HDS_MOTION_INVERSE + i] =
                static_cast<float>(inverse[i % 3][i / 3]);
        }
    } else if (ArePlain(motionKeys->data() + first, segments)) {
        segments |= HDS_MOTION_PLAIN;
    }
    std::memcpy(&instance->objectFromParent[HDS_MOTION_FIRST_KEY], &first, sizeof(first));
    std::memcpy(&instance->objectFromParent[HDS_MOTION_SEGMENTS], &segments, sizeof(segments));
}

} // namespace

glm::dmat4 GroupFromDevice(const glm::dmat4& groupFromObject, const LeafObject& leaf) {
    return ThickenFlat(glm::translate(groupFromObject, leaf.origin));
}

std::vector<glm::dmat4> KeysFromDevice(const MovingTransform& groupFromObject,
                                       const LeafObject& leaf) {
    if (!groupFromObject.Moves()) {
        return {};
    }
    const MovingTransform origin(glm::translate(glm::dmat4(1.0), leaf.origin));
    std::vector<glm::dmat4> keys = MakeMotionKeys(groupFromObject * origin, leaf.bounds);
    std::transform(keys.begin(), keys.end(), keys.begin(), ThickenFlat);
    FillSingular(&keys);
    const bool areUsable = std::all_of(keys.begin(), keys.end(), [&leaf](const glm::dmat4& key) {
        return IsUsable(key, leaf.bounds);
    });
    return areUsable ? keys : std::vector<glm::dmat4>();
}

glm::dmat4 UsableAtFrame(const glm::dmat4& groupFromDevice, const std::vector<glm::dmat4>& keys) {
    return keys.empty() || IsUsableTransform(groupFromDevice) ? groupFromDevice : keys.front();
}

MovingTransform InstanceTransform(const InstancerPrim& instancer, std::int32_t index,
                                  const Shutter& shutter) {
    const glm::dmat4 atFrame = instancer.instanceTransforms.At(static_cast<std::size_t>(index));
    if (!shutter.IsOpen() || instancer.samples.empty()) {
        return atFrame;
    }
    std::vector<TransformSample> samples;
    for (const InstanceSample& sample : instancer.samples) {
        if (sample.transforms.size() == 16 * instancer.instanceTransforms.Size()) {
            samples.push_back({sample.time, MatrixAt(sample.transforms, index)});
        }
    }
    return {atFrame, samples, shutter};
}

MovingTransform GroupRecords::TransformOf(const InstanceRun& run, std::int32_t instance) const {
    return run.groupFromInstancer * InstanceTransform(*run.instancer, instance, _shutter) *
           run.prototypeFromObject;
}

bool GroupRecords::MayMove(const InstanceRun& run) const {
    return run.groupFromInstancer.Moves() || run.prototypeFromObject.Moves() ||
           (_shutter.IsOpen() && !run.instancer->samples.empty());
}

/// From here on boxes have one at both ends.
void GroupRecords::ReserveCloseBoxes() {
    if (!_mayMove) {
        _mayMove = true;
        _closeBoxes = _boxes; // nothing when they are not kept
    }
}

void GroupRecords::AddPart(Part part, std::uint32_t count, std::uint64_t numLeaves) {
    part.first = _size;
    part.firstLeaf = _numLeaves;
    _parts.push_back(std::move(part));
    _size += count;
    _numLeaves += numLeaves * count;
}

PlacedRecord* GroupRecords::Add(PlacedRecord record) {
    const Boxes boxes = BoxesOf(record.groupFromObject, *record.leaf);
    if (!boxes.isUsable) {
        return nullptr;
    }
    if (boxes.moves) {
        ReserveCloseBoxes();
        _moves = true;
    }
    if (_keepsBoxes) {
        _boxes.push_back(boxes.open);
    }
    if (_keepsBoxes && _mayMove) {
        _closeBoxes.push_back(boxes.close);
    }
    _flags |= record.leaf->flags;
    _numPrimitives += record.leaf->numPrimitives;
    _numFlatOfSingles += record.leaf->numFlat;
    if (_parts.empty() || _parts.back().run) {
        Part part;
        part.firstSingle = static_cast<std::uint32_t>(_singles.size());
        AddPart(std::move(part), 1, 1);
    } else {
        ++_size;
        ++_numLeaves;
    }
    _singles.push_back(std::move(record));
    return &_singles.back();
}

std::uint32_t GroupRecords::Add(InstanceRun run) {
    const std::size_t limit = run.instancer->instanceTransforms.Size();
    const auto count = static_cast<std::uint32_t>(run.instances.size());
    if (MayMove(run)) {
        ReserveCloseBoxes();
    }
    const std::size_t first = _size;
    if (_keepsBoxes) {
        _boxes.resize(first + count);
        _closeBoxes.resize(_mayMove ? first + count : 0);
    }
    std::vector<std::uint8_t> isKept(count);
    std::atomic<std::uint32_t> numBad{0};
    std::atomic<bool> isComplete{true};
    std::atomic<bool> moves{false};
    const auto add = [&](const tbb::blocked_range<std::uint32_t>& ranks, Bounds bounds) {
        for (std::uint32_t rank = ranks.begin(); rank < ranks.end(); ++rank) {
            const std::int32_t index = run.instances[rank];
            const bool isInRange = index >= 0 && static_cast<std::size_t>(index) < limit;
            const Boxes boxes = isInRange ? BoxesOf(TransformOf(run, index), run.leaf) : Boxes{};
            if (!boxes.isUsable) {
                isComplete = false;
                numBad += index == kGap ? 0 : 1;
                continue;
            }
            isKept[rank] = 1;
            ExtendBounds(&bounds, boxes.open);
            if (_keepsBoxes) {
                _boxes[first + rank] = boxes.open;
            }
            if (_keepsBoxes && _mayMove) {
                _closeBoxes[first + rank] = boxes.close;
            }
            if (boxes.moves) {
                moves = true;
            }
        }
        return bounds;
    };
    const Bounds bounds = tbb::parallel_reduce(tbb::blocked_range<std::uint32_t>(0, count),
                                               Bounds(), add, [](Bounds a, const Bounds& b) {
                                                   ExtendBounds(&a, b);
                                                   return a;
                                               });
    ExtendBounds(&_boundsOfRuns, bounds);
    _moves = _moves || moves;
    Part part;
    std::uint32_t numAdded = count;
    if (!isComplete) {
        for (std::uint32_t rank = 0; rank < count; ++rank) {
            if (isKept[rank] != 0) {
                part.ranks.push_back(rank);
            }
        }
        numAdded = static_cast<std::uint32_t>(part.ranks.size());
        Compact(isKept, first, &_boxes);
        Compact(isKept, first, &_closeBoxes);
    }
    if (numAdded > 0) {
        _flags |= run.leaf.flags;
        _numPrimitives += double{run.leaf.numPrimitives} * numAdded;
        _numFlatOfRuns += double{run.leaf.numFlat} * numAdded;
        const std::uint64_t numLeaves = run.numLeaves;
        part.run = std::move(run);
        AddPart(std::move(part), numAdded, numLeaves);
        _numInRuns += numAdded;
    }
    return numBad;
}

/// Of all records, where they were not kept.
void GroupRecords::ComputeBoxes() {
    _boxes.resize(_size);
    _closeBoxes.resize(_moves ? _size : 0);
    tbb::parallel_for(std::uint32_t{0}, _size, [&](std::uint32_t record) {
        const Found found = Find(record);
        const Boxes boxes = BoxesOf(found.groupFromObject, *found.leaf);
        _boxes[record] = boxes.open;
        if (_moves) {
            _closeBoxes[record] = boxes.close;
        }
    });
}

BoxesOfRecords GroupRecords::TakeBoxes() {
    if (!_keepsBoxes) {
        ComputeBoxes();
    }
    if (!_moves) {
        std::vector<Bounds>().swap(_closeBoxes);
    }
    return {std::move(_boxes), std::move(_closeBoxes)};
}

const GroupRecords::Part& GroupRecords::PartOf(std::uint32_t record) const {
    const auto after = std::upper_bound(
        _parts.begin(), _parts.end(), record,
        [](std::uint32_t wanted, const Part& part) { return wanted < part.first; });
    return *(after - 1);
}

std::optional<std::uint32_t> GroupRecords::SingleOf(std::uint32_t record) const {
    const Part& part = PartOf(record);
    return part.run ? std::nullopt : std::optional(part.firstSingle + record - part.first);
}

bool GroupRecords::IsWorldInstance(std::uint32_t record) const {
    const std::optional<std::uint32_t> single = SingleOf(record);
    return single && _singles[*single].worldInstance != HDS_NONE;
}

Bounds GroupRecords::BoxOf(std::uint32_t record) const {
    const Found found = Find(record);
    return TransformBounds(DeviceTransform(found), found.leaf->bounds);
}

std::vector<std::uint32_t> GroupRecords::Singles() const {
    std::vector<std::uint32_t> singles;
    singles.reserve(_singles.size());
    for (const Part& part : _parts) {
        const std::uint32_t end = &part == &_parts.back() ? _size : (&part + 1)->first;
        for (std::uint32_t record = part.first; !part.run && record < end; ++record) {
            singles.push_back(record);
        }
    }
    return singles;
}

void GroupRecords::Keep() {
    const std::vector<std::uint32_t> singles = Singles();
    std::vector<shared::HdsInstance> records(singles.size());
    std::vector<Bounds> boxes(singles.size());
    WriteWithBoxes(singles.data(), static_cast<std::uint32_t>(singles.size()), records.data(),
                   boxes.data());
    _keptSingles = std::move(records);
    _keptBoxes = std::move(boxes);
    std::map<const InstancerPrim*, const InstancerPrim*> keptOf;
    for (Part& part : _parts) {
        if (!part.run) {
            continue;
        }
        const InstancerPrim*& kept = keptOf[part.run->instancer];
        if (kept == nullptr) {
            auto copy = std::make_shared<InstancerPrim>();
            copy->instanceTransforms = part.run->instancer->instanceTransforms; // shares the arrays
            kept = copy.get();
            _kept.push_back(std::move(copy));
        }
        part.run->instancer = kept;
    }
    std::vector<PlacedRecord>().swap(_singles);
    std::vector<Bounds>().swap(_boxes);
    std::vector<Bounds>().swap(_closeBoxes);
}

GroupRecords::Found GroupRecords::Find(std::uint32_t record) const {
    const Part& part = PartOf(record);
    const std::uint32_t index = record - part.first;
    if (!part.run) {
        const PlacedRecord& single = _singles[part.firstSingle + index];
        return {single.leaf,
                single.groupFromObject,
                single.leaf->flags | single.moreFlags,
                single.count,
                single.rank,
                part.firstLeaf + index};
    }
    const InstanceRun& run = *part.run;
    const std::uint32_t rank = part.ranks.empty() ? index : part.ranks[index];
    return {&run.leaf,      TransformOf(run, run.instances[rank]),
            run.leaf.flags, static_cast<std::uint32_t>(run.instances.size()),
            rank,           part.firstLeaf + index * run.numLeaves};
}

std::vector<GroupRecords::World> GroupRecords::WorldRecords() const {
    std::vector<World> worlds;
    for (const Part& part : _parts) {
        const std::size_t end = &part == &_parts.back() ? _size : (&part + 1)->first;
        for (std::uint32_t i = part.first; !part.run && i < end; ++i) {
            const PlacedRecord& single = _singles[part.firstSingle + (i - part.first)];
            if (single.worldInstance != HDS_NONE) {
                worlds.push_back({single.worldInstance, i, part.firstLeaf + (i - part.first)});
            }
        }
    }
    return worlds;
}

glm::dmat4 GroupRecords::DeviceTransform(const Found& found) {
    return GroupFromDevice(found.groupFromObject.AtFrame(), *found.leaf);
}

shared::HdsInstance GroupRecords::RecordOf(const Found& found, const glm::dmat4& transform) {
    shared::HdsInstance instance{};
    const AffineRows inverse = RowsFromMatrix(glm::inverse(transform));
    std::copy(inverse.begin(), inverse.end(), instance.objectFromParent);
    instance.object = found.leaf->object;
    instance.flags =
        found.flags | (IsIdentity(instance.objectFromParent) ? HDS_INSTANCE_IN_PLACE : 0U);
    instance.pathOffset[0] = static_cast<std::uint32_t>(found.pathOffset);
    instance.pathOffset[1] = static_cast<std::uint32_t>(found.pathOffset >> 32U);
    instance.prim = found.leaf->prim;
    instance.lightBase = HDS_NONE;
    instance.instanceCount = found.count;
    instance.instanceRank = found.rank;
    return instance;
}

void GroupRecords::WriteWithBoxes(const std::uint32_t* records, std::uint32_t count,
                                  shared::HdsInstance* places, Bounds* boxes) const {
    tbb::parallel_for(std::uint32_t{0}, count, [&](std::uint32_t i) {
        const std::optional<std::uint32_t> single = SingleOf(records[i]);
        if (single && !_keptSingles.empty()) {
            places[i] = _keptSingles[*single];
            boxes[i] = _keptBoxes[*single];
            return;
        }
        const Found found = Find(records[i]);
        const glm::dmat4 transform = DeviceTransform(found);
        places[i] = RecordOf(found, transform);
        boxes[i] = TransformBounds(transform, found.leaf->bounds);
    });
}

void GroupRecords::Write(const std::vector<std::uint32_t>& order, shared::HdsInstance* places,
                         std::vector<AffineRows>* motionKeys) const {
    const auto write = [&](std::uint32_t place, std::vector<glm::dmat4>* keys) {
        const Found found = Find(order[place]);
        glm::dmat4 transform = DeviceTransform(found);
        if (keys != nullptr) {
            *keys = KeysFromDevice(found.groupFromObject, *found.leaf);
            transform = UsableAtFrame(transform, *keys);
        }
        places[place] = RecordOf(found, transform);
    };
    const auto size = static_cast<std::uint32_t>(order.size());
    if (!_moves) {
        tbb::parallel_for(std::uint32_t{0}, size,
                          [&](std::uint32_t place) { write(place, nullptr); });
        return;
    }
    std::vector<std::vector<glm::dmat4>> keys;
    for (std::uint32_t begin = 0; begin < size; begin += kMovingBlock) {
        const std::uint32_t end = std::min(size, begin + kMovingBlock);
        keys.assign(end - begin, {});
        tbb::parallel_for(begin, end,
                          [&](std::uint32_t place) { write(place, &keys[place - begin]); });
        for (std::uint32_t place = begin; place < end; ++place) {
            if (!keys[place - begin].empty()) {
                AppendKeys(keys[place - begin], &places[place], motionKeys);
            }
        }
    }
}

} // namespace hds
