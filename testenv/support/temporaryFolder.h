// SPDX-License-Identifier: Apache-2.0
// A fresh folder for the files of one test, removed with its contents.
#pragma once

#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

namespace hds::test {

class TemporaryFolder {
public:
    TemporaryFolder() {
        static std::atomic<unsigned> counter{0};
        std::random_device random;
        _path = std::filesystem::temp_directory_path() /
                ("hdstream-test-" + std::to_string(random()) + "-" + std::to_string(counter++));
        std::filesystem::create_directories(_path);
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(_path, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    std::string Path() const { return _path.string(); }
    std::string File(const std::string& name) const { return (_path / name).string(); }

    /// Number of entries, hidden ones too.
    std::size_t NumEntries() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(_path),
                                                      std::filesystem::directory_iterator()));
    }

private:
    std::filesystem::path _path;
};

inline std::string ReadFile(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void WriteFile(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

} // namespace hds::test
