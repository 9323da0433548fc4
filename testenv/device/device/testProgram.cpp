// SPDX-License-Identifier: Apache-2.0
// Programs: includes come once and name our files in errors; binaries are cached and verified.
#include "testenv/support/deviceFixture.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace hds::test {
namespace {

namespace fs = std::filesystem;

class ProgramTest : public DeviceFixture {};

std::size_t CountOf(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
        ++count;
    }
    return count;
}

TEST(KernelSource, AFileComesOnce) {
    const std::string text = "#include \"math/vector.clh\"\n#include "
                             "\"shared/geometry.h\"\n#include \"math/vector.clh\"\n";
    const std::string source = ExpandKernelSource("test.cl", &text);
    EXPECT_EQ(CountOf(source, "#define HDS_SHARED_COMPAT_H"), 1U);
    EXPECT_EQ(CountOf(source, "#line 1 \"math/vector.clh\""), 1U);
}

TEST(KernelSource, AConditionalIncludeHidesNothing) {
    // The first include is in a branch that is not taken; the second must still bring the file.
    const std::string text =
        "#if 0\n#include \"math/vector.clh\"\n#endif\n#include \"math/vector.clh\"\n";
    const std::string source = ExpandKernelSource("test.cl", &text);
    EXPECT_EQ(CountOf(source, "#line 1 \"math/vector.clh\""), 2U);
}

/// Lines of the text of a file, each time that it comes.
constexpr const char* kVectorLine = "Real vec_dot(Real3 a, Real3 b) {";

TEST(KernelSource, AWideBlockBringsItsFilesAgain) {
    const std::string text = "#include \"math/trig.clh\"\n"
                             "#if HDS_WIDE\n"
                             "#include \"math/wideBegin.clh\"\n"
                             "#include \"math/vector.clh\"\n"
                             "#include \"math/trig.clh\"\n"
                             "#include \"math/wideEnd.clh\"\n"
                             "#endif\n"
                             "#include \"math/vector.clh\"\n"
                             "#include \"math/lanes.clh\"\n";
    const std::string source = ExpandKernelSource("test.cl", &text);
    EXPECT_EQ(CountOf(source, kVectorLine), 2U);
    EXPECT_EQ(CountOf(source, "Real trig_atan2("), 2U);
    EXPECT_EQ(CountOf(source, "#line 1 \"math/lanes.clh\""), 1U) << "the block does not name it";
    EXPECT_EQ(CountOf(source, "#line 1 \"math/wideBegin.clh\""), 1U);
    EXPECT_EQ(CountOf(source, "#line 1 \"math/wideEnd.clh\""), 1U);
    const std::size_t begin = source.find("#line 1 \"math/wideBegin.clh\"");
    const std::size_t end = source.find("#line 1 \"math/wideEnd.clh\"");
    EXPECT_EQ(CountOf(source.substr(0, begin), kVectorLine), 1U);
    EXPECT_EQ(CountOf(source.substr(begin, end - begin), kVectorLine), 1U);
    EXPECT_LT(source.find("#line 4 \"test.cl\"", begin), source.find("Real trig_atan2(", begin));
}

TEST(KernelSource, AWideBlockBringsWhatNothingElseDoes) {
    const std::string text = "#include \"math/wideBegin.clh\"\n"
                             "#include \"math/vector.clh\"\n"
                             "#include \"math/wideEnd.clh\"\n"
                             "#include \"math/vector.clh\"\n";
    const std::string source = ExpandKernelSource("test.cl", &text);
    EXPECT_EQ(CountOf(source, kVectorLine), 2U) << "for one path it has not come before";
    EXPECT_EQ(CountOf(source, "#line 1 \"math/lanes.clh\""), 1U);
}

TEST(KernelSource, AMissingIncludeNamesBothFiles) {
    const std::string text = "#include \"no/such.clh\"\n";
    try {
        ExpandKernelSource("test.cl", &text);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("no/such.clh"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("test.cl"), std::string::npos);
    }
}

TEST(KernelSource, LinesOfTheWholeTextAreNamedByFile) {
    const std::string text = "int a;\n#include \"math/vector.clh\"\nint b;\n";
    const std::string source = ExpandKernelSource("test.cl", &text);
    const auto lineOf = [&](const std::string& part) {
        return 1 + std::count(source.begin(), source.begin() + source.find(part), '\n');
    };
    const std::string inside = std::to_string(lineOf(kVectorLine));
    const std::string after = std::to_string(lineOf("int b;"));
    const std::string named = NameKernelLines(
        "<kernel>:" + inside + ":9: error: x\n<kernel>:" + after + ":5: note: y\n", source);
    EXPECT_EQ(named.find("math/vector.clh:"), 0U) << named;
    EXPECT_NE(named.find(":9: error: x\ntest.cl:3:5: note: y\n"), std::string::npos) << named;
    EXPECT_EQ(NameKernelLines("<kernel>:999999:1: z", "int a;\n"), "<kernel>:1:1: z");
    EXPECT_EQ(NameKernelLines("test.cl:3: as it is", source), "test.cl:3: as it is");
}

TEST_F(ProgramTest, CompilerErrorsNameOurFileAndLine) {
    try {
        Build("#include \"math/vector.clh\"\nkernel void k(global int* x) {\n    x[0] = "
              "nonsense;\n}\n");
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("test.cl:3"), std::string::npos) << error.what();
    }
}

TEST_F(ProgramTest, BinariesAreCachedPerTextAndDefines) {
    const fs::path folder =
        fs::temp_directory_path() / ("hdsProgram-" + std::to_string(::getpid()));
    fs::remove_all(folder);
    Warnings warnings;
    Store store({folder.string()}, &warnings);
    const std::string text =
        "kernel void fill(global int* x) { x[get_global_id(0)] = HDS_ITEMS_PER_WORK_ITEM; }\n";
    const auto run = [&](const char* value, bool expectCached) {
        Program program(device, "test.cl", {{"HDS_ITEMS_PER_WORK_ITEM", value}}, &store, &text);
        EXPECT_EQ(program.IsFromCache(), expectCached) << value;
        Buffer out = Allocate(64 * sizeof(int));
        program.GetKernel("fill").Launch(64, out);
        EXPECT_EQ(Download<int>(out, 64), std::vector<int>(64, std::stoi(value)));
        program.SaveBinary(&store);
    };
    run("3", false);
    run("3", true);
    run("4", false);
    for (const auto& entry : fs::directory_iterator(folder)) { // corrupt all: rebuilt, not trusted
        fs::resize_file(entry.path(), fs::file_size(entry.path()) - 1);
    }
    run("3", false);
    run("3", true);
    fs::remove_all(folder);
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(ProgramTest, KernelsAreGivenAllArguments) {
    ::testing::FLAGS_gtest_death_test_style = "threadsafe"; // the driver has threads
    const auto program = Build("kernel void add(global int* x, int a, int b) {\n"
                               "    x[get_global_id(0)] = a + b;\n}\n",
                               {});
    const Buffer out = Allocate(64 * sizeof(int));
    const int five = 5;
    Kernel launched = program->GetKernel("add");
    EXPECT_DEATH(launched.Launch(64, out, five), "add is not given argument 2 of 3");
    EXPECT_DEATH(launched.Launch(64, out, five, five, five), "add takes 3 arguments");
    launched.Launch(64, out, five, five);
    EXPECT_DEATH(launched.Launch(64, out, five), "argument 2 of 3") << "it is of the launch before";
    Kernel set = program->GetKernel("add");
    set.SetBuffer(0, out);
    set.SetBytes(2, &five, sizeof(five));
    EXPECT_DEATH(set.Enqueue(64), "argument 1 of 3");
    EXPECT_DEATH(set.SetBytes(3, &five, sizeof(five)), "add takes 3 arguments");
    set.SetBytes(1, &five, sizeof(five));
    set.Enqueue(64);
    set.KeepFirst(1);
    EXPECT_DEATH(set.Launch(64, five), "argument 2 of 3");
    set.Launch(64, five, five);
    EXPECT_EQ(Download<int>(out, 64), std::vector<int>(64, 10));
}

TEST_F(ProgramTest, BuffersCopyWhatTheySay) {
    std::vector<int> values(1000);
    for (int i = 0; i < 1000; ++i) {
        values[static_cast<std::size_t>(i)] = i * i;
    }
    Buffer buffer = Upload(values);
    EXPECT_EQ(Download<int>(buffer, 1000), values);
    buffer.Fill(7, 400, 40);
    std::fill(values.begin() + 10, values.begin() + 110, 7);
    EXPECT_EQ(Download<int>(buffer, 1000), values);
    Buffer empty(device, "empty", 0);
    empty.Write(nullptr, 0);
    EXPECT_TRUE(empty.IsValid());
}

/// Also where the host reaches the buffer itself, without a command.
TEST_F(ProgramTest, CopiesAndFillsKeepTheOrderOfLaunches) {
    const auto program =
        Build("kernel void slow(global int* x, int turns) {\n"
              "    const uint i = (uint)get_global_id(0);\n"
              "    uint value = (uint)x[i];\n"
              "    for (int turn = 0; turn < turns; ++turn) value = value * 1664525u + 1u;\n"
              "    x[i] += value == 77u ? 2 : 1;\n"
              "}\n",
              {});
    Kernel slow = program->GetKernel("slow");
    Buffer buffer = Allocate(64 * sizeof(int));
    const int turns = 300'000;
    const std::vector<int> threes(64, 3);
    for (int round = 0; round < 3; ++round) {
        buffer.Fill(5, 64 * sizeof(int));
        slow.Launch(64, buffer, turns);
        EXPECT_EQ(Download<int>(buffer, 64), std::vector<int>(64, 6)) << "read too early";
        slow.Launch(64, buffer, turns);
        buffer.Write(threes.data(), 64 * sizeof(int));
        EXPECT_EQ(Download<int>(buffer, 64), threes) << "written too early";
        slow.Launch(64, buffer, turns);
        buffer.Fill(9, 64 * sizeof(int));
        slow.Launch(64, buffer, turns);
        buffer.WriteMany({{threes.data(), 4 * sizeof(int), 0}});
        EXPECT_EQ(Download<int>(buffer, 5), (std::vector<int>{3, 3, 3, 3, 10})) << "in order";
    }
}

TEST_F(ProgramTest, AnImpossibleAllocationNamesTheBuffer) {
    try {
        const Buffer buffer(device, "the giant", std::uint64_t{1} << 50U);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("the giant"), std::string::npos);
    }
}

TEST(DeviceChoice, AnUnknownNameIsAUsageError) {
    if (!SharedTestDevice()) {
        GTEST_SKIP() << "SKIPPED LOUDLY: no OpenCL device on this machine";
    }
    try {
        Device::Create("no such device");
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::Usage);
    }
}

} // namespace
} // namespace hds::test
