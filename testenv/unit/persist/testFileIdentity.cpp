// SPDX-License-Identifier: Apache-2.0
// Whatever of a file is looked at changes its identity; what is not there has none.
#include "hdStream/persist/fileIdentity.h"

#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

namespace hds {
namespace {

std::string IdentityOf(const std::string& path, std::uint64_t offset = 0, std::uint64_t size = 0) {
    Hasher hasher;
    return AppendFileIdentity(&hasher, path, offset, size) ? hasher.Hex() : "none";
}

TEST(FileIdentity, TellsFilesAndTheirStatesApart) {
    const test::TemporaryFolder folder;
    const std::string path = folder.File("file with spaces \xc3\xa4");
    const std::string content(100000, 'a');
    test::WriteFile(path, content);
    const auto time = std::filesystem::last_write_time(path);
    const std::string identity = IdentityOf(path);
    const auto rewrite = [&](std::size_t at) { // with the time it had
        std::string changed = content;
        changed[at] = 'b';
        test::WriteFile(path, changed);
        std::filesystem::last_write_time(path, time);
        return IdentityOf(path);
    };
    EXPECT_EQ(rewrite(50000), identity); // the middle is believed by size and time
    EXPECT_NE(rewrite(0), identity);
    EXPECT_NE(rewrite(99999), identity);
    test::WriteFile(path, content);
    std::filesystem::last_write_time(path, time);
    EXPECT_EQ(IdentityOf(path), identity);
    std::filesystem::last_write_time(path, time - std::chrono::seconds(1));
    EXPECT_NE(IdentityOf(path), identity);
    std::filesystem::copy_file(path, folder.File("copy"));
    std::filesystem::last_write_time(folder.File("copy"), time);
    EXPECT_NE(IdentityOf(folder.File("copy")), identity);
    EXPECT_NE(IdentityOf(path, 0, 5000), IdentityOf(path, 5000, 5000));
}

TEST(FileIdentity, OfWhatCannotBeReadIsNone) {
    const test::TemporaryFolder folder;
    EXPECT_EQ(IdentityOf(folder.File("missing")), "none");
    EXPECT_EQ(IdentityOf(folder.Path()), "none");
    test::WriteFile(folder.File("empty"), "");
    EXPECT_NE(IdentityOf(folder.File("empty")), "none");
    EXPECT_NE(IdentityOf(folder.File("empty"), 1000, 1000), "none"); // beyond the end: no bytes
}

} // namespace
} // namespace hds
