// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/rayVisibility.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace hds {

namespace {

/// A primvar and the flags that it sets or clears.
struct Row {
    const char* name;
    std::uint32_t flags;
};

/// Later ones win.
const Row kRows[] = {
    {"arnold:visibility:camera", HDS_INSTANCE_CAMERA},
    {"arnold:visibility:shadow", HDS_INSTANCE_SHADOW},
    {"arnold:visibility:diffuse_reflect", HDS_INSTANCE_DIFFUSE},
    {"arnold:visibility:specular_reflect", HDS_INSTANCE_REFLECTION},
    {"arnold:visibility:specular_transmit", HDS_INSTANCE_TRANSMISSION},
    {"arnold:matte", HDS_INSTANCE_HOLDOUT},
    {"ri:attributes:visibility:camera", HDS_INSTANCE_CAMERA},
    {"ri:attributes:visibility:transmission", HDS_INSTANCE_SHADOW}, // RenderMan's shadow rays
    {"ri:attributes:visibility:indirect",
     HDS_INSTANCE_DIFFUSE | HDS_INSTANCE_REFLECTION | HDS_INSTANCE_TRANSMISSION},
    {"ri:attributes:trace:holdout", HDS_INSTANCE_HOLDOUT},
    {"hdstream:visibility:camera", HDS_INSTANCE_CAMERA},
    {"hdstream:visibility:shadow", HDS_INSTANCE_SHADOW},
    {"hdstream:visibility:diffuse", HDS_INSTANCE_DIFFUSE},
    {"hdstream:visibility:reflection", HDS_INSTANCE_REFLECTION},
    {"hdstream:visibility:transmission", HDS_INSTANCE_TRANSMISSION},
    {"cycles:object:is_shadow_catcher", HDS_INSTANCE_CATCHER},
    {"hdstream:holdout", HDS_INSTANCE_HOLDOUT},
    {"hdstream:shadowCatcher", HDS_INSTANCE_CATCHER},
};

struct KarmaRays {
    const char* name;
    std::uint32_t flags;
};

const KarmaRays kKarmaRays[] = {
    {"primary", HDS_INSTANCE_CAMERA},       {"shadow", HDS_INSTANCE_SHADOW},
    {"diffuse", HDS_INSTANCE_DIFFUSE},      {"reflect", HDS_INSTANCE_REFLECTION},
    {"refract", HDS_INSTANCE_TRANSMISSION}, {"*", HDS_INSTANCE_SEEN},
};

/// Flags of the rays that a term of an expression names, without blanks.
std::optional<std::uint32_t> FlagsOfTerm(std::string term) {
    const bool isAllBut = !term.empty() && term[0] == '-';
    term.erase(0, isAllBut ? 1 : 0);
    for (const KarmaRays& rays : kKarmaRays) {
        if (term == rays.name) {
            return isAllBut ? HDS_INSTANCE_SEEN & ~rays.flags : rays.flags;
        }
    }
    return std::nullopt;
}

/// Karma's: 1 cuts the prim out of the picture, 2 shows what is behind the picture, and shadows.
const char* const kHoldoutMode = "karma:object:holdoutmode";

std::uint32_t FlagsOfHoldoutMode(float mode) {
    return mode == 1.0F ? HDS_INSTANCE_HOLDOUT : mode == 2.0F ? HDS_INSTANCE_CATCHER : 0U;
}

/// What a render pass says, which takes away alone: 0: the camera does not see it; 1: it is held
/// out.
const char* const kPassCamera = "hdstream:pass:camera";
const char* const kPassMatte = "hdstream:pass:matte";

/// The one number of a primvar; null when there is none.
const float* NumberOf(const std::vector<Primvar>& primvars, const char* name) {
    const auto found =
        std::find_if(primvars.begin(), primvars.end(),
                     [name](const Primvar& primvar) { return primvar.name == name; });
    const bool isNumber = found != primvars.end() &&
                          found->interpolation == Interpolation::Constant &&
                          found->values.size() == 1;
    return isNumber ? found->values.data() : nullptr;
}

/// Few prims have such primvars, and commits ask all of them.
bool MaySay(const Primvar& primvar) {
    return IsInObjectNamespace(primvar.name);
}

/// Primvars of an instancer that say something of instances of a prim which says nothing itself.
std::vector<const Primvar*> ByInstance(const InstancerPrim& instancer, const GeometryPrim& prim) {
    const std::size_t numInstances = instancer.instanceTransforms.Size();
    const std::vector<Primvar>& own = prim.geometry->primvars;
    std::vector<const Primvar*> found;
    for (const Primvar& primvar : instancer.primvars) {
        const bool isOwn = std::any_of(own.begin(), own.end(), [&primvar](const Primvar& other) {
            return other.name == primvar.name;
        });
        if (!isOwn && SaysRayVisibility(primvar.name) && primvar.numComponents == 1 &&
            primvar.indices.empty() && primvar.values.size() == numInstances) {
            found.push_back(&primvar);
        }
    }
    return found;
}

} // namespace

bool SaysRayVisibility(const std::string& name) {
    return name == kKarmaVisibility || name == kHoldoutMode || name == kPassCamera ||
           name == kPassMatte ||
           std::any_of(std::begin(kRows), std::end(kRows),
                       [&name](const Row& row) { return name == row.name; });
}

bool IsInObjectNamespace(const std::string& name) {
    const char* const prefixes[] = {
        "hdstream:", "arnold:", "ri:attributes:", "karma:object:", "cycles:object:"};
    return std::any_of(std::begin(prefixes), std::end(prefixes), [&name](const char* prefix) {
        return name.compare(0, std::strlen(prefix), prefix) == 0;
    });
}

float KarmaVisibilityNumber(const std::string& expression) {
    std::string text = expression;
    text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return c == ' '; }),
               text.end());
    std::uint32_t flags = 0;
    std::uint32_t group = HDS_INSTANCE_SEEN; // of terms that `&` joins
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find_first_of("&|", at), text.size());
        const std::optional<std::uint32_t> term = FlagsOfTerm(text.substr(at, end - at));
        if (!term || end + 1 == text.size()) {
            return -1.0F;
        }
        group &= *term;
        if (end == text.size() || text[end] == '|') {
            flags |= group;
            group = HDS_INSTANCE_SEEN;
        }
        at = end + 1;
    }
    return static_cast<float>(flags);
}

std::uint32_t RayVisibilityFlags(const std::vector<Primvar>& primvars, bool* isUnreadable) {
    std::uint32_t flags = HDS_INSTANCE_SEEN;
    if (std::none_of(primvars.begin(), primvars.end(), MaySay)) {
        return flags;
    }
    if (const float* rays = NumberOf(primvars, kKarmaVisibility)) {
        if (*rays >= 0.0F) {
            flags = static_cast<std::uint32_t>(*rays) & HDS_INSTANCE_SEEN;
        } else if (isUnreadable != nullptr) {
            *isUnreadable = true;
        }
    }
    if (const float* mode = NumberOf(primvars, kHoldoutMode)) {
        flags |= FlagsOfHoldoutMode(*mode);
    }
    for (const Row& row : kRows) {
        if (const float* number = NumberOf(primvars, row.name)) {
            flags = *number != 0.0F ? flags | row.flags : flags & ~row.flags;
        }
    }
    if (const float* isSeen = NumberOf(primvars, kPassCamera); isSeen && *isSeen == 0.0F) {
        flags &= ~static_cast<std::uint32_t>(HDS_INSTANCE_CAMERA);
    }
    if (const float* isMatte = NumberOf(primvars, kPassMatte); isMatte && *isMatte != 0.0F) {
        flags |= HDS_INSTANCE_HOLDOUT;
    }
    return flags;
}

std::vector<InstancesSeen> RayVisibilityByInstance(const SceneDescription& scene,
                                                   const GeometryPrim& prim, bool* isUnreadable) {
    const SharedSpan<std::int32_t>& instances = prim.placement.instances;
    const auto instancer = scene.instancers.find(prim.placement.instancerPath);
    if (instancer == scene.instancers.end()) {
        return {};
    }
    const std::vector<const Primvar*> byInstance = ByInstance(instancer->second, prim);
    if (byInstance.empty()) {
        return {};
    }
    const std::size_t numInstances = instancer->second.instanceTransforms.Size();
    std::vector<Primvar> primvars = prim.geometry->primvars;
    const std::size_t numOwn = primvars.size();
    std::map<std::vector<std::uint32_t>, std::size_t> groupOfRow;
    std::vector<std::pair<std::uint32_t, std::vector<std::int32_t>>> groups; // flags, instances
    std::vector<std::uint32_t> row(byInstance.size());
    for (std::size_t rank = 0; rank < instances.size(); ++rank) {
        if (instances[rank] < 0 || static_cast<std::size_t>(instances[rank]) >= numInstances) {
            continue;
        }
        const auto index = static_cast<std::size_t>(instances[rank]);
        for (std::size_t i = 0; i < row.size(); ++i) {
            std::memcpy(&row[i], &byInstance[i]->values[index], sizeof(row[i]));
        }
        const auto [known, isNew] = groupOfRow.emplace(row, groups.size());
        if (isNew) {
            primvars.resize(numOwn);
            for (const Primvar* primvar : byInstance) {
                primvars.push_back({primvar->name,
                                    Interpolation::Constant,
                                    1,
                                    std::vector<float>{primvar->values[index]},
                                    {}});
            }
            const std::uint32_t flags = RayVisibilityFlags(primvars, isUnreadable);
            const auto same = std::find_if(groups.begin(), groups.end(),
                                           [flags](const auto& one) { return one.first == flags; });
            known->second = static_cast<std::size_t>(same - groups.begin());
            if (same == groups.end()) {
                groups.emplace_back(flags, std::vector<std::int32_t>(instances.size(), -1));
            }
        }
        groups[known->second].second[rank] = instances[rank];
    }
    std::vector<InstancesSeen> result;
    for (auto& [flags, members] : groups) {
        result.push_back({flags, std::move(members)});
    }
    return result;
}

} // namespace hds
