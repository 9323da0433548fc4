// SPDX-License-Identifier: Apache-2.0
// Whether to go on, of work on many threads: callbacks of hosts are asked on the thread that
// called.
#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace hds {

/// A question that the thread which made this asks until the answer is yes; the answer is told to
/// all threads. Thread-safe.
class CallerQuestion {
public:
    /// \param ask must outlive the object; empty: the answer is no.
    explicit CallerQuestion(const std::function<bool()>& ask)
        : _ask(ask), _caller(std::this_thread::get_id()) {}

    /// Asks, if it is the turn of this thread. \return the last answer.
    bool Ask() {
        if (!IsYes() && _ask && std::this_thread::get_id() == _caller && _ask()) {
            _isYes.store(true, std::memory_order_relaxed);
        }
        return IsYes();
    }
    /// The last answer.
    bool IsYes() const { return _isYes.load(std::memory_order_relaxed); }

private:
    const std::function<bool()>& _ask;
    std::thread::id _caller;
    std::atomic<bool> _isYes{false};
};

} // namespace hds
