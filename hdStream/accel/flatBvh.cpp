// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/flatBvh.h"

#include "hdStream/accel/flatTree.h"

#include <tbb/parallel_for.h>

#include <cstring>
#include <map>
#include <utility>

namespace hds {
namespace {

/// HdsFlatNode.child of an instance.
std::uint32_t ChildOf(std::uint32_t record) {
    return HDS_FLAT_INSTANCE | ((record & HDS_RECORD_IN_CHUNK) != 0
                                    ? HDS_FLAT_IN_CHUNK | (record & ~HDS_RECORD_IN_CHUNK)
                                    : record);
}

class FlatBuilder {
public:
    FlatBuilder(const FlatSource& source, FlatPlaces places)
        : _source(source), _places(std::move(places)) {}

    FlatBvh Build() {
        FlatBvh flat;
        ListTrees();
        std::vector<std::uint8_t> isBuilt(_trees.size());
        tbb::parallel_for(std::size_t{0}, _trees.size(),
                          [&](std::size_t i) { isBuilt[i] = _trees[i].Build() ? 1 : 0; });
        for (const std::uint8_t is : isBuilt) {
            if (is == 0) {
                return flat; // nothing is there, or it would be too deep
            }
        }
        Write(&flat);
        for (const FlatTree& tree : _trees) {
            flat.numTriangles += tree.NumTriangles();
        }
        flat.numCopies = _places.copies.size();
        flat.hasInstances = !_places.instances.empty();
        return flat;
    }

private:
    /// That in world space, then those of meshes with copies.
    void ListTrees() {
        _trees.resize(1 + _places.meshes.size());
        for (std::uint32_t place = 0; place < _places.places.size(); ++place) {
            if (!_places.placements[place].isCopy) {
                _trees[0].AddMesh(_source, place, _places.placements[place]);
            }
        }
        for (const FlatCopy& copy : _places.copies) {
            _trees[0].AddBox({HDS_FLAT_COPY | copy.place, copy.bounds});
        }
        for (const FlatInstance& instance : _places.instances) {
            _trees[0].AddBox({ChildOf(instance.record), instance.bounds});
        }
        for (std::size_t i = 0; i < _places.meshes.size(); ++i) {
            _trees[1 + i].AddMesh(_source, 0, _places.meshes[i]);
        }
        if (_places.places.empty()) {
            _places.places.emplace_back(); // of the leaf of nothing
        }
    }

    /// Names the roots of meshes in the places of their copies. \param firstNodes of trees.
    void NameRoots(const std::vector<std::uint32_t>& firstNodes) {
        std::map<std::uint32_t, std::uint32_t> rootOf; // objects
        for (std::size_t i = 0; i < _places.meshes.size(); ++i) {
            rootOf[_places.meshes[i].object] = firstNodes[1 + i];
        }
        for (const FlatCopy& copy : _places.copies) {
            _places.places[copy.place].root = rootOf.at(_places.placements[copy.place].object);
        }
    }

    void Write(FlatBvh* flat) {
        std::vector<std::uint32_t> firstNodes;
        std::vector<std::uint32_t> firstLeaves; // added to numbers from 1 on
        std::size_t numNodes = 0;
        std::size_t numLeaves = 1; // that of nothing
        for (const FlatTree& tree : _trees) {
            firstNodes.push_back(static_cast<std::uint32_t>(numNodes));
            firstLeaves.push_back(static_cast<std::uint32_t>(numLeaves - 1));
            numNodes += tree.NumNodes();
            numLeaves += tree.NumLeaves() - 1;
        }
        NameRoots(firstNodes);
        std::uint64_t bytes = sizeof(shared::HdsFlatHeader);
        const auto place = [&](std::uint64_t partBytes) {
            const std::uint64_t offset = bytes;
            bytes +=
                (partBytes + HDS_FLAT_UNIT_BYTES - 1) / HDS_FLAT_UNIT_BYTES * HDS_FLAT_UNIT_BYTES;
            return static_cast<std::uint32_t>(offset / HDS_FLAT_UNIT_BYTES);
        };
        shared::HdsFlatHeader header{};
        place(numNodes * sizeof(shared::HdsFlatNode));
        header.leaves = place(numLeaves * sizeof(shared::HdsFlatLeaf));
        header.places = place(_places.places.size() * sizeof(_places.places[0]));
        header.transforms = place(_places.transforms.size() * sizeof(_places.transforms[0]));
        flat->buffer.resize(bytes);
        std::uint8_t* data = flat->buffer.data();
        std::memcpy(data, &header, sizeof(header));
        const auto part = [&](std::uint32_t offset) {
            return data + std::size_t{offset} * HDS_FLAT_UNIT_BYTES;
        };
        std::memcpy(part(header.places), _places.places.data(),
                    _places.places.size() * sizeof(_places.places[0]));
        std::memcpy(part(header.transforms), _places.transforms.data(),
                    _places.transforms.size() * sizeof(_places.transforms[0]));
        auto* nodes = reinterpret_cast<shared::HdsFlatNode*>(data + sizeof(header));
        auto* leaves = reinterpret_cast<shared::HdsFlatLeaf*>(part(header.leaves));
        leaves[0] = {};
        tbb::parallel_for(std::size_t{0}, _trees.size(), [&](std::size_t i) {
            _trees[i].WriteNodes(firstNodes[i], firstLeaves[i], nodes + firstNodes[i]);
            _trees[i].WriteLeaves(leaves + 1 + firstLeaves[i]);
        });
    }

    const FlatSource& _source;
    FlatPlaces _places;
    std::vector<FlatTree> _trees;
};

} // namespace

FlatBvh BuildFlatBvh(const FlatSource& source, const FlatAmount& amount) {
    return FlatBuilder(source, FindFlatPlaces(source, amount)).Build();
}

} // namespace hds
