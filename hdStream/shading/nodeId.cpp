// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/nodeId.h"

#include <algorithm>
#include <utility>

namespace hds {

namespace {

std::uint32_t TypeComponents(const std::string& type) {
    static const std::pair<const char*, std::uint32_t> kTypes[] = {
        {"float", 1},   {"integer", 1}, {"boolean", 1}, {"color3", 3},
        {"vector2", 2}, {"vector3", 3}, {"color4", 4},  {"vector4", 4}};
    for (const auto& [name, count] : kTypes) {
        if (type.compare(0, std::string(name).size(), name) == 0) {
            return count;
        }
    }
    return 0;
}

} // namespace

NodeId ParseId(const std::string& identifier) {
    NodeId id;
    std::size_t begin = 3; // behind "ND_"
    while (begin <= identifier.size()) {
        const std::size_t end = std::min(identifier.find('_', begin), identifier.size());
        const std::string word = identifier.substr(begin, end - begin);
        const std::uint32_t count = id.category.empty() ? 0 : TypeComponents(word);
        if (id.category.empty()) {
            id.category = word;
        } else if (count > 0) {
            id.firstComponents = id.firstComponents == 0 ? count : id.firstComponents;
            id.lastComponents = count;
        }
        begin = end + 1;
    }
    return id;
}

} // namespace hds
