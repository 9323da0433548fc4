// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/aovSources.h"

#include "hdStream/film/aov.h"

#include <utility>

namespace hds {

std::string AovOfSource(const std::string& sourceName) {
    static const std::pair<const char*, const char*> kAliases[] = {
        {"Ci", "color"},   {"rgba", "color"}, {"RGBA", "color"},     {"beauty", "color"},
        {"a", "alpha"},    {"z", "depth"},    {"N", "normal"},       {"Nn", "normal"},
        {"P", "position"}, {"id", "primId"},  {"st", "primvars:st"}, {"uv", "primvars:st"},
    };
    if (HasAov(sourceName)) {
        return sourceName;
    }
    for (const auto& [alias, aov] : kAliases) {
        if (sourceName == alias) {
            return aov;
        }
    }
    return {};
}

} // namespace hds
