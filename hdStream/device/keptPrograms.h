// SPDX-License-Identifier: Apache-2.0
// Built programs that nobody uses at present, for whoever asks for them next: private to the device
// layer. Explained in docs/device.md.
#pragma once

#include <cstddef>
#include <list>
#include <mutex>
#include <string>

namespace hds {

/// Owns cl_programs of one context. Thread-safe.
class KeptPrograms {
public:
    /// Each may hold some megabytes. A set of kernels has five or six.
    static constexpr std::size_t kMostPrograms = 24;

    KeptPrograms() = default;
    ~KeptPrograms();
    KeptPrograms(const KeptPrograms&) = delete;
    KeptPrograms& operator=(const KeptPrograms&) = delete;

    /// The program is the caller's from now on; null: none is kept under this key.
    void* Take(const std::string& key);
    /// Takes the caller's program over; lets go of those that were kept longest ago.
    void Keep(std::string key, void* program);

private:
    struct Kept {
        std::string key;
        void* program;
    };

    std::mutex _mutex;
    std::list<Kept> _programs; ///< kept last comes last
};

} // namespace hds
