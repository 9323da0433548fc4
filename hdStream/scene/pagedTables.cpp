// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/pagedTables.h"

#include "hdStream/base/error.h"
#include "kernels/shared/instanceChunk.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <string>
#include <unordered_map>
#include <utility>

namespace hds {

namespace {

using Numbers = std::vector<std::uint32_t>;

/// Drops objects of one chunk, and those of none, which nobody places. \return the numbers of all,
/// by those of before.
Numbers DropObjects(std::vector<shared::HdsObject>* objects) {
    constexpr std::uint32_t kMaxNumber = 1U << HDS_OBJECT_NUMBER_SHIFT;
    Numbers numbers(objects->size(), HDS_NONE);
    std::uint32_t numKept = 0;
    for (std::size_t i = 0; i < objects->size(); ++i) {
        const shared::HdsObject object = (*objects)[i];
        const bool isChunk = object.kind == HDS_OBJECT_CHUNK || object.kind == HDS_OBJECT_INSTANCES;
        if (!isChunk) {
            (*objects)[numKept] = object;
            numbers[i] = numKept++;
        } else if (object.numItems == 1) {
            HDS_VERIFY(object.itemBase < kMaxNumber - 1, std::to_string(object.itemBase));
            numbers[i] = object.kind << HDS_OBJECT_NUMBER_SHIFT | object.itemBase;
        }
    }
    objects->resize(numKept);
    objects->shrink_to_fit();
    return numbers;
}

/// The prims in a new order: those that records in the table name, then all others, both as they
/// were. \param[out] numNamed of the first.
Numbers OrderOfPrims(const CommittedScene& scene, std::uint32_t* numNamed) {
    std::vector<bool> isNamed(scene.prims.size(), false);
    for (const shared::HdsInstance& record : scene.instances) {
        if (record.prim != HDS_NONE) {
            isNamed[record.prim] = true;
        }
    }
    Numbers order(scene.prims.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto named = std::stable_partition(order.begin(), order.end(),
                                             [&](std::uint32_t prim) { return isNamed[prim]; });
    *numNamed = static_cast<std::uint32_t>(named - order.begin());
    return order;
}

/// Where elements have gone that are in an order now.
Numbers NumbersOf(const Numbers& order) {
    Numbers numbers(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        numbers[order[i]] = i;
    }
    return numbers;
}

/// Nothing where there is nothing.
template <typename T>
void Reorder(const Numbers& order, std::vector<T>* values) {
    if (values->empty()) {
        return;
    }
    std::vector<T> reordered;
    reordered.reserve(order.size());
    for (const std::uint32_t i : order) {
        reordered.push_back(std::move((*values)[i]));
    }
    *values = std::move(reordered);
}

/// Lets prims of one material name it, whose entries come behind all others and leave the table.
void MoveMaterials(CommittedScene* scene) {
    const auto numEntries = static_cast<std::uint32_t>(scene->primMaterials.size());
    if (scene->materials.size() >= HDS_PRIM_MAX_MATERIALS) {
        return;
    }
    // In the order of prims, each entry belongs to the last prim that begins at or before it.
    std::vector<shared::HdsPrim>& prims = scene->prims;
    Numbers order;
    order.reserve(numEntries);
    Numbers ones; // their entries
    for (std::size_t i = 0; i < prims.size(); ++i) {
        const std::uint32_t first = prims[i].materialBase;
        const std::uint32_t end = i + 1 < prims.size() ? prims[i + 1].materialBase : numEntries;
        if (end - first == 1) {
            prims[i].flags |= HDS_PRIM_ONE_MATERIAL | scene->primMaterials[first]
                                                          << HDS_PRIM_MATERIAL_SHIFT;
            ones.push_back(first);
            continue;
        }
        for (std::uint32_t entry = first; entry < end; ++entry) {
            order.push_back(entry);
        }
    }
    const std::size_t numLeft = order.size();
    order.insert(order.end(), ones.begin(), ones.end());
    const Numbers numbers = NumbersOf(order);
    for (shared::HdsPrim& prim : prims) {
        prim.materialBase = prim.materialBase < numEntries ? numbers[prim.materialBase] : 0;
    }
    Reorder(order, &scene->primMaterials);
    scene->primMaterials.resize(numLeft);
    scene->primMaterials.shrink_to_fit();
    if (!scene->entryMaterials.empty()) {
        scene->authoredEntries = std::move(order);
    }
}

void Renumber(const PagedTables& tables, shared::HdsInstance* record) {
    record->object = tables.objectNumbers[record->object];
    record->prim = record->prim == HDS_NONE ? HDS_NONE : tables.primNumbers[record->prim];
}

} // namespace

PagedTables TakeFromTables(CommittedScene* scene) {
    MoveMaterials(scene);
    PagedTables tables;
    tables.objectNumbers = DropObjects(&scene->objects);
    std::uint32_t numNamed = 0;
    Numbers order = OrderOfPrims(*scene, &numNamed);
    tables.primNumbers = NumbersOf(order);
    for (shared::HdsInstance& record : scene->instances) {
        Renumber(tables, &record);
    }
    Reorder(order, &scene->primAttributes);
    Reorder(order, &scene->instancePrimvars.firstSlots);
    Reorder(order, &scene->instancePrimvars.names);
    Reorder(order, &scene->prims);
    tables.prims = std::move(scene->prims);
    scene->prims.assign(tables.prims.begin(), tables.prims.begin() + numNamed);
    if (!scene->primPaths.empty()) {
        scene->authoredPrims = std::move(order);
    }
    return tables;
}

/// No more prims than records.
std::array<std::uint64_t, 2> PagedInstances::BoundBytes(std::uint32_t chunk) const {
    std::array<std::uint64_t, 2> bytes = _records->BoundBytes(chunk);
    bytes[HDS_PAGE_GEOMETRY] +=
        std::min<std::uint64_t>(_numPrims, _records->NumRecords(chunk)) * sizeof(shared::HdsPrim);
    return bytes;
}

ChunkBytes PagedInstances::Make(std::uint32_t chunk) const {
    ChunkBytes pages = _records->Make(chunk);
    std::vector<std::uint8_t>& page = pages[HDS_PAGE_GEOMETRY];
    shared::HdsPageHeader header{};
    std::memcpy(&header, page.data(), sizeof(header));
    header.primIds = _tables->objectNumbers[header.primIds];
    header.vertices = static_cast<std::uint32_t>(page.size() / HDS_POOL_UNIT_BYTES);
    std::memcpy(page.data(), &header, sizeof(header));
    const std::uint32_t count = header.numTriangles & ((1U << HDS_PRIMITIVE_SHIFT) - 1U);
    auto* records = reinterpret_cast<shared::HdsInstance*>(
        page.data() + std::size_t{header.triangles} * HDS_POOL_UNIT_BYTES);
    std::vector<shared::HdsPrim> prims;
    std::unordered_map<std::uint32_t, std::uint32_t> placeOf;
    for (std::uint32_t i = 0; i < count; ++i) {
        Renumber(*_tables, &records[i]);
        if (records[i].prim == HDS_NONE) {
            continue;
        }
        const auto [found, isNew] =
            placeOf.emplace(records[i].prim, static_cast<std::uint32_t>(prims.size()));
        if (isNew) {
            prims.push_back(_tables->prims[records[i].prim]);
        }
        records[i].lightBase = found->second;
    }
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(prims.data());
    page.insert(page.end(), bytes, bytes + prims.size() * sizeof(shared::HdsPrim));
    return pages;
}

} // namespace hds
