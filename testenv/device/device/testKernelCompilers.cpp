// SPDX-License-Identifier: Apache-2.0
// Processes that compile: binaries are those of this process, and whatever becomes of such a
// process, who asks for a program gets it, and no process stays behind.
#include "hdStream/device/compileProtocol.h"
#include "hdStream/device/kernelCompilers.h"
#include "hdStream/device/kernelSource.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/temporaryFolder.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <fstream>

extern char** environ;

namespace hds::test {
namespace {

/// What a compiler sends first: magic, kind, nothing more.
constexpr const char* kSaysReady = R"(printf 'hdsComp1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0'; )";

class KernelCompilersTest : public CpuDeviceFixture {
protected:
    ProgramSource Source(const std::string& value) {
        const std::string text =
            "kernel void fill(global int* x) { x[get_global_id(0)] = " + value + "; }\n";
        return MakeProgramSource(device->Properties(), "test.cl", {}, &text);
    }

    /// A program in the place of the compiler.
    std::string Script(const std::string& lines) {
        const std::string path = folder.File("compiler");
        WriteFile(path, "#!/bin/sh\n" + lines + "\n");
        std::filesystem::permissions(path, std::filesystem::perms::owner_all);
        return path;
    }

    KernelCompilers& Use(const std::string& executable, int patience = 60000) {
        KernelCompilersOptions options;
        options.executable = executable;
        options.mostProcesses = 2;
        options.patience = std::chrono::milliseconds(patience);
        device->SetCompilers(
            std::make_unique<KernelCompilers>(device->Properties(), &store, &warnings, options));
        return *device->Compilers();
    }

    /// What a kernel of the program writes.
    int Result(const ProgramSource& source) {
        Program program(device, source, &store);
        Buffer out = Allocate(64 * sizeof(int));
        program.GetKernel("fill").Launch(64, out);
        return Download<int>(out, 64)[63];
    }

    /// Programs are there though their compiler is of no use; it is said once.
    void ExpectFallback(const std::string& executable, const std::string& reason,
                        int patience = 60000) {
        const std::vector<ProgramSource> sources = {Source("3"), Source("4"), Source("5")};
        Use(executable, patience);
        Program::Announce(*device, sources, &store);
        for (std::size_t i = 0; i < sources.size(); ++i) {
            EXPECT_EQ(Result(sources[i]), static_cast<int>(i) + 3);
        }
        EXPECT_FALSE(device->Compilers()->CanCompile());
        device->SetCompilers(nullptr);
        ASSERT_EQ(warnings.Lines().size(), 1U);
        EXPECT_EQ(warnings.Lines()[0], executable + ": " + reason +
                                           "; kernels are compiled without it, which takes longer");
        ExpectNoChild();
    }

    void ExpectNoChild() {
        EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
        EXPECT_EQ(errno, ECHILD);
    }

    void TearDown() override {
        if (device) {
            device->SetCompilers(nullptr);
        }
    }

    TemporaryFolder folder;
    Warnings warnings;
    Store store{{folder.File("store")}, &warnings};
};

TEST_F(KernelCompilersTest, TheProgramIsBesideThisOne) {
    EXPECT_EQ(std::filesystem::path(KernelCompilers::DefaultExecutable()).filename(),
              "hdstreamCompileKernels");
}

TEST_F(KernelCompilersTest, BinariesAreKeptAndNothingIsCompiledHere) {
    const std::vector<ProgramSource> sources = {Source("3"), Source("4"), Source("5")};
    Use("");
    Program::Announce(*device, sources, &store);
    for (std::size_t i = 0; i < sources.size(); ++i) {
        EXPECT_EQ(Result(sources[i]), static_cast<int>(i) + 3);
    }
    device->SetCompilers(nullptr);
    for (const ProgramSource& source : sources) {
        EXPECT_TRUE(Program::IsInStore(source, store));
        EXPECT_TRUE(Program(device, source, &store).IsFromCache());
    }
    EXPECT_TRUE(warnings.Lines().empty());
    ExpectNoChild();
}

TEST_F(KernelCompilersTest, ACompilerThatWasStartedEarlyWaits) {
    KernelCompilers& compilers = Use("");
    compilers.Warm();
    compilers.Begin({Source("3")});
    EXPECT_FALSE(compilers.Take(Source("3").key).empty());
    compilers.Rest();
    compilers.Begin({Source("4")});
    EXPECT_FALSE(compilers.Take(Source("4").key).empty()) << "also after a rest";
    EXPECT_TRUE(compilers.Take(Source("4").key).empty()) << "once";
    EXPECT_TRUE(compilers.Take(Source("5").key).empty()) << "was not begun";
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(KernelCompilersTest, AProgramThatDoesNotCompileIsTheAskersError) {
    const std::string text = "kernel void k(global int* x) {\n    x[0] = nonsense;\n}\n";
    const ProgramSource wrong = MakeProgramSource(device->Properties(), "test.cl", {}, &text);
    Use("");
    Program::Announce(*device, {wrong, Source("3")}, &store);
    try {
        Program(device, wrong, &store);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("test.cl:2"), std::string::npos) << error.what();
    }
    EXPECT_EQ(Result(Source("3")), 3);
    EXPECT_TRUE(device->Compilers()->CanCompile());
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(KernelCompilersTest, WithoutTheProgram) {
    ExpectFallback("/nowhere/compiler", "it cannot be started: No such file or directory");
}

TEST_F(KernelCompilersTest, OneThatEndsAtOnce) {
    ExpectFallback(Script("exit 3"), "it does not answer as it should");
}

TEST_F(KernelCompilersTest, OneThatAnswersNonsense) {
    ExpectFallback(Script("echo no compiler answers in so many words; sleep 1000"),
                   "it does not answer as it should");
}

TEST_F(KernelCompilersTest, OneThatEndsWhileItCompiles) {
    ExpectFallback(Script(std::string(kSaysReady) + "head -c 100 > /dev/null; kill -9 $$"),
                   "it ended or hangs while it compiles test.cl");
}

TEST_F(KernelCompilersTest, OneThatHangs) {
    ExpectFallback(Script(std::string(kSaysReady) + "exec sleep 1000"),
                   "it ended or hangs while it compiles test.cl", 300);
}

/// As on a machine under load: it takes longer than anybody waits, but not of its own time.
TEST_F(KernelCompilersTest, OneThatIsSlowIsWaitedFor) {
    const std::string computes = "i=0; while [ $i -lt 30000 ]; do i=$((i + 1)); done; sleep 1; ";
    const std::string saysNotBuilt =
        "printf 'hdsComp1\\3\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0'; ";
    KernelCompilers& compilers =
        Use(Script(kSaysReady + computes + computes + computes + saysNotBuilt + "exec sleep 1000"),
            1500);
    compilers.Begin({Source("3")});
    EXPECT_TRUE(compilers.Take(Source("3").key).empty());
    EXPECT_TRUE(compilers.CanCompile());
    device->SetCompilers(nullptr);
    EXPECT_TRUE(warnings.Lines().empty());
    ExpectNoChild();
}

TEST_F(KernelCompilersTest, OneThatComputesForEver) {
    ExpectFallback(Script(std::string(kSaysReady) + "while :; do :; done"),
                   "it ended or hangs while it compiles test.cl", 300);
}

/// As on a machine under load: each of two processes fails with another program.
TEST_F(KernelCompilersTest, SeveralThatHangAreOneLine) {
    std::vector<ProgramSource> sources;
    for (const char* root : {"one.cl", "other.cl"}) {
        const std::string text = std::string("kernel void fill() {} // ") + root + "\n";
        sources.push_back(MakeProgramSource(device->Properties(), root, {}, &text));
    }
    KernelCompilers& compilers = Use(Script(std::string(kSaysReady) + "exec sleep 1000"), 300);
    compilers.Begin(sources);
    for (const ProgramSource& source : sources) {
        EXPECT_TRUE(compilers.Take(source.key).empty());
    }
    compilers.Begin({Source("3")});
    EXPECT_TRUE(compilers.Take(Source("3").key).empty()) << "it is given up when both have ended";
    device->SetCompilers(nullptr);
    EXPECT_EQ(warnings.Lines().size(), 1U);
    ExpectNoChild();
}

TEST_F(KernelCompilersTest, OneWhoseBinaryTheDeviceRejects) {
    // Kind 2 is a binary; 7 bytes follow.
    Use(Script(std::string(kSaysReady) +
               R"(printf 'hdsComp1\2\0\0\0\0\0\0\0\7\0\0\0\0\0\0\0garbage'; exec sleep 1000)"));
    Program::Announce(*device, {Source("3")}, &store);
    EXPECT_EQ(Result(Source("3")), 3);
    EXPECT_EQ(Result(Source("3")), 3) << "what is in the store is garbage";
}

TEST_F(KernelCompilersTest, AStoreThatCannotBeWrittenWarnsAndBinariesAreUsed) {
    WriteFile(folder.File("store"), "a file in the folder's place");
    KernelCompilers& compilers = Use("");
    compilers.Begin({Source("3")});
    EXPECT_FALSE(compilers.Take(Source("3").key).empty());
    ASSERT_EQ(warnings.Lines().size(), 1U);
    EXPECT_NE(warnings.Lines()[0].find("nothing more is kept in the cache"), std::string::npos);
    EXPECT_FALSE(compilers.CanCompile()) << "nothing would be kept";
    EXPECT_EQ(Result(Source("4")), 4);
}

TEST_F(KernelCompilersTest, AStoreThatIsSwitchedOffHasNoCompilers) {
    Store off{{folder.File("off"), false}, &warnings};
    device->SetCompilers(std::make_unique<KernelCompilers>(device->Properties(), &off, &warnings));
    EXPECT_FALSE(device->Compilers()->CanCompile());
}

TEST_F(KernelCompilersTest, WhoeverDoesNotWaitEndsThem) {
    Use(Script(std::string(kSaysReady) + "exec sleep 1000")).Begin({Source("3"), Source("4")});
    device->SetCompilers(nullptr);
    ExpectNoChild();
    Use("").Begin({Source("3"), Source("4")});
    device->SetCompilers(nullptr);
    ExpectNoChild();
    EXPECT_TRUE(warnings.Lines().empty()) << "it is no failure";
}

TEST_F(KernelCompilersTest, ProcessesInheritNothing) {
    const int inherited = ::open("/dev/null", O_RDONLY); // not close-on-exec
    ASSERT_GE(inherited, 3);
    // The shell itself has the script open as 10, or as 255.
    Use(Script("for f in /proc/self/fd/*; do [ -e $f ] && echo $f; done > " + folder.File("fds") +
               "; readlink /proc/self/fd/" + std::to_string(inherited) + " >> " +
               folder.File("fds")));
    device->Compilers()->Begin({Source("3")});
    EXPECT_TRUE(device->Compilers()->Take(Source("3").key).empty());
    const std::string seen = ReadFile(folder.File("fds"));
    EXPECT_NE(seen.find("/fd/0\n"), std::string::npos);
    EXPECT_EQ(seen.find("/dev/null"), std::string::npos) << seen;
    ::close(inherited);
}

/// The program itself, started with one end of a socket.
class CompilerProcess {
public:
    explicit CompilerProcess(bool hasSocket) {
        int ends[2];
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        if (hasSocket) {
            posix_spawn_file_actions_adddup2(&actions, ends[1], 0);
        } else {
            posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
            posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
        }
        std::string name = KernelCompilers::DefaultExecutable();
        char* const arguments[] = {name.data(), nullptr};
        EXPECT_EQ(::posix_spawn(&_id, name.c_str(), &actions, nullptr, arguments, environ), 0);
        posix_spawn_file_actions_destroy(&actions);
        ::close(ends[1]);
        socket = ends[0];
    }
    int ExitCode() {
        int status = 0;
        EXPECT_EQ(::waitpid(_id, &status, 0), _id);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    bool IsReady() {
        CompileMessage kind{};
        std::string payload;
        return ReceiveMessage(socket, &kind, &payload) && kind == CompileMessage::Ready;
    }
    int socket = -1;

private:
    pid_t _id = -1;
};

TEST_F(KernelCompilersTest, ACompilerEndsWithWhoStartedIt) {
    CompilerProcess idle(true);
    EXPECT_TRUE(idle.IsReady());
    ::close(idle.socket); // as the system does when a process is gone
    EXPECT_EQ(idle.ExitCode(), 0);
    CompilerProcess busy(true);
    EXPECT_TRUE(busy.IsReady());
    const std::string request = PackRequest(
        device->Properties(), MakeProgramSource(device->Properties(), "integrator/shade.cl", {}));
    EXPECT_TRUE(SendMessage(busy.socket, CompileMessage::Compile, request.data(), request.size()));
    ::close(busy.socket);
    EXPECT_EQ(busy.ExitCode(), 0);
}

TEST_F(KernelCompilersTest, ACompilerSaysWhyItEnds) {
    CompilerProcess asked(true);
    EXPECT_TRUE(asked.IsReady());
    EXPECT_TRUE(SendMessage(asked.socket, CompileMessage::Compile, "x", 1));
    EXPECT_EQ(asked.ExitCode(), 1);
    ::close(asked.socket);
    CompilerProcess byHand(false);
    EXPECT_EQ(byHand.ExitCode(), 2);
    ::close(byHand.socket);
}

TEST_F(KernelCompilersTest, AnotherDeviceIsNotBuiltFor) {
    CompilerProcess compiler(true);
    EXPECT_TRUE(compiler.IsReady());
    DeviceProperties other = device->Properties();
    other.driverVersion += " of tomorrow";
    const std::string request = PackRequest(other, Source("3"));
    EXPECT_TRUE(
        SendMessage(compiler.socket, CompileMessage::Compile, request.data(), request.size()));
    CompileMessage kind{};
    std::string payload;
    EXPECT_TRUE(ReceiveMessage(compiler.socket, &kind, &payload));
    EXPECT_EQ(kind, CompileMessage::NotBuilt);
    EXPECT_NE(payload.find("no OpenCL device"), std::string::npos);
    ::close(compiler.socket);
    EXPECT_EQ(compiler.ExitCode(), 0);
}

TEST(ProgramSource, OptionsAreThoseThatTheTextNames) {
    const DeviceProperties device;
    const std::string text = "#if HDS_FEATURE_GROUPS && HDS_FEATURE_CURVES_TOO\n#endif\n";
    const auto source = [&](const char* groups, const char* curves) {
        return MakeProgramSource(device, "test.cl",
                                 {{"HDS_FEATURE_GROUPS", groups}, {"HDS_FEATURE_CURVES", curves}},
                                 &text);
    };
    EXPECT_EQ(source("0", "0").options, "-cl-std=CL1.2 -DHDS_FEATURE_GROUPS=0");
    EXPECT_EQ(source("0", "0").key, source("0", "1").key);
    EXPECT_NE(source("0", "0").key, source("1", "0").key);
}

TEST(ProgramSource, TextsOfRootsAreMadeOnce) {
    const auto source = [](const char* groups) {
        return MakeProgramSource({}, "integrator/intersect.cl", {{"HDS_FEATURE_GROUPS", groups}});
    };
    EXPECT_EQ(source("0").text, source("1").text) << "one object";
    EXPECT_EQ(*source("0").text, ExpandKernelSource("integrator/intersect.cl"));
    EXPECT_NE(source("0").key, source("1").key);
}

TEST(ProgramSource, TextsOfAFolderAreReadAgain) {
    const TemporaryFolder folder;
    ::setenv("HDSTREAM_KERNEL_DIR", folder.Path().c_str(), 1);
    for (const char* line : {"kernel void one() {}\n", "kernel void two() {}\n"}) {
        std::ofstream(folder.File("some.cl")) << line;
        const ProgramSource source = MakeProgramSource({}, "some.cl", {});
        EXPECT_NE(source.text->find(line), std::string::npos);
    }
    ::unsetenv("HDSTREAM_KERNEL_DIR");
}

} // namespace
} // namespace hds::test
