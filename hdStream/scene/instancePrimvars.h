// SPDX-License-Identifier: Apache-2.0
// Primvars with a value an instance: tables by the rank of an instance, beside geometry that all
// instances share. Explained in docs/geometry.md.
#pragma once

#include "hdStream/base/hugePages.h"
#include "hdStream/base/log.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/shading/materialCompiler.h"
#include "kernels/shared/geometry.h"

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace hds {

/// The device tables; empty where no prim reads a value of its instances.
struct InstancePrimvars {
    std::vector<std::uint32_t> firstSlots;         ///< of each prim its first in `slots`
    std::vector<shared::HdsInstanceSlot> slots;    ///< of all prims
    HugeVector<float> values;                      ///< of each slot [numRows][numComponents]
    std::vector<std::vector<AttributeName>> names; ///< of the slots of each prim, in their order

    std::uint64_t Bytes() const {
        return firstSlots.size() * sizeof(firstSlots[0]) + slots.size() * sizeof(slots[0]) +
               values.size() * sizeof(values[0]);
    }
};

/// Collects them prim by prim. Externally synchronised. The scene must outlive it.
class InstancePrimvarCollector {
public:
    InstancePrimvarCollector(const SceneDescription& scene, Warnings& warnings);

    /// Whether there is anything to collect.
    bool HasAny() const { return _hasAny; }

    /// Adds the next prim. \param asked names that its materials or AOVs read. \return those which
    /// its instancers have and it has not, in the order of their slots; valid until the next prim.
    const std::vector<AttributeName>& Add(const GeometryPrim& prim,
                                          const std::vector<const std::set<std::string>*>& asked,
                                          const std::vector<std::string>& shown);

    /// Moves the tables out.
    InstancePrimvars Take();

private:
    /// Values in the order of a list of instances.
    struct Rows {
        SharedSpan<std::int32_t> instances;
        std::uint32_t firstValue;
    };

    /// Whether a primvar of an instancer has as many values as that has instances; else it warns.
    bool IsComplete(const Primvar& primvar, const std::string& path,
                    const InstancerPrim& instancer);
    void AddLevel(const std::string& path, const InstancerPrim& instancer,
                  const SharedSpan<std::int32_t>& instances, std::uint64_t divisor,
                  std::set<std::string>* wanted, std::vector<AttributeName>* names);
    /// The index of the first value; HDS_NONE when the table would grow too large.
    std::uint32_t FirstValue(const std::string& path, const Primvar& primvar,
                             const SharedSpan<std::int32_t>& instances);

    const SceneDescription& _scene;
    Warnings& _warnings;
    bool _hasAny = false;
    InstancePrimvars _result;
    std::map<std::pair<std::string, std::string>, std::vector<Rows>> _rows; ///< by path and name
    const std::vector<AttributeName> _none;
};

} // namespace hds
