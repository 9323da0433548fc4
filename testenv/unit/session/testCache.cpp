// SPDX-License-Identifier: Apache-2.0
// `hdstream cache` counts and empties both kinds of files of the persistent cache.
#include "hdStream/persist/pageStore.h"
#include "hdStream/persist/store.h"
#include "hdStream/session/session.h"
#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>

namespace hds {
namespace {

TEST(Cache, HasEntriesAndPages) {
    const test::TemporaryFolder folder;
    EXPECT_EQ(InspectCache(folder.Path()).bytes, 0U);
    const std::string data(5000, 'x');
    Store entries({folder.Path()}, nullptr);
    entries.Save("kind", "key", data.data(), data.size());
    const std::uint64_t entryBytes = InspectCache(folder.Path()).bytes;
    EXPECT_EQ(entryBytes, entries.Size());
    PageStore pages({folder.Path()}, nullptr);
    EXPECT_TRUE(pages.Save({{1, 2}}, data.data(), data.size()));
    const std::uint64_t bytes = InspectCache(folder.Path()).bytes;
    EXPECT_EQ(bytes, entryBytes + pages.Size());
    EXPECT_GE(bytes, 2 * data.size());

    EXPECT_EQ(ClearCache(folder.Path()), bytes);
    EXPECT_EQ(InspectCache(folder.Path()).bytes, 0U);
    EXPECT_EQ(folder.NumEntries(), 0U);
}

} // namespace
} // namespace hds
