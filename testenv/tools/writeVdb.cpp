// SPDX-License-Identifier: Apache-2.0
// writeVdb OUT VOXEL_SIZE X Y Z NX NY NZ {NAME FLOATS_FILE}...: an OpenVDB file of grids of floats
// for tests. X Y Z: the least voxel; FLOATS_FILE: [nz][ny][nx] float32. Zeros are not stored.
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <vector>

int main(int argc, char** argv) {
    if (argc < 11) {
        std::cerr << "usage: writeVdb OUT VOXEL_SIZE X Y Z NX NY NZ {NAME FLOATS_FILE}...\n";
        return 2;
    }
    openvdb::initialize();
    const openvdb::Coord first(std::atoi(argv[3]), std::atoi(argv[4]), std::atoi(argv[5]));
    const openvdb::Coord size(std::atoi(argv[6]), std::atoi(argv[7]), std::atoi(argv[8]));
    openvdb::GridPtrVec grids;
    for (int i = 9; i + 1 < argc; i += 2) {
        openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(
            openvdb::CoordBBox(first, first + size - openvdb::Coord(1)));
        std::ifstream in(argv[i + 1], std::ios::binary);
        in.read(reinterpret_cast<char*>(dense.data()),
                static_cast<std::streamsize>(dense.valueCount() * sizeof(float)));
        if (!in) {
            std::cerr << argv[i + 1] << ": too few floats\n";
            return 1;
        }
        const auto grid = openvdb::FloatGrid::create(0.0F);
        openvdb::tools::copyFromDense(dense, *grid, 0.0F);
        grid->setName(argv[i]);
        grid->setGridClass(openvdb::GRID_FOG_VOLUME);
        grid->setTransform(openvdb::math::Transform::createLinearTransform(std::atof(argv[2])));
        grids.push_back(grid);
    }
    openvdb::io::File file(argv[1]);
    file.setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
    file.write(grids);
    return 0;
}
