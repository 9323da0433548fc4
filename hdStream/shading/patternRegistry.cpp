// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/patternRegistry.h"

#include "hdStream/base/error.h"
#include "hdStream/shading/shaderNodes.h"

#include <algorithm>
#include <map>

namespace hds {

namespace {

using TypeByIdName = std::map<std::string_view, const PatternType*>;

const TypeByIdName& Types() {
    static const TypeByIdName kTypes = [] {
        TypeByIdName types;
        for (const PatternTable& table :
             {StandardNodes(), LibraryNodes(), ColorNodes(), FlakeNodes(), MapNodes(),
              MatrixNodes(), PbrNodes(), ShapeNodes(), SpaceNodes(), UsdNodes()}) {
            for (const PatternType& type : table) {
                const std::string_view idName = type.idName.empty() ? type.name : type.idName;
                HDS_VERIFY(types.emplace(idName, &type).second, "two nodes of one name");
            }
        }
        return types;
    }();
    return kTypes;
}

} // namespace

const PatternType* FindPatternType(const std::string& identifier) {
    constexpr std::string_view kMaterialX = "ND_";
    std::string_view rest = identifier;
    const bool isMaterialX = rest.substr(0, kMaterialX.size()) == kMaterialX;
    rest.remove_prefix(isMaterialX ? kMaterialX.size() : 0);
    while (!rest.empty()) {
        if (const auto found = Types().find(rest); found != Types().end()) {
            return isMaterialX || IsOfUsd(*found->second) ? found->second : nullptr;
        }
        const std::size_t end = rest.rfind('_');
        rest = rest.substr(0, end == std::string_view::npos ? 0 : end);
    }
    return nullptr;
}

bool IsOfUsd(const PatternType& type) {
    return type.name.substr(0, 3) == "Usd";
}

bool IsKnownShader(const std::string& identifier) {
    const std::vector<std::string> closures = ClosureIds();
    return FindPatternType(identifier) != nullptr || IsSurfaceShader(identifier) ||
           std::binary_search(closures.begin(), closures.end(), identifier);
}

std::vector<std::string> PatternNames() {
    std::vector<std::string> names;
    for (const auto& [idName, type] : Types()) {
        names.emplace_back(type->name);
    }
    std::sort(names.begin(), names.end());
    return names;
}

} // namespace hds
