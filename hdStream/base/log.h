// SPDX-License-Identifier: Apache-2.0
// Warnings about scene content: one line each, once per (subject, text), kept for the statistics.
#pragma once

#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace hds {

/// Collects warnings. Thread-safe. `subject` is a prim path, file or option and starts the line.
class Warnings {
public:
    using Sink = std::function<void(const std::string& line)>;

    /// \param sink called once for every new line (under the lock); may be empty.
    explicit Warnings(Sink sink = {}) : _sink(std::move(sink)) {}

    /// Records "subject: text" unless it is known already.
    void Add(const std::string& subject, const std::string& text);

    /// Whether there is a line of this subject.
    bool Has(const std::string& subject) const;

    /// All lines, sorted, so that their order does not depend on threads.
    std::vector<std::string> Lines() const;

    /// Forgets the lines (a new stage).
    void Clear();

private:
    mutable std::mutex _mutex;
    std::set<std::string> _lines;
    Sink _sink;
};

} // namespace hds
