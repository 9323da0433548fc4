// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/fileIdentity.h"

#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <vector>

namespace hds {

namespace {

constexpr std::uint64_t kSampleBytes = 16384;

} // namespace

bool AppendFileIdentity(Hasher* hasher, const std::string& path, std::uint64_t offset,
                        std::uint64_t size) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) {
        return false;
    }
    const auto fileBytes = static_cast<std::uint64_t>(status.st_size);
    const std::uint64_t begin = std::min(offset, fileBytes);
    const std::uint64_t end = size == 0 ? fileBytes : begin + std::min(size, fileBytes - begin);
    const std::uint64_t sample = std::min(kSampleBytes, end - begin);
    std::vector<char> bytes(2 * sample);
    std::ifstream file(path, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(begin));
    file.read(bytes.data(), static_cast<std::streamsize>(sample));
    file.seekg(static_cast<std::streamoff>(end - sample));
    file.read(bytes.data() + sample, static_cast<std::streamsize>(sample));
    if (!file) {
        return false;
    }
    hasher->Append(path);
    hasher->Append(fileBytes);
    hasher->Append(static_cast<std::uint64_t>(status.st_mtim.tv_sec));
    hasher->Append(static_cast<std::uint64_t>(status.st_mtim.tv_nsec));
    hasher->Append(offset);
    hasher->Append(size);
    hasher->Append(std::string_view(bytes.data(), bytes.size()));
    return true;
}

} // namespace hds
