// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/arrayFiles.h"

#include "hdStream/base/error.h"

#include <sys/stat.h>

#include <optional>
#include <shared_mutex>
#include <unordered_map>

namespace hds {

namespace {

struct State {
    dev_t device = 0;
    ino_t number = 0;
    off_t bytes = 0;
    timespec changed{};

    bool IsSameFile(const State& other) const {
        return device == other.device && number == other.number;
    }
    bool operator==(const State& other) const {
        return IsSameFile(other) && bytes == other.bytes &&
               changed.tv_sec == other.changed.tv_sec && changed.tv_nsec == other.changed.tv_nsec;
    }
};

struct Seen {
    std::string path;
    State state;
};

std::shared_mutex mutex;
std::unordered_map<const ArraySource*, std::vector<Seen>> filesBySource;

std::optional<State> StateOf(const std::string& path) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0) {
        return std::nullopt;
    }
    return State{status.st_dev, status.st_ino, status.st_size, status.st_mtim};
}

} // namespace

void ArrayFiles::Watch(const ArraySource* source, const std::vector<std::string>& paths) {
    std::vector<Seen> files;
    for (const std::string& path : paths) {
        if (const auto state = StateOf(path)) {
            files.push_back({path, *state});
        }
    }
    const std::lock_guard<std::shared_mutex> lock(mutex);
    filesBySource[source] = std::move(files);
}

void ArrayFiles::Forget(const ArraySource* source) {
    const std::lock_guard<std::shared_mutex> lock(mutex);
    filesBySource.erase(source);
}

void ArrayFiles::Check(const ArraySource* source) {
    const std::shared_lock<std::shared_mutex> lock(mutex);
    const auto files = filesBySource.find(source);
    if (files == filesBySource.end()) {
        return;
    }
    for (const Seen& file : files->second) {
        const auto now = StateOf(file.path);
        if (now && now->IsSameFile(file.state) && !(*now == file.state)) {
            throw Error(file.path + " has been written into");
        }
    }
}

} // namespace hds
