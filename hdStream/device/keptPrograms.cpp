// SPDX-License-Identifier: Apache-2.0
#include "hdStream/device/keptPrograms.h"

#include "hdStream/device/openclHandles.h"

#include <algorithm>
#include <utility>

namespace hds {

namespace {

void Release(void* program) {
    clReleaseProgram(static_cast<cl_program>(program));
}

} // namespace

KeptPrograms::~KeptPrograms() {
    for (const Kept& kept : _programs) {
        Release(kept.program);
    }
}

void* KeptPrograms::Take(const std::string& key) {
    const std::lock_guard<std::mutex> lock(_mutex);
    const auto found = std::find_if(_programs.begin(), _programs.end(),
                                    [&](const Kept& kept) { return kept.key == key; });
    if (found == _programs.end()) {
        return nullptr;
    }
    void* program = found->program;
    _programs.erase(found);
    return program;
}

void KeptPrograms::Keep(std::string key, void* program) {
    const std::lock_guard<std::mutex> lock(_mutex);
    _programs.push_back({std::move(key), program});
    if (_programs.size() > kMostPrograms) {
        Release(_programs.front().program);
        _programs.pop_front();
    }
}

} // namespace hds
