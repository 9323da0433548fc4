// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/rayVisibility.h"

#include <algorithm>
#include <string>

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
    {"hdstream:holdout", HDS_INSTANCE_HOLDOUT},
};

/// Few prims have such primvars, and commits ask all of them.
bool MaySay(const Primvar& primvar) {
    return SaysVisibility(primvar.name);
}

} // namespace

bool SaysVisibility(const std::string& name) {
    return name.compare(0, 9, "hdstream:") == 0 || name.compare(0, 7, "arnold:") == 0 ||
           name.compare(0, 14, "ri:attributes:") == 0;
}

std::uint32_t RayVisibilityFlags(const std::vector<Primvar>& primvars) {
    std::uint32_t flags = HDS_INSTANCE_SEEN;
    if (std::none_of(primvars.begin(), primvars.end(), MaySay)) {
        return flags;
    }
    for (const Row& row : kRows) {
        const auto found =
            std::find_if(primvars.begin(), primvars.end(),
                         [&row](const Primvar& primvar) { return primvar.name == row.name; });
        if (found != primvars.end() && found->interpolation == Interpolation::Constant &&
            found->values.size() == 1) {
            flags = found->values[0] != 0.0F ? flags | row.flags : flags & ~row.flags;
        }
    }
    return flags;
}

} // namespace hds
