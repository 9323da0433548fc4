// SPDX-License-Identifier: Apache-2.0
// writeVdb OUT VOXEL_SIZE X Y Z NX NY NZ {NAME FLOATS_FILE}...: an OpenVDB file of grids of floats
// for tests. X Y Z: the least voxel; FLOATS_FILE: [nz][ny][nx] float32. Zeros are not stored. A
// NAME that ends in ":3" is a grid of vectors, of [nz][ny][nx][3], whose zeros are not stored
// either.
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

namespace {

/// Null: the file is too short.
template <typename Grid>
openvdb::GridBase::Ptr ReadGrid(const openvdb::CoordBBox& box, const char* path) {
    using Value = typename Grid::ValueType;
    openvdb::tools::Dense<Value, openvdb::tools::LayoutXYZ> dense(box);
    std::ifstream in(path, std::ios::binary);
    in.read(reinterpret_cast<char*>(dense.data()),
            static_cast<std::streamsize>(dense.valueCount() * sizeof(Value)));
    if (!in) {
        return nullptr;
    }
    const auto grid = Grid::create(openvdb::zeroVal<Value>());
    openvdb::tools::copyFromDense(dense, *grid, openvdb::zeroVal<Value>());
    return grid;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 11) {
        std::cerr << "usage: writeVdb OUT VOXEL_SIZE X Y Z NX NY NZ {NAME FLOATS_FILE}...\n";
        return 2;
    }
    openvdb::initialize();
    const openvdb::Coord first(std::atoi(argv[3]), std::atoi(argv[4]), std::atoi(argv[5]));
    const openvdb::Coord size(std::atoi(argv[6]), std::atoi(argv[7]), std::atoi(argv[8]));
    openvdb::GridPtrVec grids;
    const openvdb::CoordBBox box(first, first + size - openvdb::Coord(1));
    for (int i = 9; i + 1 < argc; i += 2) {
        const std::string name(argv[i]);
        const bool isVector = name.size() > 2 && name.substr(name.size() - 2) == ":3";
        const openvdb::GridBase::Ptr grid = isVector
                                                ? ReadGrid<openvdb::Vec3SGrid>(box, argv[i + 1])
                                                : ReadGrid<openvdb::FloatGrid>(box, argv[i + 1]);
        if (!grid) {
            std::cerr << argv[i + 1] << ": too few floats\n";
            return 1;
        }
        grid->setName(isVector ? name.substr(0, name.size() - 2) : name);
        grid->setGridClass(isVector ? openvdb::GRID_UNKNOWN : openvdb::GRID_FOG_VOLUME);
        grid->setTransform(openvdb::math::Transform::createLinearTransform(std::atof(argv[2])));
        grids.push_back(grid);
    }
    openvdb::io::File file(argv[1]);
    file.setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
    file.write(grids);
    return 0;
}
