// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/flatPlaces.h"

#include "hdStream/accel/leafSlots.h"
#include "hdStream/accel/objectNumber.h"

#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <unordered_set>

namespace hds {
namespace {

/// Instances of the TLAS beyond which there is little to gain: rays meet few of them.
constexpr std::uint32_t kMaxInstances = 1U << 16U;
/// Numbers of records in later ones are too large for HDS_FLAT_IN_CHUNK.
constexpr std::uint32_t kMaxInstanceChunks = HDS_FLAT_IN_CHUNK >> HDS_RECORD_CHUNK_SHIFT;
/// Of a box in units of its largest coordinate: 64 roundoffs of 2^-24 for one transform on the way,
/// 256 for more. With them go HDS_FLAT_PAD of the kernels.
constexpr int kMarginExponent = -18;
constexpr int kDeepMarginExponent = -16;
/// Largest row sum of |M^-1||M| that these margins are for.
constexpr double kMaxGrowth = 3.0;
constexpr double kMaxDeepGrowth = 9.0;
constexpr double kTolerance = 1.0 + 1e-5;
/// What a copy takes beside its mesh's tree and the transforms on the way to it: its place and, of
/// nodes with some three children each, its box.
constexpr double kBytesACopy = sizeof(shared::HdsFlatPlace) + 80.0;
/// What a flattened mesh takes beside its triangles and the transforms on the way to it: its place,
/// and a leaf that they do not fill.
constexpr double kBytesAPlace = sizeof(shared::HdsFlatPlace) + sizeof(shared::HdsFlatLeaf);
/// On the way each takes some 500 bytes.
constexpr double kMaxCopies = 1U << 18U;

shared::HdsPageHeader HeaderOf(const std::uint8_t* page) {
    shared::HdsPageHeader header{};
    std::memcpy(&header, page, sizeof(header));
    return header;
}

/// Triangles at rest.
bool IsFlatPage(const shared::HdsPageHeader& header) {
    return header.numTriangles >> HDS_PRIMITIVE_SHIFT == HDS_PRIMITIVE_TRIANGLES &&
           (header.vertices & (HDS_PAGE_MOVES | HDS_PAGE_BOXES_MOVE)) == 0;
}

/// The records of an instance chunk.
struct ChunkRecords {
    const shared::HdsInstance* records;
    std::uint32_t count;
    const shared::HdsBvhNode* nodes;

    explicit ChunkRecords(const std::uint8_t* page) : count(NumPrimitivesOfPage(page)) {
        const std::size_t at = std::size_t{HeaderOf(page).triangles} * HDS_POOL_UNIT_BYTES;
        records = reinterpret_cast<const shared::HdsInstance*>(page + at);
        nodes = reinterpret_cast<const shared::HdsBvhNode*>(page + sizeof(shared::HdsPageHeader));
    }
};

/// The number of an instance chunk's first record.
std::uint32_t FirstRecordOf(std::uint32_t chunk) {
    return HDS_RECORD_IN_CHUNK | chunk << HDS_RECORD_CHUNK_SHIFT;
}

glm::dmat4 MatrixOf(const shared::HdsInstance& instance) {
    glm::dmat4 matrix(1.0);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
            matrix[column][row] = instance.objectFromParent[4 * row + column];
        }
    }
    return matrix;
}

shared::HdsFlatTransform ColumnsOf(const shared::HdsInstance& instance) {
    shared::HdsFlatTransform transform{};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
            transform.columns[column][row] = instance.objectFromParent[4 * row + column];
        }
    }
    return transform;
}

glm::dmat3 Abs(const glm::dmat3& matrix) {
    return {glm::abs(matrix[0]), glm::abs(matrix[1]), glm::abs(matrix[2])};
}

/// What is known of an object without its transforms.
struct ObjectTraits {
    bool isFlat = true;        ///< it may be flattened
    std::uint32_t records = 0; ///< below it, on the longest way
    double numTriangles = 0.0; ///< or other primitives, each as often as it is placed below it
    double numUnique = 0.0;    ///< each once in every object it is placed in
    double numMeshes = 0.0;    ///< each as often as it is placed below it
};

/// Where a walk down the groups is.
struct Way {
    std::array<std::uint32_t, HDS_FLAT_MAX_RECORDS> records{};
    std::uint32_t count = 0;
    std::uint64_t path = 0;
    std::uint32_t seen = ~0U;
    glm::dmat4 objectFromWorld{1.0};
    glm::dmat3 size{1.0}; ///< product of the linear parts' absolute values
    bool isInPlace = true;
    bool isCopied = false; ///< the meshes have trees of their own
};

class PlaceFinder {
public:
    PlaceFinder(const FlatSource& source, FlatPlaces* places)
        : _source(source), _objects(*source.objects), _places(*places) {}

    void Find(const FlatAmount& amount) {
        const shared::HdsObject& root = _objects[0];
        if (root.numItems == 0 || root.numItems > kMaxInstances) {
            return;
        }
        double held = 0.0;
        double bytes = 0.0;
        double numCopies = 0.0;
        double taken = 0.0; // of those that are placed
        double placed = 0.0;
        std::vector<Placed> order = ListRecords(&placed);
        std::stable_sort(order.begin(), order.end(), [](const Placed& a, const Placed& b) {
            return a.second.size() < b.second.size();
        });
        std::unordered_set<std::uint32_t> isFlat; // records
        for (const auto& [object, records] : order) {
            const ObjectTraits& traits = TraitsOf(object);
            const double added = traits.numTriangles * static_cast<double>(records.size());
            placed += added;
            if (!traits.isFlat || traits.records >= HDS_FLAT_MAX_RECORDS) {
                continue;
            }
            const auto most = static_cast<double>(amount.maxTriangles);
            const auto numRecords = static_cast<double>(records.size());
            const double ofWay = sizeof(shared::HdsFlatTransform) * (traits.records + 1.0);
            const double flatBytes = kFlatBytesATriangle * added +
                                     (kBytesAPlace + ofWay) * traits.numMeshes * numRecords;
            const bool hasManyCopies = added > amount.maxCopies * traits.numUnique;
            const bool isCopied = (hasManyCopies && held + added > amount.manyTriangles) ||
                                  held + added > most || bytes + flatBytes > amount.maxBytes;
            const double ofCopies = (kBytesACopy + ofWay) / kFlatBytesATriangle * traits.numMeshes;
            const double copiedBytes =
                kFlatBytesATriangle * (traits.numUnique + ofCopies * numRecords);
            if (isCopied && (held + traits.numUnique + ofCopies * numRecords > most ||
                             bytes + copiedBytes > amount.maxBytes ||
                             numCopies + traits.numMeshes * numRecords > kMaxCopies)) {
                continue;
            }
            bytes += isCopied ? copiedBytes : flatBytes;
            numCopies += isCopied ? traits.numMeshes * numRecords : 0.0;
            bool isFirst = true;
            for (const std::uint32_t record : records) {
                if (AddPlaces(record, isCopied)) {
                    isFlat.insert(record);
                    taken += traits.numTriangles;
                    held += isCopied ? ofCopies : traits.numTriangles;
                    held += isCopied && isFirst ? traits.numUnique : 0.0;
                    isFirst = false;
                }
            }
        }
        if (taken < amount.minShare * placed) {
            _places = {};
            return;
        }
        AddTransforms();
        AddCopies();
        AddInstances(isFlat);
    }

private:
    /// An object, and the records of the TLAS that place it.
    using Placed = std::pair<std::uint32_t, std::vector<std::uint32_t>>;

    /// Records of the TLAS that may be flattened, by their objects. Of those in chunks these are
    /// the ones that no instancer places, where there are not too many records around them: the
    /// chunk is opened. \param[out] placed the primitives of all others.
    std::vector<Placed> ListRecords(double* placed) {
        const shared::HdsObject& root = _objects[0];
        std::map<std::uint32_t, std::vector<std::uint32_t>> byObject;
        std::uint32_t numOpened = 0; // records
        for (std::uint32_t i = 0; i < root.numItems; ++i) {
            const std::uint32_t record = root.itemBase + i;
            const std::uint32_t index = _source.instances[record].object;
            const shared::HdsObject object = ObjectOf(_objects, index);
            if (object.kind != HDS_OBJECT_INSTANCES) {
                byObject[index].push_back(record);
                continue;
            }
            const std::uint32_t chunk = object.itemBase;
            const ChunkRecords held(_source.page(chunk));
            const auto isSingle = [](const shared::HdsInstance& one) {
                return one.instanceCount == 0;
            };
            const bool isOpened = chunk < kMaxInstanceChunks &&
                                  numOpened + held.count <= kMaxInstances &&
                                  std::any_of(held.records, held.records + held.count, isSingle);
            numOpened += isOpened ? held.count : 0;
            for (std::uint32_t k = 0; k < held.count; ++k) {
                if (isOpened && isSingle(held.records[k])) {
                    byObject[held.records[k].object].push_back(FirstRecordOf(chunk) + k);
                } else {
                    *placed += TraitsOf(held.records[k].object).numTriangles;
                }
            }
        }
        return {byObject.begin(), byObject.end()};
    }

    /// A record by its number.
    const shared::HdsInstance& RecordOf(std::uint32_t record) const {
        if ((record & HDS_RECORD_IN_CHUNK) == 0) {
            return _source.instances[record];
        }
        const std::uint32_t chunk = (record & ~HDS_RECORD_IN_CHUNK) >> HDS_RECORD_CHUNK_SHIFT;
        return ChunkRecords(_source.page(chunk)).records[record & (HDS_MAX_CHUNK_RECORDS - 1U)];
    }

    const ObjectTraits& TraitsOf(std::uint32_t index) {
        const auto found = _traits.find(index);
        if (found != _traits.end()) {
            return found->second;
        }
        const shared::HdsObject object = ObjectOf(_objects, index);
        ObjectTraits traits;
        if ((object.kind & HDS_OBJECT_KIND) == HDS_OBJECT_GROUP) {
            traits.isFlat = object.numItems <= kMaxInstances;
            std::unordered_set<std::uint32_t> known;
            for (std::uint32_t i = 0; i < object.numItems; ++i) {
                const shared::HdsInstance& instance = _source.instances[object.itemBase + i];
                const ObjectTraits& below = TraitsOf(instance.object);
                traits.isFlat = traits.isFlat && below.isFlat;
                traits.records = std::max(traits.records, below.records + 1);
                traits.numTriangles += below.numTriangles;
                traits.numMeshes += below.numMeshes;
                if (known.insert(instance.object).second) {
                    traits.numUnique += below.numUnique;
                }
            }
        } else if (object.kind == HDS_OBJECT_INSTANCES) {
            traits.isFlat = false; // so many that a group has chunks are not flattened
            const ChunkRecords held(_source.page(object.itemBase));
            for (std::uint32_t i = 0; i < held.count; ++i) {
                traits.numTriangles += TraitsOf(held.records[i].object).numTriangles;
            }
        } else {
            for (std::uint32_t i = 0; i < object.numItems; ++i) {
                const std::uint8_t* page = _source.page(object.itemBase + i);
                traits.isFlat = traits.isFlat && IsFlatPage(HeaderOf(page));
                traits.numTriangles += NumPrimitivesOfPage(page);
            }
            traits.numUnique = traits.numTriangles;
            traits.numMeshes = 1.0;
        }
        return _traits.emplace(index, traits).first->second;
    }

    /// Adds the places below a record of the TLAS. \return false, and none, when one cannot be.
    bool AddPlaces(std::uint32_t record, bool isCopied) {
        const std::size_t numPlaces = _places.places.size();
        Way way;
        way.isCopied = isCopied;
        if (Descend(record, way)) {
            return true;
        }
        _places.places.resize(numPlaces);
        _places.placements.resize(numPlaces);
        return false;
    }

    bool Descend(std::uint32_t record, Way way) {
        const shared::HdsInstance& instance = RecordOf(record);
        const shared::HdsObject object = ObjectOf(_objects, instance.object);
        if ((instance.flags & HDS_INSTANCE_MOVES) != 0) {
            return false;
        }
        const glm::dmat4 objectFromParent = MatrixOf(instance);
        way.records[way.count++] = record;
        way.path += std::uint64_t{instance.pathOffset[1]} << 32U | instance.pathOffset[0];
        way.seen &= instance.flags;
        way.objectFromWorld = objectFromParent * way.objectFromWorld;
        way.size = Abs(glm::dmat3(objectFromParent)) * way.size;
        way.isInPlace = way.isInPlace && (instance.flags & HDS_INSTANCE_IN_PLACE) != 0;
        if ((object.kind & HDS_OBJECT_KIND) != HDS_OBJECT_GROUP) {
            // Of a mesh without a triangle there is no tree, and nothing to meet.
            return TraitsOf(instance.object).numTriangles == 0.0 || AddPlace(instance, record, way);
        }
        for (std::uint32_t i = 0; i < object.numItems; ++i) {
            if (!Descend(object.itemBase + i, way)) {
                return false;
            }
        }
        return true;
    }

    bool AddPlace(const shared::HdsInstance& instance, std::uint32_t record, const Way& way) {
        FlatPlacement placement;
        placement.object = instance.object;
        placement.worldFromObject = glm::inverse(way.objectFromWorld);
        placement.isInPlace = way.isInPlace;
        placement.isCopy = way.isCopied;
        placement.marginExponent = way.count == 1 ? kMarginExponent : kDeepMarginExponent;
        const glm::dmat3 growth = Abs(glm::dmat3(placement.worldFromObject)) * way.size;
        const double largest = way.count == 1 ? kMaxGrowth : kMaxDeepGrowth;
        for (int row = 0; row < 3; ++row) {
            if (!(growth[0][row] + growth[1][row] + growth[2][row] <= largest * kTolerance)) {
                return false;
            }
        }
        shared::HdsFlatPlace place{};
        place.instance = _source.hasInstanceChunks ? way.records[0] : record;
        place.flags = instance.flags;
        place.seen = way.seen;
        place.pathIndex[0] = static_cast<std::uint32_t>(way.path);
        place.pathIndex[1] = static_cast<std::uint32_t>(way.path >> 32U);
        placement.records = way.records;
        placement.numRecords = way.count;
        _places.places.push_back(place);
        _places.placements.push_back(placement);
        return true;
    }

    /// Places with equal transforms on the way share them.
    void AddTransforms() {
        using Rows = std::array<std::uint32_t, 12>;
        std::map<std::vector<Rows>, std::uint32_t> known;
        for (std::size_t index = 0; index < _places.places.size(); ++index) {
            const FlatPlacement& placement = _places.placements[index];
            std::vector<Rows> way(placement.numRecords);
            for (std::uint32_t i = 0; i < placement.numRecords; ++i) {
                const shared::HdsInstance& instance = RecordOf(placement.records[i]);
                std::memcpy(way[i].data(), instance.objectFromParent, sizeof(Rows));
            }
            const auto next = static_cast<std::uint32_t>(_places.transforms.size());
            const auto [found, isNew] = known.emplace(std::move(way), next);
            for (std::uint32_t i = 0; isNew && i < placement.numRecords; ++i) {
                _places.transforms.push_back(ColumnsOf(RecordOf(placement.records[i])));
            }
            _places.places[index].firstTransform = found->second;
            _places.places[index].numTransforms = placement.numRecords;
        }
    }

    /// Boxes of copies, and their meshes.
    void AddCopies() {
        std::map<std::uint32_t, std::vector<Bounds>> boxesOf; // objects, in their space
        for (std::uint32_t place = 0; place < _places.places.size(); ++place) {
            const FlatPlacement& placement = _places.placements[place];
            if (!placement.isCopy) {
                continue;
            }
            const auto [found, isNew] = boxesOf.try_emplace(placement.object);
            if (isNew) {
                found->second = BoxesOfMesh(placement.object);
                FlatPlacement own;
                own.object = placement.object;
                own.isInPlace = true;
                own.marginExponent = kMarginExponent;
                _places.meshes.push_back(own);
            }
            _places.copies.push_back({place, BoundsOf(found->second, placement)});
        }
    }

    /// Boxes that hold a mesh: those in the roots of its chunks, or of its top tree where it has
    /// many.
    std::vector<Bounds> BoxesOfMesh(std::uint32_t index) const {
        constexpr std::uint32_t kManyChunks = 8;
        const shared::HdsObject object = ObjectOf(_objects, index);
        std::vector<Bounds> boxes;
        if (object.numItems > kManyChunks) {
            AddBoxesOf(_source.topNodes[object.nodeBase], &boxes);
            return boxes;
        }
        for (std::uint32_t i = 0; i < object.numItems; ++i) {
            const std::uint8_t* page = _source.page(object.itemBase + i);
            AddBoxesOf(
                *reinterpret_cast<const shared::HdsBvhNode*>(page + sizeof(shared::HdsPageHeader)),
                &boxes);
        }
        return boxes;
    }

    static void AddBoxesOf(const shared::HdsBvhNode& node, std::vector<Bounds>* boxes) {
        for (int slot = 0; slot < 8; ++slot) {
            const bool isInner = (node.exponentsImask >> (24 + slot) & 1U) != 0;
            if (isInner || (node.meta[slot / 4] >> (8 * (slot % 4)) & 0xffU) != 0) {
                boxes->push_back(ExactBoxOf(node, slot));
            }
        }
    }

    /// What holds the boxes in the place, widened.
    static Bounds BoundsOf(const std::vector<Bounds>& boxes, const FlatPlacement& placement) {
        const glm::dmat3 size = Abs(glm::dmat3(placement.worldFromObject));
        glm::dvec3 lo(std::numeric_limits<double>::infinity());
        glm::dvec3 hi(-lo);
        for (const Bounds& box : boxes) {
            const glm::dvec3 middle = 0.5 * (glm::dvec3(box.min) + glm::dvec3(box.max));
            const glm::dvec3 half = size * (0.5 * (glm::dvec3(box.max) - glm::dvec3(box.min)));
            const glm::dvec3 moved(placement.worldFromObject * glm::dvec4(middle, 1.0));
            lo = glm::min(lo, moved - half);
            hi = glm::max(hi, moved + half);
        }
        return WidenForFlat(lo, hi, placement.marginExponent);
    }

    /// Those of the TLAS that are not flattened, with the boxes that its nodes have; of boxes that
    /// move, what holds them from the opening of the shutter to its closing. Of a chunk of which
    /// something is flattened these are the records that are not.
    void AddInstances(const std::unordered_set<std::uint32_t>& isFlat) {
        const shared::HdsObject& root = _objects[0];
        const std::uint32_t closeNodes = root.kind >> HDS_OBJECT_CLOSE_SHIFT; // 0: none moves
        ForEachLeafSlot(_source.topNodes + root.nodeBase, [&](const shared::HdsBvhNode& node,
                                                              int slot, std::uint32_t item,
                                                              std::uint32_t /*one*/) {
            const std::uint32_t record = root.itemBase + item;
            const shared::HdsObject object = ObjectOf(_objects, _source.instances[record].object);
            if (object.kind == HDS_OBJECT_INSTANCES &&
                AddInstancesOfChunk(object.itemBase, isFlat)) {
                return;
            }
            if (isFlat.count(record) == 0) {
                const shared::HdsBvhNode& closed = *(&node + closeNodes);
                _places.instances.push_back(
                    {record, UnionOf(BoxOf(node, slot), BoxOf(closed, slot))});
            }
        });
    }

    /// \return false, and none, when nothing of the chunk is flattened.
    bool AddInstancesOfChunk(std::uint32_t chunk, const std::unordered_set<std::uint32_t>& isFlat) {
        const ChunkRecords held(_source.page(chunk));
        const std::uint32_t first = FirstRecordOf(chunk);
        std::vector<FlatInstance> instances;
        ForEachLeafSlot(held.nodes, [&](const shared::HdsBvhNode& node, int slot,
                                        std::uint32_t item, std::uint32_t /*one*/) {
            if (isFlat.count(first + item) == 0) {
                instances.push_back({first + item, BoxOf(node, slot)});
            }
        });
        if (instances.size() == held.count) {
            return false;
        }
        _places.instances.insert(_places.instances.end(), instances.begin(), instances.end());
        return true;
    }

    static Bounds UnionOf(const Bounds& a, const Bounds& b) {
        return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
    }

    static Bounds BoxOf(const shared::HdsBvhNode& node, int slot) {
        const Bounds box = ExactBoxOf(node, slot);
        return WidenForFlat(glm::dvec3(box.min), glm::dvec3(box.max), kDeepMarginExponent);
    }

    /// Rounded outwards.
    static Bounds ExactBoxOf(const shared::HdsBvhNode& node, int slot) {
        Bounds box;
        for (int axis = 0; axis < 3; ++axis) {
            const int exponent = static_cast<int>(node.exponentsImask >> (8 * axis) & 0xffU) - 127;
            const auto plane = [&](const std::uint32_t* words) {
                const std::uint32_t q = words[slot / 4] >> (8 * (slot % 4)) & 0xffU;
                return double{node.origin[axis]} + std::ldexp(double(q), exponent);
            };
            box.min[axis] = RoundDown(plane(node.qlo[axis]));
            box.max[axis] = -RoundDown(-plane(node.qhi[axis]));
        }
        return box;
    }

    static float RoundDown(double value) {
        const auto rounded = static_cast<float>(value);
        return double{rounded} <= value
                   ? rounded
                   : std::nextafter(rounded, -std::numeric_limits<float>::infinity());
    }

    const FlatSource& _source;
    const std::vector<shared::HdsObject>& _objects;
    FlatPlaces& _places;
    std::map<std::uint32_t, ObjectTraits> _traits;
};

} // namespace

FlatPlaces FindFlatPlaces(const FlatSource& source, const FlatAmount& amount) {
    FlatPlaces places;
    PlaceFinder(source, &places).Find(amount);
    return places;
}

Bounds WidenForFlat(const glm::dvec3& lo, const glm::dvec3& hi, int exponent) {
    const glm::dvec3 far = glm::max(glm::abs(lo), glm::abs(hi));
    const double margin = std::ldexp(std::max({far.x, far.y, far.z}), exponent);
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    Bounds bounds;
    for (int axis = 0; axis < 3; ++axis) {
        bounds.min[axis] = std::nextafter(static_cast<float>(lo[axis] - margin), -kInfinity);
        bounds.max[axis] = std::nextafter(static_cast<float>(hi[axis] + margin), kInfinity);
    }
    return bounds;
}

std::uint32_t NumPrimitivesOfPage(const std::uint8_t* page) {
    return HeaderOf(page).numTriangles & ((1U << HDS_PRIMITIVE_SHIFT) - 1U);
}

} // namespace hds
