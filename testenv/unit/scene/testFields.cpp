// SPDX-License-Identifier: Apache-2.0
// Whatever a described struct holds is in its key, its equality and its dump, unless its list of
// fields says why not: each member is changed in turn, those of members too.
#include "hdStream/base/fieldHash.h"
#include "hdStream/integrator/renderOptions.h"
#include "hdStream/scene/commit.h"
#include "hdStream/scene/dump.h"
#include "hdStream/scene/geometryKey.h"
#include "hdStream/scene/primEdits.h"
#include "hdStream/texture/lineSlots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>
#include <string_view>
#include <utility>

namespace hds {
namespace {

/// A value that differs from a given one in one place.
template <typename T>
struct Variation {
    T value;
    std::string path = {};
    bool isInKey = true;
    bool isInDump = true;
    std::uint32_t cases = ~0U; ///< of the outermost field
};

template <typename T>
using Variations = std::vector<Variation<T>>;

template <typename T>
Variations<T> VariationsOf(const T& value);

template <typename T>
Variations<SharedSpan<T>> Vary(const SharedSpan<T>& span) {
    std::vector<T> values(span.begin(), span.end());
    values.resize(values.size() + 1, T{1});
    return {{SharedSpan<T>(std::move(values))}};
}
template <typename T>
Variations<std::vector<T>> Vary(const std::vector<T>& list) {
    Variations<std::vector<T>> result;
    if (!list.empty()) {
        for (auto& one : VariationsOf(list[0])) {
            std::vector<T> changed = list;
            changed[0] = std::move(one.value);
            result.push_back({changed, "[0]" + one.path, one.isInKey, one.isInDump});
        }
    }
    if (list.empty() || kHasFields<T>) {
        std::vector<T> changed = list;
        changed.emplace_back();
        result.push_back({changed});
    }
    return result;
}
template <typename T>
Variations<std::set<T>> Vary(std::set<T> values) {
    values.insert("one more");
    return {{values}};
}
template <typename T>
Variations<std::map<std::string, T>> Vary(const std::map<std::string, T>& values) {
    Variations<std::map<std::string, T>> result = {{values}};
    result[0].value["one more"];
    if (!values.empty()) {
        const auto& [key, first] = *values.begin();
        for (auto& one : VariationsOf(first)) {
            result.push_back({values, "[" + key + "]" + one.path, one.isInKey, one.isInDump});
            result.back().value[key] = std::move(one.value);
        }
    }
    return result;
}
/// Of what it points to: the key is of that, equality of the pointer.
template <typename T>
Variations<std::shared_ptr<const T>> Vary(const std::shared_ptr<const T>& pointer) {
    Variations<std::shared_ptr<const T>> result;
    for (auto& one : VariationsOf(pointer ? *pointer : T{})) {
        result.push_back({std::make_shared<const T>(one.value), one.path, one.isInKey || !pointer,
                          one.isInDump});
    }
    return result;
}
template <typename T>
Variations<std::optional<T>> Vary(const std::optional<T>& value) {
    if (!value) {
        return {{T{}}};
    }
    Variations<std::optional<T>> result = {{std::nullopt}};
    for (auto& one : VariationsOf(*value)) {
        result.push_back({one.value, one.path, one.isInKey, one.isInDump});
    }
    return result;
}
template <typename T>
Variations<Apart<T>> Vary(const Apart<T>& value) {
    Variations<Apart<T>> result;
    for (auto& one : VariationsOf(*value)) {
        result.push_back({Apart<T>(one.value), one.path, one.isInKey, one.isInDump});
    }
    return result;
}
template <typename T, std::size_t N>
Variations<std::array<T, N>> Vary(std::array<T, N> values) {
    if constexpr (std::is_arithmetic_v<T>) {
        values[N - 1] += 1;
        return {{values}};
    } else {
        Variations<std::array<T, N>> result;
        for (auto& one : VariationsOf(values[0])) {
            result.push_back({values, "[0]" + one.path, one.isInKey, one.isInDump});
            result.back().value[0] = std::move(one.value);
        }
        return result;
    }
}
Variations<std::string> Vary(const std::string& text) {
    return {{text + "x"}};
}
Variations<ParameterValue> Vary(const ParameterValue& value) {
    return {{value == ParameterValue(std::int64_t{42}) ? ParameterValue(43.0)
                                                       : ParameterValue(std::int64_t{42})}};
}
template <glm::length_t N, typename T, glm::qualifier Q>
Variations<glm::vec<N, T, Q>> Vary(glm::vec<N, T, Q> v) {
    v[N - 1] += 1;
    return {{v}};
}
template <glm::length_t C, glm::length_t R, typename T, glm::qualifier Q>
Variations<glm::mat<C, R, T, Q>> Vary(glm::mat<C, R, T, Q> m) {
    m[C - 1][0] += 1;
    return {{m}};
}

template <typename T>
Variations<T> VariationsOf(const T& value) {
    if constexpr (kHasFields<T>) {
        Variations<T> result;
        ForEachField<T>([&](const auto& field) {
            for (auto& one : VariationsOf(value.*field.member)) {
                result.push_back({value, "." + std::string(field.name) + one.path,
                                  one.isInKey && !field.notInKey, one.isInDump && !field.notInDump,
                                  field.cases});
                result.back().value.*field.member = std::move(one.value);
            }
        });
        return result;
    } else if constexpr (std::is_same_v<T, bool>) {
        return {{!value}};
    } else if constexpr (std::is_enum_v<T>) {
        return {{static_cast<T>(static_cast<int>(value) == 0 ? 1 : 0)}};
    } else if constexpr (std::is_arithmetic_v<T>) {
        return {{static_cast<T>(value + 1)}};
    } else {
        return Vary(value);
    }
}

template <typename T>
auto HashOf(const T& value) {
    Hasher hasher;
    FieldHasher(&hasher).Add(value);
    return hasher.Words();
}

/// A mesh that has everything, whatever its kind makes of it.
GeometryDescription FullMesh(PrimitiveKind kind) {
    const std::vector<std::int32_t> indices = {0, 1, 2};
    GeometryDescription mesh;
    mesh.primitives = kind;
    mesh.points = std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0};
    mesh.samples = {{-0.5, mesh.points}, {0.5, mesh.points}};
    mesh.faceVertexCounts = std::vector<std::int32_t>{3};
    mesh.faceVertexIndices = indices;
    mesh.holeIndices = std::vector<std::int32_t>{0};
    mesh.subdivisionScheme = "catmullClark";
    mesh.subdivTags.Edit().creaseIndices = indices;
    mesh.subdivTags.Edit().cornerIndices = indices;
    mesh.primvars = {
        {"x", Interpolation::Constant, 1, std::vector<float>{1.0F}, SharedSpan<std::int32_t>()}};
    mesh.subsets = {{"/A/s", indices}};
    return mesh;
}

/// Shaped, with an image and a profile, and its shadows fade.
LightDescription FullLight(LightType type) {
    LightDescription light;
    light.type = type;
    light.textureFile.authoredPath = "image";
    light.shaping.focus = 1.0F;
    light.shaping.iesFile.authoredPath = "profile";
    light.shadow.distance = 2.0F;
    light.shadow.falloff = 1.0F;
    return light;
}

MaterialNetwork FullMaterial() {
    MaterialNetwork network;
    network.nodes = {{"/n", "node", {{"a", 1.0}}, {{"b", {"/n", "out"}}}}};
    network.terminals["surface"] = {"/n", "out"};
    return network;
}

Placement Placed() {
    Placement placement;
    placement.instancerPath = "/I";
    placement.samples = {{-1.0, glm::dmat4(2.0)}, {1.0, glm::dmat4(3.0)}};
    return placement;
}

GeometryPrim FullMeshPrim() {
    GeometryPrim prim;
    prim.placement = Placed();
    prim.geometry = std::make_shared<const GeometryDescription>(FullMesh(PrimitiveKind::Faces));
    prim.materialPath = "/m";
    prim.subsetMaterialPaths = {"/m"};
    auto light = std::make_shared<MeshLight>();
    light->light = FullLight(LightType::Mesh);
    light->links = {"lit", "shadowing"};
    prim.light = light;
    return prim;
}

CameraPrim FullCamera() {
    CameraPrim camera;
    camera.shutter = {0.0, 1.0};
    camera.samples = Placed().samples;
    camera.lensSamples = {{-1.0, 5.0F, 2.0F, 3.0F}, {1.0, 6.0F, 2.0F, 3.0F}};
    return camera;
}

DisplacementInput FullDisplacement() {
    DisplacementInput displacement;
    displacement.lookup.emplace();
    displacement.lookup->image = std::make_shared<const HeightImage>();
    displacement.network.emplace();
    displacement.network->primvars.emplace_back();
    DisplacementStep& step = displacement.network->steps.emplace_back();
    step.operands.emplace_back();
    step.tiles.emplace_back().heights[0] = std::make_shared<const HeightImage>();
    return displacement;
}

CommitOptions FullCommitOptions() {
    CommitOptions options;
    options.dicingCamera.emplace();
    return options;
}

// Equality and hashes.

template <typename T>
void ExpectEachFieldCounts(const T& value) {
    EXPECT_TRUE(value == T(value));
    EXPECT_EQ(HashOf(value), HashOf(T(value)));
    std::set<std::array<std::uint64_t, 2>> keys = {HashOf(value)};
    for (const auto& one : VariationsOf(value)) {
        EXPECT_FALSE(one.value == value) << one.path;
        EXPECT_EQ(keys.insert(HashOf(one.value)).second, one.isInKey) << one.path;
    }
}

TEST(Fields, EachIsInEqualityAndKey) {
    ExpectEachFieldCounts(FullMesh(PrimitiveKind::Curves));
    ExpectEachFieldCounts(FullMeshPrim());
    ExpectEachFieldCounts(InstancerPrim{Placed(), {}, {{0.0, {}}}, {}});
    ExpectEachFieldCounts(LightPrim{Placed(), FullLight(LightType::Dome), {{}}, {}, {{}}, {}});
    ExpectEachFieldCounts(FullMaterial());
    ExpectEachFieldCounts(FullCamera());
    ExpectEachFieldCounts(FullDisplacement());
    ExpectEachFieldCounts(FullCommitOptions());
    ExpectEachFieldCounts(ResidencyOptions());
    ExpectEachFieldCounts(DicingOptions());
    ExpectEachFieldCounts(SlotPlan());
}

TEST(Fields, EqualArraysAreEqualWhereverTheyLie) {
    EXPECT_TRUE(FullMesh(PrimitiveKind::Faces) == FullMesh(PrimitiveKind::Faces));
    EXPECT_EQ(HashOf(FullMesh(PrimitiveKind::Faces)), HashOf(FullMesh(PrimitiveKind::Faces)));
}

// Keys.

template <typename List>
void ExpectListsToldApart(const List& two, const List& one) {
    EXPECT_NE(HashOf(std::vector<List>{two, one}), HashOf(std::vector<List>{one, two}));
}

/// The key of lights has one list behind another.
TEST(Fields, AnElementThatMovesBetweenListsIsInTheKey) {
    const LightPortal portal;
    ExpectListsToldApart<std::vector<LightPortal>>({portal, portal}, {portal});
    ExpectListsToldApart<std::vector<float>>({0, 0}, {0});
    ExpectListsToldApart<std::vector<bool>>({false, false}, {false});
    ExpectListsToldApart<SharedSpan<float>>(std::vector<float>{0, 0}, std::vector<float>{0});
    ExpectListsToldApart<std::string>("..", ".");
}

TEST(Fields, EachOfAMeshIsInThePagesKey) {
    GeometryInputs inputs;
    inputs.geometry = std::make_shared<const GeometryDescription>(FullMesh(PrimitiveKind::Faces));
    inputs.dicing.Edit().emplace();
    inputs.displacements = {FullDisplacement()};
    for (const auto& one : VariationsOf(inputs)) {
        EXPECT_EQ(MakeGeometryKey(one.value) != MakeGeometryKey(inputs), one.isInKey) << one.path;
        EXPECT_EQ(one.value.Suffice(inputs), one.path == ".primvars") << one.path;
    }
    inputs.shutter = {0.0, 1.0};
    for (const auto& one : VariationsOf(inputs)) {
        const bool isSample = one.path.rfind(".geometry.samples", 0) == 0 ||
                              one.path.rfind(".geometry.normalSamples", 0) == 0 ||
                              one.path.rfind(".geometry.widthSamples", 0) == 0 ||
                              one.path.rfind(".geometry.splatSamples", 0) == 0;
        EXPECT_EQ(MakeGeometryKey(one.value) != MakeGeometryKey(inputs), one.isInKey || isSample)
            << one.path;
    }
}

TEST(Fields, EachOfALightIsInTheTablesKey) {
    SceneDescription scene;
    LightPrim& prim = scene.lights["/L"];
    prim.light = FullLight(LightType::Dome);
    prim.portals.emplace_back();
    LightFilter filter;
    filter.node.identifier = "PxrBarnLightFilter";
    filter.node.parameters["width"] = 1.0;
    prim.filters.push_back(filter);
    CommitOptions options;
    std::vector<LightFilter> filters = prim.filters;
    const auto keyOf = [&](const LightDescription& light, std::vector<LightPortal> portals) {
        SceneDescription changed = scene;
        changed.lights["/L"].light = light;
        changed.lights["/L"].portals = std::move(portals);
        changed.lights["/L"].filters = filters;
        Warnings warnings;
        CommitCache cache(warnings);
        CommitScene(changed, options, &cache, warnings);
        return cache.lightKey;
    };
    const PageKey key = keyOf(prim.light, prim.portals);
    EXPECT_EQ(keyOf(prim.light, prim.portals), key);
    for (const auto& one : VariationsOf(prim.light)) {
        EXPECT_NE(keyOf(one.value, prim.portals), key) << one.path;
    }
    for (const auto& one : VariationsOf(prim.portals)) {
        EXPECT_NE(keyOf(prim.light, one.value), key) << one.path;
    }
    for (const auto& one : VariationsOf(prim.filters)) {
        filters = one.value;
        EXPECT_NE(keyOf(prim.light, prim.portals), key) << one.path;
    }
}

// Edits that leave what commits make of prims.

/// Whether a path is that of a member which begins with one of these.
bool BeginsWithAny(const std::string& path, const std::vector<std::string>& members) {
    return std::any_of(members.begin(), members.end(), [&path](const std::string& member) {
        return path.compare(0, member.size(), member) == 0;
    });
}

template <typename Prim>
void ExpectLeftBy(const Prim& before, const std::vector<std::string>& members,
                  const std::vector<std::string>& butNot = {}) {
    EXPECT_TRUE(LeavesPrims(before, before));
    std::size_t numLeft = 0;
    for (const auto& one : VariationsOf(before)) {
        const bool isLeft = BeginsWithAny(one.path, members) && !BeginsWithAny(one.path, butNot);
        EXPECT_EQ(LeavesPrims(before, one.value), isLeft) << one.path;
        numLeft += isLeft ? 1 : 0;
    }
    EXPECT_GT(numLeft, members.size()) << "their own members, too";
}

TEST(Fields, ValuesOfPointsAndVaryingPrimvarsLeaveAllButTheShape) {
    const GeometryPrim before = FullMeshPrim();
    for (const auto& one : VariationsOf(before)) { // arrays become longer
        EXPECT_EQ(LeavesAllButShape(before, one.value), LeavesPrims(before, one.value)) << one.path;
    }
    const auto with = [&before](const std::function<void(GeometryDescription*)>& change) {
        auto geometry = std::make_shared<GeometryDescription>(*before.geometry);
        geometry->primvars = {{"st", Interpolation::Vertex, 1, std::vector<float>{1, 2}, {}},
                              {"k", Interpolation::Constant, 1, std::vector<float>{3}, {}}};
        change(geometry.get());
        GeometryPrim prim = before;
        prim.geometry = std::move(geometry);
        return prim;
    };
    const GeometryPrim same = with([](GeometryDescription*) {});
    const auto isLeft = [&](const std::function<void(GeometryDescription*)>& change) {
        const GeometryPrim after = with(change);
        EXPECT_FALSE(LeavesPrims(same, after));
        return LeavesAllButShape(same, after);
    };
    EXPECT_TRUE(isLeft([](GeometryDescription* one) {
        one->points = std::vector<float>(one->points.size(), 9.0F);
    }));
    EXPECT_TRUE(isLeft([](GeometryDescription* one) {
        one->primvars[0].values = std::vector<float>{5, 6};
    }));
    EXPECT_FALSE(isLeft([](GeometryDescription* one) {
        one->primvars[0].values = std::vector<float>{5, 6, 7};
    }));
    EXPECT_FALSE(isLeft([](GeometryDescription* one) { // flags are such primvars
        one->primvars[1].values = std::vector<float>{4};
    }));
    EXPECT_FALSE(isLeft([](GeometryDescription* one) {
        one->primvars[0].indices = std::vector<std::int32_t>{1, 0};
    }));
    EXPECT_FALSE(LeavesAllButShape(GeometryPrim(), same)) << "there was nothing";
}

TEST(Fields, PlacesOfPrimsAndMostOfLightsLeavePrims) {
    const std::vector<std::string> places = {".placement.worldFromObject", ".placement.samples",
                                             ".placement.visible"};
    ExpectLeftBy(FullMeshPrim(), places);
    InstancerPrim instancer{Placed(), {}, {{0.0, {}}}, {}};
    instancer.primvars = FullMesh(PrimitiveKind::Faces).primvars;
    instancer.instanceTransforms.translations = std::vector<float>(6);
    ExpectLeftBy(instancer, {places[0], places[1], places[2], ".instanceTransforms", ".samples"},
                 {".instanceTransforms.matrices"}); // which count in place of the translations
    InstancerPrim more = instancer;
    more.instanceTransforms.translations = std::vector<float>(9);
    EXPECT_FALSE(LeavesPrims(instancer, more)) << "one instance more";
    ExpectLeftBy(LightPrim{Placed(), FullLight(LightType::Dome), {{}}, {}, {{}}, {{}}},
                 {places[0], places[1], ".light.", ".samples"},
                 {".light.type", ".light.textureFile", ".light.shadow", ".light.colorSpace"});
}

// The dump.

/// Paths of variations, and whether they were seen in the dump.
using Seen = std::map<std::string, bool>;

template <typename T, typename SetInScene>
void Dump(const T& value, const SetInScene& setInScene, std::uint32_t kind, Seen* seen) {
    SceneDescription scene;
    for (const char* path : {"/m", "/mx"}) {
        scene.materials[path] = std::make_shared<const MaterialNetwork>(FullMaterial());
    }
    setInScene(&scene, value);
    const std::string text = DumpScene(scene);
    for (const auto& one : VariationsOf(value)) {
        setInScene(&scene, one.value);
        const bool isShown = DumpScene(scene) != text;
        const bool isOfKind = (one.cases & 1U << kind) != 0;
        EXPECT_FALSE(isShown && !(one.isInDump && isOfKind)) << one.path << " of kind " << kind;
        if (one.isInDump) {
            (*seen)[one.path] = (*seen)[one.path] || isShown;
        }
    }
}

void ExpectAllSeen(const Seen& seen) {
    for (const auto& [path, isSeen] : seen) {
        EXPECT_TRUE(isSeen) << path;
    }
    EXPECT_FALSE(seen.empty());
}

TEST(Fields, EachOfAMeshIsInTheDump) {
    Seen seen;
    for (const auto& row : NamesOf(PrimitiveKind{})) {
        Dump(
            FullMesh(row.value),
            [](SceneDescription* scene, const GeometryDescription& mesh) {
                scene->geometry["/A"].geometry = std::make_shared<const GeometryDescription>(mesh);
            },
            static_cast<std::uint32_t>(row.value), &seen);
    }
    ExpectAllSeen(seen);
}

TEST(Fields, EachOfALightIsInTheDump) {
    Seen seen;
    for (const auto& row : NamesOf(LightType{})) {
        Dump(
            FullLight(row.value),
            [](SceneDescription* scene, const LightDescription& light) {
                scene->lights["/L"].light = light;
            },
            static_cast<std::uint32_t>(row.value), &seen);
    }
    ExpectAllSeen(seen);
}

TEST(Fields, EachOfAPrimIsInTheDump) {
    const auto expectSeen = [](const auto& value, auto member) {
        Seen seen;
        Dump(
            value,
            [member](SceneDescription* scene, const auto& prim) { (scene->*member)["/A"] = prim; },
            0, &seen);
        // What a mesh and a light have is for the tests above.
        Seen ofPrim;
        for (const auto& [path, isSeen] : seen) {
            bool& isAnySeen = ofPrim[path.substr(0, path.find('.', 1))];
            const bool isOwn = path.rfind(".geometry.", 0) != 0 && path.rfind(".light.", 0) != 0;
            EXPECT_TRUE(isSeen || !isOwn) << path;
            isAnySeen = isAnySeen || isSeen;
        }
        ExpectAllSeen(ofPrim);
    };
    expectSeen(FullMeshPrim(), &SceneDescription::geometry);
    expectSeen(InstancerPrim{Placed(), {}, {{0.0, {}}}, {}}, &SceneDescription::instancers);
    expectSeen(FullCamera(), &SceneDescription::cameras);
}

TEST(Fields, EachOfAPlacedLightIsInTheDump) {
    Seen seen;
    LightFilter filter;
    filter.node.parameters["width"] = 1.0;
    filter.node.connections["map"] = {"/F/Texture", "out"};
    Dump(
        std::vector<LightFilter>{filter},
        [](SceneDescription* scene, const std::vector<LightFilter>& filters) {
            scene->lights["/L"].filters = filters;
        },
        0, &seen);
    Dump(
        std::vector<LightPortal>(1),
        [](SceneDescription* scene, const std::vector<LightPortal>& portals) {
            scene->lights["/L"].portals = portals;
        },
        0, &seen);
    Dump(
        Placed(),
        [](SceneDescription* scene, const Placement& placement) {
            scene->lights["/L"].placement = placement;
        },
        0, &seen);
    ExpectAllSeen(seen);
}

TEST(Fields, EachOfAMaterialIsInTheDump) {
    Seen seen;
    Dump(
        FullMaterial(),
        [](SceneDescription* scene, const MaterialNetwork& network) {
            scene->geometry["/A"].geometry = std::make_shared<const GeometryDescription>();
            scene->geometry["/A"].materialPath = "/m";
            scene->materials["/m"] = std::make_shared<const MaterialNetwork>(network);
        },
        0, &seen);
    ExpectAllSeen(seen);
}

// Enums.

template <auto Value>
constexpr const char* Signature() {
    return __PRETTY_FUNCTION__; // ends in "LightType::Mesh]", or in "(LightType)7]" if there is
                                // none
}

template <typename Enum, std::size_t... Index>
void ExpectTable(std::index_sequence<Index...>) {
    constexpr auto kTable = NamesOf(Enum{});
    const std::string_view signatures[] = {Signature<static_cast<Enum>(Index)>()...};
    std::set<std::string> texts;
    for (std::size_t i = 0; i < kTable.size(); ++i) {
        const std::string end = "::" + std::string(kTable[i].name) + "]";
        EXPECT_EQ(signatures[i].substr(signatures[i].size() - end.size()), end);
        EXPECT_TRUE(texts.insert(kTable[i].text).second) << kTable[i].text;
    }
    constexpr std::string_view kNext = Signature<static_cast<Enum>(kTable.size())>();
    static_assert(kNext[kNext.size() - 2] >= '0' && kNext[kNext.size() - 2] <= '9',
                  "an enumerator that the table lacks");
}

template <typename Enum>
void ExpectTableOf() {
    ExpectTable<Enum>(std::make_index_sequence<NamesOf(Enum{}).size()>());
}

TEST(Fields, TablesOfEnumsAreWhole) {
    ExpectTableOf<Interpolation>();
    ExpectTableOf<PrimitiveKind>();
    ExpectTableOf<LightType>();
    ExpectTableOf<MaterialSyncMode>();
    ExpectTableOf<CullStyle>();
}

} // namespace
} // namespace hds
