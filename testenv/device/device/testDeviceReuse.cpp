// SPDX-License-Identifier: Apache-2.0
// A session that ends leaves its context and its programs to the next one of the process; two at
// once share nothing, and a store gets what it lacks as if nothing were kept.
#include "hdStream/device/openclHandles.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/sessionScene.h"

#include <unistd.h>

#include <filesystem>

namespace hds::test {
namespace {

namespace fs = std::filesystem;

const std::string kText = "kernel void fill(global int* x, int value) {\n"
                          "    x[get_global_id(0)] = value + HDS_ITEMS_PER_WORK_ITEM;\n}\n";

class DeviceReuse : public DeviceFixture {
protected:
    static inline int firstNumber = 0;

    void SetUp() override {
        DeviceFixture::SetUp();
        firstNumber += 100; // what a test before has built is kept, also when all are repeated
        if (!IsSkipped() && !HasFatalFailure() && !device->Properties().hasSlowBinaries) {
            GTEST_SKIP() << "of PoCL alone";
        }
    }

    std::shared_ptr<Device> Reuse() const { return Device::Reuse(device->Properties().name); }

    /// Of the program of a number that no other test has.
    static ProgramDefines Defines(int number) {
        return {{"HDS_ITEMS_PER_WORK_ITEM", std::to_string(firstNumber + number)}};
    }

    static bool Renders(Session* session, const Settings& settings) {
        try {
            session->Render(settings);
        } catch (const Error&) {
            return false;
        }
        return true;
    }

    /// Whether the program was there; it computes what it says.
    static bool IsThere(const std::shared_ptr<Device>& user, int number, Store* store = nullptr) {
        const Program program(user, "test.cl", Defines(number), store, &kText);
        const Buffer out(user, "out", 64 * sizeof(int));
        const int value = 100;
        program.GetKernel("fill").Launch(64, out, value);
        user->Finish();
        std::vector<int> values(64);
        out.Read(values.data(), values.size() * sizeof(int));
        EXPECT_EQ(values, std::vector<int>(64, value + firstNumber + number));
        return program.IsFromCache();
    }
};

TEST_F(DeviceReuse, ProgramsAreKeptWithinOneUsersTime) {
    const std::shared_ptr<Device> user = Reuse();
    EXPECT_FALSE(IsThere(user, 1));
    EXPECT_TRUE(IsThere(user, 1));
}

TEST_F(DeviceReuse, TheNextUserFindsProgramsButNoCounts) {
    cl_context context = nullptr;
    {
        const std::shared_ptr<Device> user = Reuse();
        context = user->GetHandles().context;
        EXPECT_FALSE(IsThere(user, 2));
        EXPECT_GE(user->PeakBytes(), 256U);
    }
    const std::shared_ptr<Device> next = Reuse();
    EXPECT_EQ(next->GetHandles().context, context);
    EXPECT_EQ(next->PeakBytes(), 0U);
    EXPECT_TRUE(next->IsIdle());
    EXPECT_TRUE(IsThere(next, 2));
    EXPECT_FALSE(IsThere(next, 3)) << "other options are another program";
}

TEST_F(DeviceReuse, ASessionThatHasMetAnErrorLeavesNothing) {
    Settings settings = MakeSettings();
    settings.device = device->Properties().name;
    for (const bool fails : {false, true}) {
        const int number = fails ? 9 : 8;
        EXPECT_FALSE(IsThere(Reuse(), number)) << "the session has its context next";
        {
            Session session;
            FillSession(&session);
            FailAllocation(fails ? 3 : -1);
            EXPECT_EQ(Renders(&session, settings), !fails);
            FailAllocation(-1);
        }
        EXPECT_EQ(IsThere(Reuse(), number), !fails);
    }
}

TEST_F(DeviceReuse, TwoAtOnceShareNothing) {
    const std::shared_ptr<Device> one = Reuse();
    const std::shared_ptr<Device> other = Reuse();
    EXPECT_NE(one->GetHandles().context, other->GetHandles().context);
    EXPECT_FALSE(IsThere(one, 4));
    EXPECT_FALSE(IsThere(other, 4));
}

TEST_F(DeviceReuse, AProgramInUseIsNobodyElses) {
    const std::shared_ptr<Device> user = Reuse();
    const Program held(user, "test.cl", Defines(5), nullptr, &kText);
    EXPECT_FALSE(IsThere(user, 5));
    EXPECT_TRUE(IsThere(user, 5));
}

TEST_F(DeviceReuse, AStoreGetsWhatItLacks) {
    const fs::path folder = fs::temp_directory_path() / ("hdsReuse-" + std::to_string(::getpid()));
    fs::remove_all(folder);
    Warnings warnings;
    Store store({folder.string()}, &warnings);
    const std::shared_ptr<Device> user = Reuse();
    const ProgramSource source =
        MakeProgramSource(user->Properties(), "test.cl", Defines(6), &kText);
    EXPECT_FALSE(IsThere(user, 6));
    EXPECT_FALSE(IsThere(user, 6, &store)) << "it is built, so that it can be saved";
    Program(user, source, &store).SaveBinary(&store);
    EXPECT_TRUE(Program::IsInStore(source, store));
    EXPECT_TRUE(IsThere(user, 6, &store));
    fs::remove_all(folder);
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(DeviceReuse, OthersKeepNothing) {
    EXPECT_FALSE(IsThere(device, 7));
    EXPECT_FALSE(IsThere(device, 7));
}

TEST_F(DeviceReuse, ThoseKeptLongestAgoAreLetGo) {
    KeptPrograms kept;
    std::vector<cl_program> programs;
    for (std::size_t i = 0; i <= KeptPrograms::kMostPrograms; ++i) {
        const char* text = kText.c_str();
        cl_int code = CL_SUCCESS;
        programs.push_back(
            clCreateProgramWithSource(device->GetHandles().context, 1, &text, nullptr, &code));
        ASSERT_EQ(code, CL_SUCCESS);
        kept.Keep(std::to_string(i), programs.back());
    }
    EXPECT_EQ(kept.Take("0"), nullptr);
    EXPECT_EQ(kept.Take("1"), programs[1]);
    EXPECT_EQ(kept.Take("1"), nullptr) << "it is the caller's";
    kept.Keep("1", programs[1]);
}

} // namespace
} // namespace hds::test
