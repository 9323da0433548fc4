// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/udim.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace hds {

namespace {

const std::string kToken = "<UDIM>";
constexpr std::size_t kDigits = 4;

} // namespace

std::vector<UdimFile> FindUdimFiles(const std::string& pattern) {
    namespace fs = std::filesystem;
    const fs::path path(pattern);
    const std::string name = path.filename().string();
    const std::size_t at = name.find(kToken);
    std::vector<UdimFile> files;
    if (at == std::string::npos) {
        return files;
    }
    const std::string suffix = name.substr(at + kToken.size());
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string candidate = entry->path().filename().string();
        if (candidate.size() != at + kDigits + suffix.size() ||
            candidate.compare(0, at, name, 0, at) != 0 ||
            candidate.compare(at + kDigits, suffix.size(), suffix) != 0) {
            continue;
        }
        const std::string digits = candidate.substr(at, kDigits);
        const bool isNumber = std::all_of(digits.begin(), digits.end(),
                                          [](unsigned char c) { return c >= '0' && c <= '9'; });
        const std::uint32_t number = isNumber ? std::uint32_t(std::stoul(digits)) : 0;
        if (number >= kFirstUdim && number <= kLastUdim) {
            files.push_back({number - kFirstUdim, entry->path().string()});
        }
    }
    std::sort(files.begin(), files.end(),
              [](const UdimFile& a, const UdimFile& b) { return a.index < b.index; });
    return files;
}

} // namespace hds
