// SPDX-License-Identifier: Apache-2.0
#include "hdStream/device/kernelCompilers.h"

#include "hdStream/device/compileProtocol.h"
#include "hdStream/device/program.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

extern char** environ;

namespace hds {

namespace {

constexpr const char* kExecutableName = "hdstreamCompileKernels";
/// What a compiler is started with: it costs LLVM most of a second to compile this.
constexpr const char* kSmallestProgram = "kernel void warm(global int* x) { x[0] = 0; }\n";

/// Who gets a smaller part of a core than one in so many hangs, however busy the machine is.
constexpr int kLeastShare = 1000;

/// An object of this library, by whose address its file is found.
const char kAnchor = 0;

/// One process and our end of the socket that is its standard input and output.
class Process {
public:
    /// \throws Error when it cannot be started.
    Process(const std::string& executable, std::chrono::milliseconds patience)
        : _patience(patience) {
        int ends[2] = {-1, -1};
        if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
            throw Error(std::strerror(errno));
        }
        _socket = ends[0];
        const int code = Spawn(executable, ends[1]);
        ::close(ends[1]);
        if (code != 0) {
            ::close(_socket);
            throw Error(std::strerror(code));
        }
        timeval limit{};
        limit.tv_sec = patience.count() / 1000;
        limit.tv_usec = static_cast<suseconds_t>(patience.count() % 1000 * 1000);
        for (const int option : {SO_RCVTIMEO, SO_SNDTIMEO}) {
            ::setsockopt(_socket, SOL_SOCKET, option, &limit, sizeof(limit));
        }
    }
    /// Ends it, whatever it does, and leaves nothing of it behind.
    ~Process() {
        ::close(_socket);
        ::kill(_id, SIGKILL);
        while (::waitpid(_id, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    int Socket() const { return _socket; }

    /// Waits until it says something or ends. \return false: it hangs.
    bool AwaitAnswer() const {
        using std::chrono::nanoseconds;
        const nanoseconds begin = CpuTime();
        nanoseconds last = begin;
        pollfd answer{_socket, POLLIN, 0};
        while (true) {
            const int ready = ::poll(&answer, 1, static_cast<int>(_patience.count()));
            if (ready > 0) {
                return true;
            }
            if (ready < 0 && errno != EINTR) {
                return false;
            }
            const nanoseconds now = CpuTime();
            if (ready == 0 &&
                (now - last < nanoseconds(_patience) / kLeastShare || now - begin > _patience)) {
                return false;
            }
            last = ready == 0 ? now : last;
        }
    }

private:
    /// Of all its threads; 0 when it has ended.
    std::chrono::nanoseconds CpuTime() const {
        clockid_t clock{};
        timespec time{};
        if (::clock_getcpuclockid(_id, &clock) != 0 || ::clock_gettime(clock, &time) != 0) {
            return {};
        }
        return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
    }

    /// Hosts have many threads: nothing of ours runs between fork and exec. \return an error code.
    int Spawn(const std::string& executable, int end) {
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_adddup2(&actions, end, STDIN_FILENO);
        posix_spawn_file_actions_adddup2(&actions, end, STDOUT_FILENO);
        posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
        posix_spawnattr_t attributes;
        posix_spawnattr_init(&attributes);
        // A group of its own: Ctrl-C is for the process that renders, which then ends this one.
        // What the host does with signals is no concern of a compiler.
        sigset_t none;
        sigset_t all;
        sigemptyset(&none);
        sigfillset(&all);
        posix_spawnattr_setpgroup(&attributes, 0);
        posix_spawnattr_setsigmask(&attributes, &none);
        posix_spawnattr_setsigdefault(&attributes, &all);
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK |
                                                  POSIX_SPAWN_SETSIGDEF);
        std::string name = executable;
        char* const arguments[] = {name.data(), nullptr};
        const int code =
            ::posix_spawn(&_id, executable.c_str(), &actions, &attributes, arguments, environ);
        posix_spawnattr_destroy(&attributes);
        posix_spawn_file_actions_destroy(&actions);
        return code;
    }

    std::chrono::milliseconds _patience;
    pid_t _id = -1;
    int _socket = -1;
};

} // namespace

std::string KernelCompilers::DefaultExecutable() {
    if (const char* said = std::getenv("HDSTREAM_KERNEL_COMPILER")) {
        return said;
    }
    Dl_info library{};
    if (::dladdr(&kAnchor, &library) == 0 || library.dli_fname == nullptr) {
        return {};
    }
    std::error_code error;
    // The name of a program is as it was started; a library's is a path.
    const std::filesystem::path file = std::strchr(library.dli_fname, '/') != nullptr
                                           ? std::filesystem::path(library.dli_fname)
                                           : std::filesystem::read_symlink("/proc/self/exe", error);
    const std::filesystem::path path = file.parent_path() / kExecutableName;
    return ::access(path.c_str(), X_OK) == 0 ? path.string() : std::string();
}

KernelCompilers::KernelCompilers(DeviceProperties device, Store* store, Warnings* warnings,
                                 KernelCompilersOptions options)
    : _device(std::move(device)), _store(store), _warnings(warnings), _options(std::move(options)) {
    if (_options.executable.empty()) {
        _options.executable = DefaultExecutable();
    }
    if (_options.mostProcesses == 0) {
        _options.mostProcesses = std::max(1U, std::thread::hardware_concurrency());
    }
}

KernelCompilers::~KernelCompilers() {
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _isClosing = true;
        for (const int socket : _sockets) {
            ::shutdown(socket, SHUT_RDWR); // whoever waits for an answer
        }
    }
    _changed.notify_all();
    for (std::thread& thread : _threads) {
        thread.join();
    }
}

bool KernelCompilers::CanCompile() const {
    const std::lock_guard<std::mutex> lock(_mutex);
    return !_options.executable.empty() && _store->IsWriting() && !_hasFailed;
}

void KernelCompilers::Warm() {
    const std::lock_guard<std::mutex> lock(_mutex);
    _isResting = false;
    AddProcesses(_options.mostProcesses);
}

void KernelCompilers::Begin(std::vector<ProgramSource> sources) {
    const std::lock_guard<std::mutex> lock(_mutex);
    _isResting = false;
    JoinEnded();
    for (ProgramSource& source : sources) {
        if (_results.try_emplace(source.key).second) {
            _queue.push_back(std::move(source));
        }
    }
    std::stable_sort(_queue.begin(), _queue.end(),
                     [](const auto& a, const auto& b) { return a.text->size() > b.text->size(); });
    AddProcesses(_queue.size() - std::min(_queue.size(), _numIdle));
    _changed.notify_all();
}

/// \pre the mutex is held.
void KernelCompilers::JoinEnded() {
    if (_numRunning == 0) {
        for (std::thread& thread : _threads) {
            thread.join();
        }
        _threads.clear();
    }
}

/// \pre the mutex is held.
void KernelCompilers::AddProcesses(std::size_t count) {
    if (_hasFailed || _options.executable.empty()) {
        count = 0;
    }
    for (; count > 0 && _numRunning < _options.mostProcesses; --count) {
        ++_numRunning;
        ++_numIdle;
        _threads.emplace_back(&KernelCompilers::Run, this);
    }
    if (_numRunning == 0) { // nobody will
        for (const ProgramSource& source : _queue) {
            _results[source.key].isDone = true;
        }
        _queue.clear();
    }
}

/// The thread of a process.
void KernelCompilers::Run() {
    std::string failure;
    try {
        const Process process(_options.executable, _options.patience);
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            _sockets.insert(process.Socket());
        }
        failure = Serve(process.Socket(), [&] { return process.AwaitAnswer(); });
        const std::lock_guard<std::mutex> lock(_mutex);
        _sockets.erase(process.Socket());
    } catch (const std::exception& error) {
        failure = std::string("it cannot be started: ") + error.what();
    }
    EndProcess(failure);
}

/// \return why the process failed; empty: it did not.
std::string KernelCompilers::Serve(int socket, const std::function<bool()>& awaitAnswer) {
    CompileMessage kind{};
    std::string payload;
    ProgramSource smallest;
    smallest.text = std::make_shared<const std::string>(kSmallestProgram);
    const auto exchange = [&](const ProgramSource& source) {
        const std::string request = PackRequest(_device, source);
        return SendMessage(socket, CompileMessage::Compile, request.data(), request.size()) &&
               awaitAnswer() && ReceiveMessage(socket, &kind, &payload) &&
               (kind == CompileMessage::Binary || kind == CompileMessage::NotBuilt);
    };
    if (!awaitAnswer() || !ReceiveMessage(socket, &kind, &payload) ||
        kind != CompileMessage::Ready) {
        return "it does not answer as it should";
    }
    std::unique_lock<std::mutex> lock(_mutex);
    if (_queue.empty()) {
        lock.unlock();
        if (!exchange(smallest)) {
            return "it ended or hangs";
        }
        lock.lock();
    }
    while (WaitForWork(&lock)) {
        const ProgramSource source = std::move(_queue.front());
        _queue.pop_front();
        --_numIdle;
        lock.unlock();
        // Another process that renders may have needed it too.
        std::vector<unsigned char> binary = Program::StoredBinary(source, _store);
        const bool isAnswered = !binary.empty() || exchange(source);
        if (binary.empty() && isAnswered && kind == CompileMessage::Binary) {
            binary.assign(payload.begin(), payload.end());
            Program::SaveBinary(source, binary.data(), binary.size(), _store);
        }
        lock.lock();
        ++_numIdle;
        Result& result = _results[source.key];
        result.isDone = true;
        result.binary = std::move(binary);
        _changed.notify_all();
        if (!isAnswered) {
            return "it ended or hangs while it compiles " + source.root;
        }
    }
    return {};
}

/// \return false: there is no more.
bool KernelCompilers::WaitForWork(std::unique_lock<std::mutex>* lock) {
    const auto isOver = [&] { return _isClosing || !_queue.empty() || _isResting; };
    _changed.wait_for(*lock, _options.idleTime, isOver);
    return !_isClosing && !_queue.empty();
}

/// The last one that ends leaves nothing undecided.
void KernelCompilers::EndProcess(const std::string& failure) {
    const std::lock_guard<std::mutex> lock(_mutex);
    --_numRunning;
    --_numIdle;
    if (!failure.empty() && !_isClosing) {
        _hasFailed = true;
        // On a machine under load several may fail, each with another program.
        if (_warnings != nullptr && !_warnings->Has(_options.executable)) {
            _warnings->Add(_options.executable,
                           failure + "; kernels are compiled without it, which takes longer");
        }
    }
    AddProcesses(_isClosing ? 0 : _queue.size() - std::min(_queue.size(), _numIdle));
    _changed.notify_all();
}

std::vector<unsigned char> KernelCompilers::Take(const std::string& key) {
    std::unique_lock<std::mutex> lock(_mutex);
    const auto found = _results.find(key);
    if (found == _results.end()) {
        return {};
    }
    _changed.wait(lock, [&] { return found->second.isDone; });
    std::vector<unsigned char> binary = std::move(found->second.binary);
    _results.erase(found);
    return binary;
}

void KernelCompilers::Rest() {
    const std::lock_guard<std::mutex> lock(_mutex);
    _isResting = true;
    _changed.notify_all();
}

} // namespace hds
