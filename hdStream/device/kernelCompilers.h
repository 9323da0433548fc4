// SPDX-License-Identifier: Apache-2.0
// Processes that compile programs beside the one that renders: PoCL compiles one kernel at a time
// in a process, and hands out a binary only after it has compiled each kernel once more.
// Invariant: what cannot be compiled there is compiled by who asked for it; nothing here fails a
// render. Explained in docs/device.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/device/programSource.h"
#include "hdStream/persist/store.h"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace hds {

struct KernelCompilersOptions {
    /// The program that they run; empty: DefaultExecutable().
    std::string executable;
    /// Most processes at a time; 0: one for each core.
    std::size_t mostProcesses = 0;
    /// A process that computes for so long without an answer is given up, and so is one that does
    /// nothing for so long. Time that other processes take does not count.
    std::chrono::milliseconds patience{60000};
    /// A process that has had nothing to do for so long ends.
    std::chrono::milliseconds idleTime{20000};
};

/// Compiles programs in processes of its own and keeps their binaries in a store. Externally
/// synchronised; has a thread for each process. The destructor ends the processes, whatever they
/// do.
class KernelCompilers {
public:
    /// \param warnings gets a line when a process fails; may be null.
    KernelCompilers(DeviceProperties device, Store* store, Warnings* warnings,
                    KernelCompilersOptions options = {});
    ~KernelCompilers();
    KernelCompilers(const KernelCompilers&) = delete;
    KernelCompilers& operator=(const KernelCompilers&) = delete;

    /// The file `hdstreamCompileKernels` beside the library or program that this code is linked
    /// into, or what HDSTREAM_KERNEL_COMPILER names; empty: there is none.
    static std::string DefaultExecutable();

    /// Whether there is anything to run, and it has not failed yet.
    bool CanCompile() const;

    /// Starts processes before it is known what they are to compile: a compiler takes a while to
    /// start.
    void Warm();

    /// Starts to compile programs of which no binary is in the store; the longest text first. Never
    /// blocks.
    void Begin(std::vector<ProgramSource> sources);

    /// The binary of a program that was begun; blocks until it is there. Once a program.
    /// \return empty: it was not begun, or could not be compiled.
    std::vector<unsigned char> Take(const std::string& key);

    /// Nothing more is begun for now: processes end when they are done.
    void Rest();

private:
    struct Result {
        bool isDone = false;
        std::vector<unsigned char> binary; ///< empty: there is none
    };

    void JoinEnded();
    void AddProcesses(std::size_t count);
    void Run();
    std::string Serve(int socket, const std::function<bool()>& awaitAnswer);
    bool WaitForWork(std::unique_lock<std::mutex>* lock);
    void EndProcess(const std::string& failure);

    DeviceProperties _device;
    Store* _store;
    Warnings* _warnings;
    KernelCompilersOptions _options;

    mutable std::mutex _mutex; ///< guards all below
    std::condition_variable _changed;
    std::deque<ProgramSource> _queue;       ///< the longest first
    std::map<std::string, Result> _results; ///< by key
    std::vector<std::thread> _threads;
    std::set<int> _sockets; ///< of the processes that run
    std::size_t _numRunning = 0;
    std::size_t _numIdle = 0; ///< of those that run; those that start count as idle
    bool _isResting = false;
    bool _isClosing = false;
    bool _hasFailed = false;
};

} // namespace hds
