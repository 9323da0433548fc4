// SPDX-License-Identifier: Apache-2.0
// Arrays that are away: what is read again is what was there, or an error of one line.
#include "hdStream/base/error.h"
#include "hdStream/base/fieldHash.h"
#include "hdStream/base/sharedSpan.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

namespace hds::test {
namespace {

using Values = std::shared_ptr<std::vector<float>>;

ArrayBytes BytesOf(const Values& values) {
    return {values, values->data(), values->size() * sizeof(float)};
}

/// A file's values, of which each reading is a copy.
struct File {
    std::vector<float> values = std::vector<float>(1000, 2.5F);
    std::atomic<int> numReads{0};
    bool isGone = false;

    ArrayBytes Read() {
        ++numReads;
        if (isGone) {
            throw Error("no such file");
        }
        return BytesOf(std::make_shared<std::vector<float>>(values));
    }
    std::shared_ptr<const ArraySource> Source(std::uint64_t mostKept = 1U << 20U) {
        return std::make_shared<const ArraySource>(
            "/M.points", Read(), [this] { return Read(); }, mostKept);
    }
};

TEST(ArraySource, IsReadAgainOnlyWhereNobodyHoldsIt) {
    File file;
    const SharedSpan<float> span(file.Source());
    ASSERT_NE(span.Source(), nullptr);
    EXPECT_EQ(span.size(), 1000U);
    EXPECT_EQ(span.Held()[999], 2.5F);
    EXPECT_EQ(file.numReads, 1) << "it waits for its first use";
    {
        const SharedSpan<float> held = span.Held();
        EXPECT_EQ(held.Source(), nullptr);
        span.Source()->Drop();
        EXPECT_EQ(span.Held().data(), held.data());
        EXPECT_EQ(file.numReads, 1) << "somebody holds it";
    }
    EXPECT_EQ(span.Held()[0], 2.5F);
    EXPECT_EQ(file.numReads, 2);
    const SharedSpan<float> again = span.Held();
    span.Source()->Drop();
    EXPECT_EQ(span.Held().data(), again.data());
    EXPECT_EQ(file.numReads, 3);
}

TEST(ArraySource, EqualsAndHashesAsTheArrayItself) {
    File file;
    const SharedSpan<float> away(file.Source());
    const SharedSpan<float> here(file.values);
    away.Source()->Drop();
    EXPECT_TRUE(away == here);
    EXPECT_TRUE(away == away);
    file.values[3] = 7.0F;
    File other;
    other.values[3] = 7.0F;
    const SharedSpan<float> different(other.Source());
    EXPECT_FALSE(here == different);
    Hasher a;
    Hasher b;
    FieldHasher(&a).Add(different);
    FieldHasher(&b).Add(SharedSpan<float>(other.values));
    EXPECT_EQ(a.Words(), b.Words());
}

std::string ErrorOf(const SharedSpan<float>& span) {
    try {
        span.Held();
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(ArraySource, WhatHasChangedIsAnError) {
    File file;
    const SharedSpan<float> span(file.Source());
    span.Source()->Drop();
    file.values[500] += 1e-6F;
    EXPECT_EQ(ErrorOf(span), "/M.points: has changed since the stage was translated");
    file.values[500] = 2.5F;
    EXPECT_EQ(ErrorOf(span), "");
    file.values.push_back(2.5F);
    EXPECT_EQ(ErrorOf(span), "/M.points: has changed since the stage was translated");
    file.values.resize(999);
    EXPECT_EQ(ErrorOf(span), "/M.points: has changed since the stage was translated");
    {
        const SharedSpan<float> held(file.Source());
        const SharedSpan<float> others = held.Held();
        held.Source()->Drop();
        const_cast<float*>(others.data())[7] = 9.0F; // it is mapped from a file
        EXPECT_EQ(ErrorOf(held), "/M.points: has changed since the stage was translated");
    }
    file.isGone = true;
    EXPECT_EQ(ErrorOf(span), "/M.points: cannot be read again: no such file");
}

TEST(ArraySource, CountsToTheByte) {
    const ArrayCounts before = ArraySource::Counts();
    File file;
    {
        const SharedSpan<float> span(file.Source(before.keptBytes + 5000));
        const SharedSpan<float> copy = span;
        EXPECT_EQ(ArraySource::Counts().bytes, before.bytes + 4000);
        EXPECT_EQ(ArraySource::Counts().keptBytes, before.keptBytes + 4000);
        const SharedSpan<float> second(file.Source(before.keptBytes + 5000));
        EXPECT_EQ(ArraySource::Counts().bytes, before.bytes + 8000);
        EXPECT_EQ(ArraySource::Counts().keptBytes, before.keptBytes + 4000)
            << "more than may wait for their first use";
        second.Held();
        EXPECT_EQ(ArraySource::Counts().readBytes, before.readBytes + 4000);
        span.Source()->Drop();
        span.Source()->Drop();
        EXPECT_EQ(ArraySource::Counts().keptBytes, before.keptBytes);
    }
    EXPECT_EQ(ArraySource::Counts().bytes, before.bytes);
    { const SharedSpan<float> kept(file.Source()); }
    EXPECT_EQ(ArraySource::Counts().keptBytes, before.keptBytes);
}

TEST(ArraySource, ManyThreadsHoldIt) {
    File file;
    const SharedSpan<float> span(file.Source());
    std::vector<std::thread> threads;
    std::atomic<int> numWrong{0};
    for (int thread = 0; thread < 8; ++thread) {
        threads.emplace_back([&] {
            for (int i = 0; i < 200; ++i) {
                const SharedSpan<float> held = span.Held();
                numWrong += held.size() == 1000 && held[i] == 2.5F ? 0 : 1;
                span.Source()->Drop();
            }
        });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    EXPECT_EQ(numWrong, 0);
}

} // namespace
} // namespace hds::test
