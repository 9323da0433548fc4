// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/udim.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

namespace hds {

namespace {

const std::string kToken = "<UDIM>";
constexpr std::size_t kDigits = 4;

/// Names with a number in the place of the token.
class TilePattern {
public:
    /// \param name what has no token fits nothing.
    explicit TilePattern(const std::string& name) {
        const std::size_t at = name.find(kToken);
        _hasToken = at != std::string::npos;
        if (_hasToken) {
            _before = name.substr(0, at);
            _after = name.substr(at + kToken.size());
        }
    }

    bool HasToken() const { return _hasToken; }

    /// The index of a name that fits.
    std::optional<std::uint32_t> IndexOf(const std::string& name) const {
        const std::size_t at = _before.size();
        if (!_hasToken || name.size() != at + kDigits + _after.size() ||
            name.compare(0, at, _before) != 0 ||
            name.compare(at + kDigits, std::string::npos, _after) != 0) {
            return std::nullopt;
        }
        const std::string digits = name.substr(at, kDigits);
        const bool isNumber = std::all_of(digits.begin(), digits.end(),
                                          [](unsigned char c) { return c >= '0' && c <= '9'; });
        const std::uint32_t number = isNumber ? std::uint32_t(std::stoul(digits)) : 0;
        return number >= kFirstUdim && number <= kLastUdim ? std::make_optional(number - kFirstUdim)
                                                           : std::nullopt;
    }

private:
    bool _hasToken = false;
    std::string _before;
    std::string _after;
};

std::vector<UdimFile> FindInFolder(const std::string& pattern) {
    namespace fs = std::filesystem;
    // The token may be in the name of a folder: what comes before, the name, what follows.
    const std::size_t token = std::min(pattern.find(kToken), pattern.size());
    const std::size_t nameBegin = pattern.rfind('/', token) + 1; // 0 where there is none
    const std::size_t nameEnd = std::min(pattern.find('/', token), pattern.size());
    const TilePattern tiles(pattern.substr(nameBegin, nameEnd - nameBegin));
    std::vector<UdimFile> files;
    if (!tiles.HasToken()) {
        return files;
    }
    const std::string folder = nameBegin > 0 ? pattern.substr(0, nameBegin) : ".";
    const std::string rest = pattern.substr(nameEnd);
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {
        const auto index = tiles.IndexOf(entry->path().filename().string());
        const std::string file = entry->path().string() + rest;
        std::error_code ignored;
        if (index && (rest.empty() || fs::exists(file, ignored))) {
            files.push_back({*index, {file, 0, 0}});
        }
    }
    return files;
}

std::vector<UdimFile> FindInDirectory(const std::string& packagePath, const std::string& pattern) {
    const TilePattern tiles(pattern);
    std::vector<UdimFile> files;
    const std::optional<PackageFile> package = PackageFile::Open(packagePath);
    for (const std::string& name : package ? package->Names() : std::vector<std::string>()) {
        const auto index = tiles.IndexOf(name);
        const auto range = index ? package->Find(name) : std::nullopt;
        if (range) {
            files.push_back({*index, *range});
        }
    }
    return files;
}

} // namespace

std::string TileName(const std::string& pattern, std::uint32_t index) {
    const std::size_t at = pattern.find(kToken);
    return at == std::string::npos ? pattern
                                   : std::string(pattern).replace(
                                         at, kToken.size(), std::to_string(kFirstUdim + index));
}

std::vector<UdimFile> FindUdimFiles(const std::string& pattern) {
    const auto inPackage = SplitPackagePath(pattern);
    std::vector<UdimFile> files =
        inPackage ? FindInDirectory(inPackage->first, inPackage->second) : FindInFolder(pattern);
    std::sort(files.begin(), files.end(),
              [](const UdimFile& a, const UdimFile& b) { return a.index < b.index; });
    return files;
}

} // namespace hds
