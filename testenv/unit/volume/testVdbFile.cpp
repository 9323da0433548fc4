// SPDX-License-Identifier: Apache-2.0
// Grids of OpenVDB files that the library itself has written, read back.
#include "hdStream/volume/vdbFile.h"

#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace hds::test {
namespace {

class VdbFile : public ::testing::Test {
protected:
    void SetUp() override { openvdb::initialize(); }

    std::string Write(const openvdb::GridPtrVec& grids) {
        const std::string path = _folder.Path() + "/grids.vdb";
        openvdb::io::File(path).write(grids);
        return path;
    }

    TemporaryFolder _folder;
};

template <typename Grid>
typename Grid::Ptr MakeGrid(const std::string& name, typename Grid::ValueType value) {
    const auto grid = Grid::create(typename Grid::ValueType(0));
    grid->setName(name);
    grid->tree().setValue(openvdb::Coord(-3, 5, 2), value);
    grid->tree().setValue(openvdb::Coord(1, 6, 4), value + value);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    grid->transform().postTranslate({10.0, 0.0, 0.0});
    return grid;
}

TEST_F(VdbFile, HasVoxelsWhereTheyAre) {
    const std::string path = Write({MakeGrid<openvdb::FloatGrid>("density", 1.5F),
                                    MakeGrid<openvdb::DoubleGrid>("heat", 3.0)});
    for (const auto& [name, value] : {std::pair("density", 1.5F), std::pair("heat", 3.0F)}) {
        std::string error;
        const auto grids = ReadVdb({path, 0, name, 0}, &error);
        ASSERT_EQ(grids.size(), 1U) << error;
        EXPECT_EQ(grids[0].first, glm::ivec3(-3, 5, 2));
        EXPECT_EQ(grids[0].size, glm::ivec3(5, 2, 3));
        EXPECT_EQ(grids[0].ValueAt({-3, 5, 2}), value);
        EXPECT_EQ(grids[0].ValueAt({-2, 5, 2}), 0.0F);
        EXPECT_EQ(grids[0].ValueAt({1, 6, 4}), 2.0F * value);
        const glm::dvec4 there = grids[0].objectFromIndex * glm::dvec4(2.0, 4.0, 6.0, 1.0);
        EXPECT_EQ(there, glm::dvec4(11.0, 2.0, 3.0, 1.0));
    }
}

TEST_F(VdbFile, HasTilesAndWhatIsNotActiveIsZero) {
    const auto grid = openvdb::FloatGrid::create(7.0F);
    grid->setName("density");
    grid->fill(openvdb::CoordBBox({0, 0, 0}, {63, 31, 15}), 2.0F);
    grid->tree().setValueOn(openvdb::Coord(70, 5, 5), -1.0F);
    grid->tree().setValueOn(openvdb::Coord(70, 5, 6), 3.0F);
    std::string error;
    const auto grids = ReadVdb({Write({grid}), 0, "density", 0}, &error);
    ASSERT_EQ(grids.size(), 1U) << error;
    EXPECT_EQ(grids[0].size, glm::ivec3(71, 32, 16));
    for (const glm::ivec3 voxel : {glm::ivec3(0), glm::ivec3(63, 31, 15), glm::ivec3(9, 17, 3)}) {
        EXPECT_EQ(grids[0].ValueAt(voxel), 2.0F);
    }
    EXPECT_EQ(grids[0].ValueAt({64, 0, 0}), 0.0F);
    EXPECT_EQ(grids[0].ValueAt({70, 5, 4}), 0.0F); // of the background, and not active
    EXPECT_EQ(grids[0].ValueAt({70, 5, 5}), 0.0F); // below 0
    EXPECT_EQ(grids[0].ValueAt({70, 5, 6}), 3.0F);
}

TEST_F(VdbFile, HasThreeGridsOfVectors) {
    std::string error;
    const auto grids = ReadVdb(
        {Write({MakeGrid<openvdb::Vec3SGrid>("Cd", {1.0F, 2.0F, 3.0F})}), 0, "Cd", 0}, &error);
    ASSERT_EQ(grids.size(), 3U) << error;
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(grids[i].ValueAt({-3, 5, 2}), static_cast<float>(i + 1));
    }
}

TEST_F(VdbFile, CountsGridsOfOneName) {
    const auto first = MakeGrid<openvdb::FloatGrid>("density", 1.0F);
    const auto other = MakeGrid<openvdb::FloatGrid>("other", 3.0F);
    const auto second = MakeGrid<openvdb::FloatGrid>("density", 2.0F);
    const std::string path = Write({first, other, second});
    for (int index = 0; index < 2; ++index) {
        std::string error;
        const auto grids = ReadVdb({path, 0, "density", index}, &error);
        ASSERT_EQ(grids.size(), 1U) << error;
        EXPECT_EQ(grids[0].ValueAt({-3, 5, 2}), static_cast<float>(index + 1));
    }
}

TEST_F(VdbFile, HasGridsThatShareVoxels) {
    const auto grid = MakeGrid<openvdb::FloatGrid>("density", 1.0F);
    const auto same = grid->copy();
    same->setName("same");
    std::string error;
    const auto grids = ReadVdb({Write({grid, same}), 0, "same", 0}, &error);
    ASSERT_EQ(grids.size(), 1U) << error;
    EXPECT_EQ(grids[0].ValueAt({1, 6, 4}), 2.0F);
}

TEST_F(VdbFile, MayHaveNoOffsets) {
    const std::string path = _folder.Path() + "/stream.vdb";
    {
        std::ofstream out(path, std::ios::binary);
        openvdb::io::Stream(out).write(
            openvdb::GridPtrVec{MakeGrid<openvdb::FloatGrid>("heat", 3.0F),
                                MakeGrid<openvdb::FloatGrid>("density", 2.0F)});
    }
    std::string error;
    const auto grids = ReadVdb({path, 0, "density", 0}, &error);
    ASSERT_EQ(grids.size(), 1U) << error;
    EXPECT_EQ(grids[0].ValueAt({-3, 5, 2}), 2.0F);
}

TEST_F(VdbFile, IsReadInsideOfAPackage) {
    std::ifstream in(Write({MakeGrid<openvdb::FloatGrid>("density", 1.0F)}), std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    const std::string package = _folder.Path() + "/package";
    std::ofstream(package, std::ios::binary) << std::string(64, 'x') << bytes;
    std::string error;
    EXPECT_EQ(ReadVdb({package, 64, "density", 0}, &error).size(), 1U) << error;
}

TEST_F(VdbFile, SaysWhatIsWrong) {
    const auto errorOf = [](const VdbRequest& request) {
        std::string error;
        EXPECT_TRUE(ReadVdb(request, &error).empty());
        return error;
    };
    const auto levelSet = MakeGrid<openvdb::FloatGrid>("surface", 1.0F);
    levelSet->setGridClass(openvdb::GRID_LEVEL_SET);
    const auto wide = MakeGrid<openvdb::FloatGrid>("wide", 1.0F);
    wide->tree().setValue(openvdb::Coord(1 << 16, 1 << 16, 1 << 16), 1.0F);
    const auto far = MakeGrid<openvdb::FloatGrid>("far", 1.0F);
    far->tree().setValue(openvdb::Coord(1 << 30, 1, 1), 1.0F);
    const auto empty = openvdb::FloatGrid::create();
    empty->setName("empty");
    const std::string path =
        Write({levelSet, wide, far, empty, MakeGrid<openvdb::BoolGrid>("mask", true)});
    EXPECT_NE(errorOf({path, 0, "surface", 0}).find("level set"), std::string::npos);
    EXPECT_NE(errorOf({path, 0, "wide", 0}).find("2^35"), std::string::npos);
    EXPECT_NE(errorOf({path, 0, "far", 0}).find("2^20"), std::string::npos);
    EXPECT_NE(errorOf({path, 0, "empty", 0}).find("no active voxels"), std::string::npos);
    EXPECT_NE(errorOf({path, 0, "mask", 0}).find("bool"), std::string::npos);
    EXPECT_NE(errorOf({path, 0, "smoke", 0}).find("there are: "), std::string::npos);
    EXPECT_NE(errorOf({path, 0, "wide", 1}).find("index 1"), std::string::npos);
    EXPECT_NE(errorOf({"/nowhere.vdb", 0, "wide", 0}).find("cannot be opened"), std::string::npos);
    const std::string pipe = _folder.File("pipe.vdb"); // nobody writes into it
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_NE(errorOf({pipe, 0, "wide", 0}).find("is not a file"), std::string::npos);
}

TEST_F(VdbFile, IsNamedInLettersWhateverItsGridsAreCalled) {
    const std::string path = Write({MakeGrid<openvdb::FloatGrid>("smo\n\xff\x9dke", 1.0F)});
    std::string error;
    EXPECT_TRUE(ReadVdb({path, 0, "density", 0}, &error).empty());
    EXPECT_NE(error.find("there are: smo???ke"), std::string::npos) << error;
}

TEST_F(VdbFile, MayBeCutOff) {
    const std::string path = Write({MakeGrid<openvdb::FloatGrid>("density", 1.0F)});
    const auto size = std::filesystem::file_size(path);
    for (std::uintmax_t left = 0; left < size; left += 7) {
        std::filesystem::resize_file(path, size - 1 - left);
        std::string error;
        EXPECT_TRUE(ReadVdb({path, 0, "density", 0}, &error).empty()) << left;
        EXPECT_FALSE(error.empty());
    }
}

} // namespace
} // namespace hds::test
