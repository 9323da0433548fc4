// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/instancePrimvars.h"

#include "hdStream/scene/rayVisibility.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace hds {

namespace {

/// Longer chains of instancers are cycles in all likelihood.
constexpr int kMaxChain = 64;
constexpr std::size_t kBlock = 16384; ///< rows that are copied at a time

bool HasOwn(const GeometryPrim& prim, const std::string& name) {
    const std::vector<Primvar>& own = prim.geometry->primvars;
    return std::any_of(own.begin(), own.end(),
                       [&name](const Primvar& primvar) { return primvar.name == name; });
}

} // namespace

bool IsReadByPrim(const std::string& primvar) {
    return primvar == "widths" || primvar == "normals" ||
           (IsInObjectNamespace(primvar) && !SaysRayVisibility(primvar));
}

InstancePrimvarCollector::InstancePrimvarCollector(const SceneDescription& scene,
                                                   Warnings& warnings)
    : _scene(scene), _warnings(warnings) {
    _hasAny = std::any_of(scene.instancers.begin(), scene.instancers.end(),
                          [](const auto& entry) { return !entry.second.primvars.empty(); });
}

bool InstancePrimvarCollector::IsComplete(const Primvar& primvar, const std::string& path,
                                          const InstancerPrim& instancer) {
    const std::size_t numInstances = instancer.instanceTransforms.Size();
    const bool isComplete = primvar.numComponents >= 1 && primvar.numComponents <= 4 &&
                            primvar.indices.empty() &&
                            primvar.values.size() == numInstances * primvar.numComponents;
    if (!isComplete) {
        _warnings.Add(path, "primvar " + primvar.name + " has " +
                                std::to_string(primvar.values.size()) + " numbers for " +
                                std::to_string(numInstances) + " instances; ignored");
    }
    return isComplete;
}

std::uint32_t InstancePrimvarCollector::FirstValue(const std::string& path, const Primvar& primvar,
                                                   const SharedSpan<std::int32_t>& instances) {
    std::vector<Rows>& known = _rows[{path, primvar.name}];
    for (const Rows& rows : known) {
        if (rows.instances == instances) {
            return rows.firstValue;
        }
    }
    const std::size_t first = _result.values.size();
    const std::uint32_t width = primvar.numComponents;
    const std::size_t end = first + instances.size() * width;
    if (end > std::numeric_limits<std::uint32_t>::max()) {
        _warnings.Add(path, "more than 2^32 numbers of primvars of instances; " + primvar.name +
                                " is ignored");
        return HDS_NONE;
    }
    _result.values.resize(end);
    float* target = _result.values.data() + first;
    const auto count = primvar.values.size() / width;
    tbb::parallel_for(
        std::size_t{0}, (instances.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
            const std::size_t blockEnd = std::min(instances.size(), (block + 1) * kBlock);
            for (std::size_t rank = block * kBlock; rank < blockEnd; ++rank) {
                const std::int32_t index = instances[rank];
                const bool isThere = index >= 0 && static_cast<std::size_t>(index) < count;
                for (std::uint32_t k = 0; k < width; ++k) {
                    target[rank * width + k] =
                        isThere ? primvar.values[static_cast<std::size_t>(index) * width + k]
                                : 0.0F; // of an instance that is not there
                }
            }
        });
    known.push_back({instances, static_cast<std::uint32_t>(first)});
    return known.back().firstValue;
}

void InstancePrimvarCollector::AddLevel(const std::string& path, const InstancerPrim& instancer,
                                        const SharedSpan<std::int32_t>& instances,
                                        std::uint64_t divisor, std::set<std::string>* wanted,
                                        std::vector<AttributeName>* names) {
    for (const Primvar& primvar : instancer.primvars) {
        const auto found = wanted->find(primvar.name);
        if (found == wanted->end() || !IsComplete(primvar, path, instancer)) {
            continue;
        }
        wanted->erase(found); // the inner instancer's counts
        const std::uint32_t firstValue = FirstValue(path, primvar, instances);
        if (firstValue != HDS_NONE) {
            shared::HdsInstanceSlot slot{};
            slot.numComponents = primvar.numComponents;
            slot.numRows = static_cast<std::uint32_t>(instances.size());
            slot.divisor[0] = static_cast<std::uint32_t>(divisor);
            slot.divisor[1] = static_cast<std::uint32_t>(divisor >> 32U);
            slot.firstValue = firstValue;
            _result.slots.push_back(slot);
            names->push_back({primvar.name, primvar.numComponents});
        }
    }
}

const std::vector<AttributeName>&
InstancePrimvarCollector::Add(const GeometryPrim& prim,
                              const std::vector<const std::set<std::string>*>& asked,
                              const std::vector<std::string>& shown) {
    if (!_hasAny) {
        return _none;
    }
    _result.firstSlots.push_back(static_cast<std::uint32_t>(_result.slots.size()));
    std::vector<AttributeName>& names = _result.names.emplace_back();
    std::set<std::string> wanted(shown.begin(), shown.end());
    for (const std::set<std::string>* of : asked) {
        wanted.insert(of->begin(), of->end());
    }
    for (auto name = wanted.begin(); name != wanted.end();) {
        name = HasOwn(prim, *name) ? wanted.erase(name) : std::next(name);
    }
    std::uint64_t divisor = 1;
    const Placement* placement = &prim.placement;
    for (int chain = 0; chain < kMaxChain && !placement->instancerPath.empty(); ++chain) {
        const auto found = _scene.instancers.find(placement->instancerPath);
        if (wanted.empty() || found == _scene.instancers.end() || placement->instances.empty()) {
            break;
        }
        AddLevel(found->first, found->second, placement->instances, divisor, &wanted, &names);
        divisor *= placement->instances.size();
        placement = &found->second.placement;
    }
    return names;
}

InstancePrimvars InstancePrimvarCollector::Take() {
    if (_result.slots.empty()) { // nobody reads any
        return {};
    }
    return std::move(_result);
}

} // namespace hds
