// SPDX-License-Identifier: Apache-2.0
// Packages (usdz): zip files whose entries are stored, never compressed, so that an entry is a byte
// range of the package. Packages nest; paths into them are OpenUSD's, "a.usdz[b.usdz[c.png]]".
#pragma once

#include "hdStream/persist/file.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hds {

/// Bytes of a file.
struct ByteRange {
    std::string file;
    std::uint64_t offset = 0; ///< bytes
    std::uint64_t size = 0;   ///< bytes
};

/// The directory of a package. Immutable; nothing here throws.
class PackageFile {
public:
    /// \param path a package, or a path to one that lies in packages. \return nothing when it
    /// cannot be read or is no package.
    static std::optional<PackageFile> Open(const std::string& path);

    /// Names of all entries as the package has them (OpenUSD writes UTF-8), in its order.
    std::vector<std::string> Names() const;
    /// Where the content of an entry is; nothing when there is none of this name, or when it is
    /// compressed, encrypted or not whole.
    std::optional<ByteRange> Find(const std::string& name) const;

private:
    struct Entry {
        std::string name;
        std::uint64_t header = 0; ///< offset of its local header in the package
        std::uint64_t size = 0;
        bool isStored = false;
    };

    explicit PackageFile(ByteRange range) : _range(std::move(range)) {}
    bool ReadDirectory();
    bool Read(std::uint64_t offset, std::size_t bytes, std::string* data) const;

    ByteRange _range;
    File _file;
    std::vector<Entry> _entries;
};

/// A path into a package in two: the path of the innermost package and the name of the entry.
/// \return nothing when the path is that of a file.
std::optional<std::pair<std::string, std::string>> SplitPackagePath(const std::string& path);

/// Where an entry of a package is. \param path "a.usdz[b.png]", nested or not. \return nothing when
/// it is no such path or cannot be read (PackageFile::Find).
std::optional<ByteRange> FindInPackage(const std::string& path);

} // namespace hds
