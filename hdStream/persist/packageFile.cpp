// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/packageFile.h"

#include <algorithm>

namespace hds {

namespace {

// PKZIP APPNOTE 4.3.7, 4.3.12, 4.3.16: the fixed parts of the headers.
constexpr std::size_t kLocalBytes = 30;
constexpr std::size_t kEntryBytes = 46;
constexpr std::size_t kEndBytes = 22;
constexpr std::size_t kMaxCommentBytes = 65535;
const std::string kEntrySignature = "PK\1\2";
const std::string kLocalSignature = "PK\3\4";
const std::string kEndSignature = "PK\5\6";

std::uint32_t Number(const std::string& data, std::size_t offset, int bytes) {
    std::uint32_t number = 0;
    for (int i = bytes; i-- > 0;) {
        number = number << 8U | static_cast<unsigned char>(data[offset + std::size_t(i)]);
    }
    return number;
}

bool IsEscaped(const std::string& path, std::size_t at) {
    return at > 0 && path[at - 1] == '\\';
}

/// The bracket that the last one, which closes, belongs to. Those that a backslash is before are
/// part of a name.
std::size_t FindOutermost(const std::string& path) {
    if (path.empty() || path.back() != ']' || IsEscaped(path, path.size() - 1)) {
        return std::string::npos;
    }
    int depth = 0;
    for (std::size_t i = path.size(); i-- > 0;) {
        if (!IsEscaped(path, i)) {
            depth += path[i] == ']' ? 1 : 0;
            depth -= path[i] == '[' ? 1 : 0;
        }
        if (depth == 0) {
            return i;
        }
    }
    return std::string::npos;
}

std::string WithoutEscapes(const std::string& name) {
    std::string plain;
    for (std::size_t i = 0; i < name.size(); ++i) {
        const bool isEscape =
            name[i] == '\\' && i + 1 < name.size() && (name[i + 1] == '[' || name[i + 1] == ']');
        if (!isEscape) {
            plain += name[i];
        }
    }
    return plain;
}

} // namespace

std::optional<std::pair<std::string, std::string>> SplitPackagePath(const std::string& path) {
    const std::size_t first = FindOutermost(path);
    if (first == std::string::npos) {
        return std::nullopt;
    }
    const std::string package = path.substr(0, first);
    const std::string inner = path.substr(first + 1, path.size() - first - 2);
    const auto deeper = SplitPackagePath(inner);
    return deeper ? std::make_pair(package + '[' + deeper->first + ']', deeper->second)
                  : std::make_pair(package, WithoutEscapes(inner));
}

bool PackageFile::Read(std::uint64_t offset, std::size_t bytes, std::string* data) const {
    if (offset > _range.size || bytes > _range.size - offset) {
        return false;
    }
    data->resize(bytes);
    return _file.Read(_range.offset + offset, data->data(), bytes);
}

bool PackageFile::ReadDirectory() {
    const std::size_t tailBytes = static_cast<std::size_t>(
        std::min<std::uint64_t>(_range.size, kEndBytes + kMaxCommentBytes));
    std::string tail;
    if (tailBytes < kEndBytes || !Read(_range.size - tailBytes, tailBytes, &tail)) {
        return false;
    }
    const std::size_t end = tail.rfind(kEndSignature, tailBytes - kEndBytes);
    if (end == std::string::npos) {
        return false;
    }
    std::string directory;
    if (!Read(Number(tail, end + 16, 4), Number(tail, end + 12, 4), &directory)) {
        return false;
    }
    const std::uint32_t count = Number(tail, end + 10, 2);
    std::size_t at = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (directory.size() - at < kEntryBytes ||
            directory.compare(at, kEntrySignature.size(), kEntrySignature) != 0) {
            return false;
        }
        const std::size_t nameBytes = Number(directory, at + 28, 2);
        const std::size_t bytes =
            kEntryBytes + nameBytes + Number(directory, at + 30, 2) + Number(directory, at + 32, 2);
        if (directory.size() - at < bytes) {
            return false;
        }
        const bool isEncrypted = (Number(directory, at + 8, 2) & 1U) != 0;
        const bool isStored = Number(directory, at + 10, 2) == 0;
        _entries.push_back({directory.substr(at + kEntryBytes, nameBytes),
                            Number(directory, at + 42, 4), Number(directory, at + 24, 4),
                            isStored && !isEncrypted});
        at += bytes;
    }
    return true;
}

std::optional<PackageFile> PackageFile::Open(const std::string& path) {
    ByteRange range{path, 0, 0};
    if (SplitPackagePath(path)) {
        const std::optional<ByteRange> inner = FindInPackage(path);
        if (!inner) {
            return std::nullopt;
        }
        range = *inner;
    }
    PackageFile package(std::move(range));
    package._file = File::OpenForReading(package._range.file);
    if (!package._file.IsOpen()) {
        return std::nullopt;
    }
    if (package._range.size == 0) {
        package._range.size = package._file.Size();
    }
    if (!package.ReadDirectory()) {
        return std::nullopt;
    }
    return package;
}

std::vector<std::string> PackageFile::Names() const {
    std::vector<std::string> names;
    for (const Entry& entry : _entries) {
        names.push_back(entry.name);
    }
    return names;
}

std::optional<ByteRange> PackageFile::Find(const std::string& name) const {
    const auto entry = std::find_if(_entries.begin(), _entries.end(),
                                    [&](const Entry& one) { return one.name == name; });
    std::string local;
    if (entry == _entries.end() || !entry->isStored || !Read(entry->header, kLocalBytes, &local) ||
        local.compare(0, kLocalSignature.size(), kLocalSignature) != 0) {
        return std::nullopt;
    }
    // The lengths in the local header count: its extra field holds the padding of the alignment.
    const std::uint64_t offset =
        entry->header + kLocalBytes + Number(local, 26, 2) + Number(local, 28, 2);
    if (offset > _range.size || entry->size > _range.size - offset) {
        return std::nullopt;
    }
    return ByteRange{_range.file, _range.offset + offset, entry->size};
}

std::optional<ByteRange> FindInPackage(const std::string& path) {
    const auto parts = SplitPackagePath(path);
    const std::optional<PackageFile> package =
        parts ? PackageFile::Open(parts->first) : std::nullopt;
    return package ? package->Find(parts->second) : std::nullopt;
}

} // namespace hds
