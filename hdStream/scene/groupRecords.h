// SPDX-License-Identifier: Apache-2.0
// The instance records of one group before its BVH gives them their places. Instances are kept as
// runs, an instancer's list of them with what it places, and computed twice from the arrays as
// authored: their boxes for the BVH, then the records where they stay. So a million instances take
// no memory of their own on the way but a box each, and none where boxes are computed again.
// Explained in docs/architecture.md, "Instances".
#pragma once

#include "hdStream/geometry/triangleMesh.h"
#include "hdStream/scene/motion.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/scene/transforms.h"
#include "kernels/shared/geometry.h"

#include <memory>
#include <optional>
#include <vector>

namespace hds {

/// A prim or a group as the hierarchy sees it.
struct LeafObject {
    std::uint32_t object = 0;
    std::uint32_t prim = 0;
    std::uint32_t flags = 0;    ///< HDS_INSTANCE_*
    float numPrimitives = 1.0F; ///< about, each as often as it is placed below it
    glm::dvec3 origin{0.0};     ///< object-space origin of the device positions
    Bounds bounds;              ///< relative to origin
    bool worldInstance = false; ///< needs a record in the TLAS
    bool isLinkedByInstance =
        false;            ///< its instances have link sets of their own, so it needs a record too
    float numFlat = 1.0F; ///< of its primitives those that a flat hierarchy may take
};

/// From the device positions of an object to its group; what is flattened is a thin sheet
/// (ThickenFlat).
glm::dmat4 GroupFromDevice(const glm::dmat4& groupFromObject, const LeafObject& leaf);

/// The same at equal steps in time, as the device has it; none of what rests. Poses that cannot be
/// inverted are replaced by very small ones; none of what has no other, which stays where the frame
/// has it.
std::vector<glm::dmat4> KeysFromDevice(const MovingTransform& groupFromObject,
                                       const LeafObject& leaf);

/// What stands for the frame's pose of what has keys: that, or the first key where it cannot be
/// inverted.
glm::dmat4 UsableAtFrame(const glm::dmat4& groupFromDevice, const std::vector<glm::dmat4>& keys);

/// One placement of a prim, which must outlive it.
struct PlacedRecord {
    const LeafObject* leaf = nullptr;
    MovingTransform groupFromObject{glm::dmat4(1.0)};
    std::uint32_t count = 0; ///< HdsInstance::instanceCount
    std::uint32_t rank = 0;
    std::uint32_t moreFlags = 0;            ///< HDS_INSTANCE_* beside the leaf's
    std::uint32_t worldInstance = HDS_NONE; ///< index in Hierarchy::worldInstances
};

/// Placements of one thing by a list of an instancer's instances. The instancer must outlive it,
/// but see GroupRecords::Keep.
struct InstanceRun {
    LeafObject leaf;
    std::uint64_t numLeaves = 1; ///< of each
    MovingTransform groupFromInstancer{glm::dmat4(1.0)};
    const InstancerPrim* instancer = nullptr;
    SharedSpan<std::int32_t> instances;
    MovingTransform prototypeFromObject{glm::dmat4(1.0)};
};

/// Where the records of a group are.
struct BoxesOfRecords {
    std::vector<Bounds> open;
    std::vector<Bounds> close; ///< empty when nothing moves
};

/// Collects the records of a group in the order of scene paths. Externally synchronised; uses all
/// cores.
class GroupRecords {
public:
    /// \param keepsBoxes of instances: else they are computed again when they are asked for, which
    /// takes time in place of 24 bytes an instance.
    explicit GroupRecords(const Shutter& shutter, bool keepsBoxes = true)
        : _shutter(shutter), _keepsBoxes(keepsBoxes) {}

    /// Makes room for so many single records.
    void Reserve(std::size_t count) {
        _singles.reserve(count);
        _boxes.reserve(_keepsBoxes ? count : 0);
    }
    /// \return the record, until the next one is added; null when its transform cannot be used: it
    /// is not added.
    PlacedRecord* Add(PlacedRecord record);
    /// \return how many were not added, for their transforms or their indices; gaps of the list
    /// (docs/architecture.md) do not count.
    std::uint32_t Add(InstanceRun run);

    std::uint32_t Size() const { return _size; }
    std::uint64_t NumLeaves() const { return _numLeaves; }
    /// LeafObject::numPrimitives of all records.
    float NumPrimitives() const { return static_cast<float>(_numPrimitives); }
    /// LeafObject::numFlat of single records, and of those in runs.
    float NumFlatOfSingles() const { return static_cast<float>(_numFlatOfSingles); }
    float NumFlatOfRuns() const { return static_cast<float>(_numFlatOfRuns); }
    /// HDS_INSTANCE_* that some record has.
    std::uint32_t Flags() const { return _flags; }
    /// Whether some record has keys of motion.
    bool Moves() const { return _moves; }

    /// Records that belong to runs, and what holds their boxes when the shutter opens.
    std::uint32_t NumInRuns() const { return _numInRuns; }
    const Bounds& BoundsOfRuns() const { return _boundsOfRuns; }
    /// Those that do not, ascending.
    std::vector<std::uint32_t> Singles() const;
    /// Whether something else names the record by its place (PlacedRecord::worldInstance).
    bool IsWorldInstance(std::uint32_t record) const;
    /// The box of a record at rest, computed again. Not after Keep.
    Bounds BoxOf(std::uint32_t record) const;

    /// Boxes of the records at rest or when the shutter opens; and, when Moves(), as it closes.
    /// Moves them out, so it is called once.
    BoxesOfRecords TakeBoxes();

    /// A record of its own, which comes by PlacedRecord::worldInstance.
    struct World {
        std::uint32_t worldInstance;
        std::uint32_t record; ///< in the order of paths
        std::uint64_t pathOffset;
    };
    std::vector<World> WorldRecords() const;

    /// Writes records in the order of their places. \param order of each place its record, perhaps
    /// of some only. Not after Keep. \param motionKeys those of records that move are appended; may
    /// be null where none does.
    void Write(const std::vector<std::uint32_t>& order, shared::HdsInstance* places,
               std::vector<AffineRows>* motionKeys) const;

    /// Records and their boxes, in the order given. What an instance is made of lies far apart, and
    /// is looked up once for both. \param[out] places, boxes [count] \pre !Moves().
    void WriteWithBoxes(const std::uint32_t* records, std::uint32_t count,
                        shared::HdsInstance* places, Bounds* boxes) const;

    /// Makes the object independent of the scene: records and boxes can be had (WriteWithBoxes) for
    /// as long as one likes. Of singles they are kept as they are. \pre !Moves().
    void Keep();

private:
    /// Consecutive records: instances of a run, or single ones.
    struct Part {
        std::uint32_t first = 0; ///< record
        std::uint64_t firstLeaf = 0;
        std::optional<InstanceRun> run;   ///< nothing: singles from firstSingle on
        std::vector<std::uint32_t> ranks; ///< of the records, when some of the run were left out
        std::uint32_t firstSingle = 0;
    };
    /// A record, found again.
    struct Found {
        const LeafObject* leaf;
        MovingTransform groupFromObject;
        std::uint32_t flags;
        std::uint32_t count;
        std::uint32_t rank;
        std::uint64_t pathOffset;
    };

    const Part& PartOf(std::uint32_t record) const;
    /// Where a record is among the singles; nothing: it is in a run.
    std::optional<std::uint32_t> SingleOf(std::uint32_t record) const;
    Found Find(std::uint32_t record) const;
    /// Its GroupFromDevice at the frame.
    static glm::dmat4 DeviceTransform(const Found& found);
    /// What the device has of a record. \param transform its DeviceTransform
    static shared::HdsInstance RecordOf(const Found& found, const glm::dmat4& transform);
    MovingTransform TransformOf(const InstanceRun& run, std::int32_t instance) const;
    bool MayMove(const InstanceRun& run) const;
    void ComputeBoxes();
    void AddPart(Part part, std::uint32_t count, std::uint64_t numLeaves);
    void ReserveCloseBoxes();

    Shutter _shutter;
    bool _keepsBoxes;
    std::vector<Part> _parts;
    std::vector<std::shared_ptr<const InstancerPrim>> _kept; ///< of the runs, by Keep
    std::vector<PlacedRecord> _singles;                      ///< empty after Keep
    std::vector<shared::HdsInstance> _keptSingles;           ///< by Keep
    std::vector<Bounds> _keptBoxes;                          ///< of the same
    std::vector<Bounds> _boxes;                              ///< empty when they are not kept
    std::vector<Bounds> _closeBoxes;                         ///< empty while nothing may move
    Bounds _boundsOfRuns;
    std::uint32_t _size = 0;
    std::uint32_t _numInRuns = 0;
    std::uint64_t _numLeaves = 0;
    double _numPrimitives = 0.0;
    double _numFlatOfSingles = 0.0;
    double _numFlatOfRuns = 0.0;
    std::uint32_t _flags = 0;
    bool _mayMove = false;
    bool _moves = false;
};

/// The matrix of an instance, which may move.
MovingTransform InstanceTransform(const InstancerPrim& instancer, std::int32_t index,
                                  const Shutter& shutter);

} // namespace hds
