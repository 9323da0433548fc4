// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/instancePrimvars.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Each group is planned as a prim of its own.
constexpr std::size_t kMaxGroups = 64;

bool HasRow(const hds::Primvar& primvar, std::int32_t index) {
    return index >= 0 &&
           (static_cast<std::size_t>(index) + 1) * primvar.numComponents <= primvar.values.size();
}

const float* Row(const hds::Primvar& primvar, std::int32_t index) {
    return primvar.values.data() + static_cast<std::size_t>(index) * primvar.numComponents;
}

std::size_t RowBytes(const hds::Primvar& primvar) {
    return primvar.numComponents * sizeof(float);
}

/// The value of one instance, for all of a gprim.
hds::Primvar ConstantFrom(const hds::Primvar& primvar, std::int32_t index) {
    const float* row = Row(primvar, index);
    hds::Primvar constant;
    constant.name = primvar.name;
    constant.numComponents = primvar.numComponents;
    constant.values = std::vector<float>(row, row + primvar.numComponents);
    return constant;
}

bool HasSameRow(const hds::Primvar& primvar, std::int32_t a, std::int32_t b) {
    return std::memcmp(Row(primvar, a), Row(primvar, b), RowBytes(primvar)) == 0;
}

/// The first of some instances that has a value; -1 when none has.
std::int32_t FirstIndex(const hds::Primvar& primvar,
                        const hds::SharedSpan<std::int32_t>& instances) {
    const auto* found = std::find_if(instances.begin(), instances.end(),
                                     [&](std::int32_t index) { return HasRow(primvar, index); });
    return found == instances.end() ? -1 : *found;
}

/// Whether those of some instances that have a value have the bits of that of `first`.
bool AreEqual(const hds::Primvar& primvar, const hds::SharedSpan<std::int32_t>& instances,
              std::int32_t first) {
    return std::all_of(instances.begin(), instances.end(), [&](std::int32_t index) {
        return !HasRow(primvar, index) || HasSameRow(primvar, index, first);
    });
}

/// Groups instances by the values of one level.
class Grouping {
public:
    explicit Grouping(std::vector<const hds::Primvar*> primvars) : _primvars(std::move(primvars)) {}

    /// \return false when there are too many groups.
    bool Read(const hds::SharedSpan<std::int32_t>& instances) {
        _groupByRank.resize(instances.size(), 0);
        for (std::size_t rank = 0; rank < instances.size(); ++rank) {
            if (!SetKey(instances[rank])) {
                continue; // the core drops an instance that does not exist, whatever its group
            }
            const auto [found, isNew] = _groupByKey.try_emplace(_key, _firstIndices.size());
            if (isNew) {
                if (_firstIndices.size() == kMaxGroups) {
                    return false;
                }
                _firstIndices.push_back(instances[rank]);
            }
            _groupByRank[rank] = found->second;
        }
        return true;
    }

    std::vector<HdStreamInstanceGroup>
    Groups(const hds::SharedSpan<std::int32_t>& instances) const {
        std::vector<HdStreamInstanceGroup> groups(std::max<std::size_t>(_firstIndices.size(), 1));
        for (std::size_t i = 0; i < _firstIndices.size(); ++i) {
            for (const hds::Primvar* primvar : _primvars) {
                groups[i].primvars.push_back(ConstantFrom(*primvar, _firstIndices[i]));
            }
        }
        if (groups.size() == 1) {
            groups[0].instances = instances;
            return groups;
        }
        for (std::size_t i = 0; i < groups.size(); ++i) {
            std::vector<std::int32_t> members(instances.size(), -1);
            for (std::size_t rank = 0; rank < members.size(); ++rank) {
                if (_groupByRank[rank] == i) {
                    members[rank] = instances[rank];
                }
            }
            groups[i].instances = std::move(members);
        }
        return groups;
    }

private:
    bool SetKey(std::int32_t index) {
        _key.clear();
        for (const hds::Primvar* primvar : _primvars) {
            if (!HasRow(*primvar, index)) {
                return false;
            }
            _key.append(reinterpret_cast<const char*>(Row(*primvar, index)), RowBytes(*primvar));
        }
        return true;
    }

    std::vector<const hds::Primvar*> _primvars;
    std::string _key;
    std::unordered_map<std::string, std::size_t> _groupByKey;
    std::vector<std::int32_t> _firstIndices; ///< an instance of each group
    std::vector<std::size_t> _groupByRank;
};

} // namespace

HdStreamInstanceGroups HdStreamGroupInstances(const HdStreamInstanceLevels& levels,
                                              const hds::SharedSpan<std::int32_t>& instances,
                                              const std::vector<hds::Primvar>& own) {
    HdStreamInstanceGroups result;
    std::set<std::string> names;
    for (const hds::Primvar& primvar : own) {
        names.insert(primvar.name);
    }
    std::vector<const hds::Primvar*> splitting;
    std::vector<hds::Primvar> shared;
    for (std::size_t i = 0; i < levels.size(); ++i) {
        const hds::SharedSpan<std::int32_t>& placements =
            i == 0 ? instances : levels[i - 1]->placements;
        for (const hds::Primvar& primvar : levels[i]->primvars) {
            const std::int32_t first = FirstIndex(primvar, placements);
            if (first < 0 || !names.insert(primvar.name).second) {
                continue;
            }
            if (AreEqual(primvar, placements, first)) {
                shared.push_back(ConstantFrom(primvar, first));
            } else if (hds::IsReadByPrim(primvar.name)) {
                if (i == 0) {
                    splitting.push_back(&primvar);
                } else {
                    shared.push_back(ConstantFrom(primvar, first));
                    result.variesAbove = true;
                }
            }
        }
    }
    result.groups = {{shared, instances}};
    if (splitting.empty()) {
        return result;
    }
    Grouping grouping(std::move(splitting));
    if (!grouping.Read(instances)) {
        result.hasTooMany = true;
        return result;
    }
    result.groups = grouping.Groups(instances);
    for (HdStreamInstanceGroup& group : result.groups) {
        group.primvars.insert(group.primvars.end(), shared.begin(), shared.end());
    }
    return result;
}

std::vector<hds::Primvar> HdStreamInstancerPrimvars(const std::vector<hds::Primvar>& primvars) {
    std::vector<hds::Primvar> different;
    std::copy_if(primvars.begin(), primvars.end(), std::back_inserter(different),
                 [](const hds::Primvar& primvar) {
                     const auto count =
                         static_cast<std::int32_t>(primvar.values.size() / primvar.numComponents);
                     bool areEqual = true;
                     for (std::int32_t i = 1; areEqual && i < count; ++i) {
                         areEqual = HasSameRow(primvar, i, 0);
                     }
                     return !areEqual && !hds::IsReadByPrim(primvar.name);
                 });
    return different;
}

PXR_NAMESPACE_CLOSE_SCOPE
