// SPDX-License-Identifier: Apache-2.0
#include "hdStream/base/log.h"

namespace hds {

void Warnings::Add(const std::string& subject, const std::string& text) {
    const std::string line = subject.empty() ? text : subject + ": " + text;
    const std::lock_guard<std::mutex> lock(_mutex);
    if (_lines.insert(line).second && _sink) {
        _sink(line);
    }
}

bool Warnings::Has(const std::string& subject) const {
    const std::string start = subject + ": ";
    const std::lock_guard<std::mutex> lock(_mutex);
    const auto line = _lines.lower_bound(start);
    return line != _lines.end() && line->compare(0, start.size(), start) == 0;
}

std::vector<std::string> Warnings::Lines() const {
    const std::lock_guard<std::mutex> lock(_mutex);
    return {_lines.begin(), _lines.end()};
}

void Warnings::Clear() {
    const std::lock_guard<std::mutex> lock(_mutex);
    _lines.clear();
}

} // namespace hds
