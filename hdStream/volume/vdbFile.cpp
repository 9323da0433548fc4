// SPDX-License-Identifier: Apache-2.0
#include "hdStream/volume/vdbFile.h"

#include <glm/gtc/type_ptr.hpp>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <stdexcept>
#include <utility>

namespace hds {

namespace {

/// A file from an offset on, which is its position 0.
class RangeBuffer : public std::filebuf {
public:
    RangeBuffer(const std::string& file, std::uint64_t offset)
        : _first(static_cast<off_type>(offset)) {
        open(file, std::ios::in | std::ios::binary);
        std::filebuf::seekoff(_first, std::ios::beg, std::ios::in);
    }

protected:
    pos_type seekoff(off_type off, std::ios::seekdir way, std::ios::openmode which) override {
        const bool isAbsolute = way == std::ios::beg;
        const pos_type there = std::filebuf::seekoff(isAbsolute ? off + _first : off, way, which);
        return there == pos_type(off_type(-1)) ? there : there - _first;
    }
    pos_type seekpos(pos_type position, std::ios::openmode which) override {
        return seekoff(off_type(position), std::ios::beg, which);
    }

private:
    off_type _first;
};

/// What a file says, for a message: short, and of letters alone.
std::string Legible(std::string text) {
    constexpr std::size_t kMost = 200;
    text.resize(std::min(text.size(), kMost));
    for (char& letter : text) {
        letter = letter >= ' ' && letter <= '~' ? letter : '?';
    }
    return text;
}

/// Reads a grid of a file. The library's own readers of files do not notice where a file ends.
class GridReader : public openvdb::io::Archive {
public:
    /// \pre the stream throws at its end.
    explicit GridReader(std::istream* stream) : _stream(*stream) {
        readHeader(_stream);
        // What the header says goes with the stream to those that read its parts.
        openvdb::io::setStreamMetadataPtr(_stream, _metadata, false);
        setFormatVersion(_stream);
        setLibraryVersion(_stream);
        setDataCompression(_stream);
        openvdb::MetaMap().readMeta(_stream);
        _numGrids = readGridCount(_stream);
        _firstGrid = _stream.tellg();
    }

    /// The grid that is asked for, with its voxels. \throws std::exception when there is none.
    openvdb::GridBase::Ptr Find(const VdbRequest& request) {
        int number = 0;
        std::string names;
        const auto isIt = [&](const openvdb::io::GridDescriptor& descriptor) {
            names += (names.empty() ? "" : ", ") + Legible(descriptor.gridName());
            return descriptor.gridName() == request.gridName && number++ == request.gridIndex;
        };
        openvdb::io::GridDescriptor descriptor;
        const openvdb::GridBase::Ptr grid = FindFirst(isIt, &descriptor);
        if (!grid) {
            throw std::runtime_error("has no grid '" + request.gridName + "' of index " +
                                     std::to_string(request.gridIndex) + "; there are: " + names);
        }
        if (descriptor.isInstance()) { // another grid has its voxels
            const std::string parentName = descriptor.instanceParentName();
            const auto isParent = [&](const openvdb::io::GridDescriptor& other) {
                return other.uniqueName() == parentName && !other.isInstance();
            };
            const openvdb::GridBase::Ptr parent = FindFirst(isParent, &descriptor);
            if (!parent) {
                throw std::runtime_error("the grid shares the voxels of one that is not there");
            }
            grid->setTree(parent->baseTreePtr());
        }
        return grid;
    }

private:
    template <typename Predicate>
    openvdb::GridBase::Ptr FindFirst(const Predicate& isIt,
                                     openvdb::io::GridDescriptor* descriptor) {
        _stream.seekg(_firstGrid);
        for (std::int32_t i = 0; i < _numGrids; ++i) {
            const openvdb::GridBase::Ptr grid = descriptor->read(_stream);
            const bool isFound = isIt(*descriptor);
            if (isFound || !inputHasGridOffsets()) {
                if (inputHasGridOffsets()) {
                    descriptor->seekToGrid(_stream);
                }
                readGrid(grid, *descriptor, _stream);
            }
            if (isFound) {
                return grid;
            }
            if (inputHasGridOffsets()) {
                descriptor->seekToEnd(_stream);
            }
        }
        return nullptr;
    }

    std::istream& _stream;
    openvdb::io::StreamMetadata::Ptr _metadata = std::make_shared<openvdb::io::StreamMetadata>();
    std::int32_t _numGrids = 0;
    std::streampos _firstGrid;
};

/// \throws std::exception when it cannot be read.
openvdb::GridBase::Ptr ReadGrid(const VdbRequest& request) {
    static std::once_flag isReady;
    std::call_once(isReady, openvdb::initialize);
    std::error_code code;
    const auto status = std::filesystem::status(request.file, code);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
        throw std::runtime_error("is not a file"); // opening a pipe would wait for its writer
    }
    RangeBuffer buffer(request.file, request.offset);
    if (!buffer.is_open()) {
        throw std::runtime_error("cannot be opened");
    }
    std::istream stream(&buffer);
    stream.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
    try {
        return GridReader(&stream).Find(request);
    } catch (const std::ios::failure&) {
        throw std::runtime_error("ends too early, or cannot be read");
    }
}

glm::ivec3 ToVector(const openvdb::Coord& coord) {
    return {coord.x(), coord.y(), coord.z()};
}

/// Which numbers are taken out of values of any type.
struct Component {
    int number = 0;
    double sign = 1.0;

    template <typename Value>
    float Of(const Value& value) const {
        if constexpr (openvdb::VecTraits<Value>::IsVec) {
            return VoxelValue(sign * static_cast<double>(value[number]));
        } else {
            return VoxelValue(sign * static_cast<double>(value));
        }
    }
};

/// Takes a leaf node over: OpenVDB has z fastest. Voxels that are not active stay 0.
template <typename Leaf>
void AddLeaf(const Leaf& leaf, Component component, VoxelGrid* grid) {
    VoxelBrick* brick = grid->AddBrick(grid->CellOf(ToVector(leaf.origin())));
    for (auto value = leaf.cbeginValueOn(); value; ++value) {
        const openvdb::Coord at = Leaf::offsetToLocalCoord(value.pos());
        (*brick)[(at.z() * HDS_BRICK_VOXELS + at.y()) * HDS_BRICK_VOXELS + at.x()] =
            component.Of(*value);
    }
}

/// One component of a grid.
template <typename Grid>
VoxelGrid TakeOver(const Grid& grid, Component component) {
    using Leaf = typename Grid::TreeType::LeafNodeType;
    static_assert(Leaf::DIM == HDS_BRICK_VOXELS, "leaf nodes are bricks");
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    if (box.empty()) {
        throw std::runtime_error("the grid has no active voxels");
    }
    // Both have row vectors' matrices row by row, which are columns to glm.
    glm::dmat4 placement;
    const openvdb::math::Mat4d map = grid.transform().baseMap()->getAffineMap()->getMat4();
    std::copy_n(map.asPointer(), 16, glm::value_ptr(placement));
    const glm::dvec3 first(ToVector(box.min()));
    VoxelGrid result(first, glm::dvec3(ToVector(box.max())) - first + 1.0, placement);
    result.bricks.reserve(grid.tree().leafCount());
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        if (!leaf->isEmpty()) {
            AddLeaf(*leaf, component, &result);
        }
    }
    auto tile = grid.tree().cbeginValueOn(); // voxels of leaf nodes are one level further down
    tile.setMaxDepth(tile.getLeafDepth() - 1);
    for (; tile; ++tile) {
        const openvdb::CoordBBox tileBox = tile.getBoundingBox();
        const glm::ivec3 end = ToVector(tileBox.max());
        for (glm::ivec3 at = ToVector(tileBox.min()); at.z <= end.z; at.z += HDS_BRICK_VOXELS) {
            for (at.y = tileBox.min().y(); at.y <= end.y; at.y += HDS_BRICK_VOXELS) {
                for (at.x = tileBox.min().x(); at.x <= end.x; at.x += HDS_BRICK_VOXELS) {
                    result.cells[result.CellOf(at)].value = component.Of(*tile);
                }
            }
        }
    }
    return result;
}

template <typename Grid>
bool TryType(const openvdb::GridBase::Ptr& grid, int numComponents, double sign,
             std::vector<VoxelGrid>* result) {
    const auto typed = openvdb::gridPtrCast<Grid>(grid);
    for (int component = 0; typed && component < numComponents; ++component) {
        result->push_back(TakeOver(*typed, Component{component, sign}));
    }
    return typed != nullptr;
}

} // namespace

std::vector<VoxelGrid> ReadVdb(const VdbRequest& request, std::string* error) {
    std::vector<VoxelGrid> result;
    try {
        const openvdb::GridBase::Ptr grid = ReadGrid(request);
        if (grid->getGridClass() == openvdb::GRID_LEVEL_SET) {
            throw std::runtime_error("the grid is a level set, no fog volume");
        }
        const double sign = request.isNegated ? -1.0 : 1.0;
        const bool isRead = TryType<openvdb::FloatGrid>(grid, 1, sign, &result) ||
                            TryType<openvdb::DoubleGrid>(grid, 1, sign, &result) ||
                            TryType<openvdb::Int32Grid>(grid, 1, sign, &result) ||
                            TryType<openvdb::Vec3SGrid>(grid, 3, sign, &result) ||
                            TryType<openvdb::Vec3DGrid>(grid, 3, sign, &result);
        if (!isRead) {
            throw std::runtime_error("grids of the type " + grid->valueType() + " are not drawn");
        }
    } catch (const openvdb::Exception& problem) {
        *error = request.file + ": " + Legible(problem.what());
        result.clear();
    } catch (const std::exception& problem) {
        *error = request.file + ": " + problem.what();
        result.clear();
    }
    return result;
}

} // namespace hds
