// SPDX-License-Identifier: Apache-2.0
// Tables of values by instance: what kernels read of them is what a plain look-up along the
// instancers finds.
#include "hdStream/scene/instancePrimvars.h"

#include <gtest/gtest.h>

#include <numeric>
#include <optional>
#include <random>

namespace hds {
namespace {

SharedSpan<std::int32_t> ListOf(std::vector<std::int32_t> list) {
    return SharedSpan<std::int32_t>(std::move(list));
}

Primvar ValuesOf(const std::string& name, std::uint32_t numComponents, std::vector<float> values) {
    return {name, Interpolation::Instance, numComponents, std::move(values), {}};
}

void SetCount(InstancerPrim* instancer, std::size_t count) {
    std::vector<float> places(3 * count, 0.0F);
    instancer->instanceTransforms.translations = std::move(places);
}

/// What kernels read: attributes_readInstance.
std::vector<float> Read(const InstancePrimvars& tables, std::uint32_t slot, std::uint64_t number) {
    const shared::HdsInstanceSlot& of = tables.slots[slot];
    const std::uint64_t divisor = (std::uint64_t{of.divisor[1]} << 32U) | of.divisor[0];
    const float* row =
        tables.values.data() + of.firstValue + (number / divisor) % of.numRows * of.numComponents;
    return {row, row + of.numComponents};
}

class InstancePrimvarsTest : public testing::Test {
protected:
    InstancePrimvars Collect() {
        InstancePrimvarCollector collector(_scene, _warnings);
        for (const auto& [path, prim] : _scene.geometry) {
            collector.Add(prim, {&_asked}, {});
        }
        return collector.Take();
    }

    GeometryPrim& AddPrim(const std::string& path, const std::string& instancerPath,
                          std::vector<std::int32_t> instances) {
        GeometryPrim& prim = _scene.geometry[path];
        prim.geometry = std::make_shared<GeometryDescription>();
        prim.placement.instancerPath = instancerPath;
        prim.placement.instances = ListOf(std::move(instances));
        return prim;
    }

    SceneDescription _scene;
    Warnings _warnings;
    std::set<std::string> _asked;
};

TEST_F(InstancePrimvarsTest, ARowIsThatOfTheInstanceAtEachLevel) {
    std::mt19937 rng(7);
    const auto below = [&rng](std::uint32_t n) { return static_cast<std::uint32_t>(rng() % n); };
    for (int round = 0; round < 50; ++round) {
        _scene = {};
        _asked.clear();
        // A chain of instancers, each with some of three names, and a leaf of gaps and repeats.
        const std::uint32_t depth = 1 + below(4);
        std::vector<std::vector<std::int32_t>> lists;
        for (std::uint32_t level = 0; level <= depth; ++level) {
            std::vector<std::int32_t> list(1 + below(5));
            for (std::int32_t& index : list) {
                index = static_cast<std::int32_t>(below(7)) - 1;
            }
            lists.push_back(std::move(list));
        }
        std::vector<std::string> paths;
        for (std::uint32_t level = 0; level < depth; ++level) {
            paths.push_back((level > 0 ? paths.back() : std::string()) + "/I");
            InstancerPrim& instancer = _scene.instancers[paths.back()];
            SetCount(&instancer, 6);
            if (level > 0) {
                instancer.placement.instancerPath = paths[level - 1];
                instancer.placement.instances = ListOf(lists[level]);
            }
            for (std::uint32_t name = 0; name < 3; ++name) {
                if (below(2) == 0) {
                    std::vector<float> values(std::size_t{6} * (name + 1));
                    for (float& value : values) {
                        value = static_cast<float>(below(1000));
                    }
                    instancer.primvars.push_back(
                        ValuesOf("p" + std::to_string(name), name + 1, std::move(values)));
                }
                _asked.insert("p" + std::to_string(name));
            }
        }
        AddPrim("/leaf", paths.back(), lists[depth]);
        const InstancePrimvars tables = Collect();
        for (std::size_t slot = 0; slot < tables.slots.size(); ++slot) {
            // Number the placements as instanceId does: the innermost list is the fastest.
            std::uint64_t numPlacements = 1;
            for (std::uint32_t level = 1; level <= depth; ++level) {
                numPlacements *= lists[level].size();
            }
            for (std::uint64_t number = 0; number < numPlacements; ++number) {
                std::uint64_t rest = number;
                std::optional<std::vector<float>> expected;
                for (std::uint32_t level = depth; level > 0 && !expected; --level) {
                    const std::int32_t index = lists[level][rest % lists[level].size()];
                    rest /= lists[level].size();
                    for (const Primvar& one : _scene.instancers.at(paths[level - 1]).primvars) {
                        if (one.name == tables.names[0][slot].name) {
                            expected.emplace(one.numComponents, 0.0F);
                            for (std::uint32_t k = 0; index >= 0 && k < one.numComponents; ++k) {
                                (*expected)[k] =
                                    one.values[static_cast<std::size_t>(index) * one.numComponents +
                                               k];
                            }
                        }
                    }
                }
                ASSERT_TRUE(expected);
                EXPECT_EQ(Read(tables, static_cast<std::uint32_t>(slot), number), *expected);
            }
        }
        std::set<std::string> there;
        for (const auto& [path, instancer] : _scene.instancers) {
            for (const Primvar& primvar : instancer.primvars) {
                there.insert(primvar.name);
            }
        }
        EXPECT_EQ(tables.slots.size(), there.size());
    }
}

TEST_F(InstancePrimvarsTest, ValuesAreThereOnceForPrimsOfOneList) {
    InstancerPrim& instancer = _scene.instancers["/I"];
    SetCount(&instancer, 4);
    instancer.primvars = {ValuesOf("c", 3, std::vector<float>(12, 0.5F))};
    _asked = {"c"};
    AddPrim("/I/a", "/I", {0, 1, 2});
    AddPrim("/I/b", "/I", {0, 1, 2});
    AddPrim("/I/c", "/I", {3});
    EXPECT_EQ(Collect().values.size(), 12U);
    AddPrim("/I/d", "/I", {0, 1, 3});
    const InstancePrimvars tables = Collect();
    EXPECT_EQ(tables.values.size(), 21U);
    EXPECT_EQ(tables.firstSlots, (std::vector<std::uint32_t>{0, 1, 2, 3}));
}

TEST_F(InstancePrimvarsTest, OwnValuesWinAndWhatNobodyReadsIsNotThere) {
    InstancerPrim& instancer = _scene.instancers["/I"];
    SetCount(&instancer, 2);
    instancer.primvars = {ValuesOf("c", 1, {1.0F, 2.0F}), ValuesOf("d", 1, {1.0F, 2.0F})};
    _asked = {"c"};
    GeometryPrim& prim = AddPrim("/I/a", "/I", {0, 1});
    EXPECT_EQ(Collect().values.size(), 2U);
    auto geometry = std::make_shared<GeometryDescription>();
    geometry->primvars = {{"c", Interpolation::Constant, 1, std::vector<float>{3.0F}, {}}};
    prim.geometry = geometry;
    const InstancePrimvars tables = Collect();
    EXPECT_TRUE(tables.slots.empty() && tables.firstSlots.empty() && tables.names.empty());
}

TEST_F(InstancePrimvarsTest, ValuesThatAreNotAsManyAsInstancesAreIgnored) {
    InstancerPrim& instancer = _scene.instancers["/I"];
    SetCount(&instancer, 3);
    instancer.primvars = {ValuesOf("c", 1, {1.0F, 2.0F})};
    _asked = {"c"};
    AddPrim("/I/a", "/I", {0, 1, 2});
    EXPECT_TRUE(Collect().slots.empty());
    ASSERT_EQ(_warnings.Lines().size(), 1U);
    EXPECT_EQ(_warnings.Lines()[0], "/I: primvar c has 2 numbers for 3 instances; ignored");
}

TEST(IsReadByPrim, NamesWhatInstancesCannotHave) {
    for (const char* name : {"widths", "normals", "hdstream:dielectricPriority",
                             "ri:attributes:trace:intersectpriority", "arnold:subdiv_type"}) {
        EXPECT_TRUE(IsReadByPrim(name)) << name;
    }
    for (const char* name : {"displayColor", "st", "hdstreamColor", "arnoldish", "hdstream:holdout",
                             "arnold:visibility:camera", "karma:object:rendervisibility"}) {
        EXPECT_FALSE(IsReadByPrim(name)) << name;
    }
}

} // namespace
} // namespace hds
