// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/materialParameters.h"

#include "hdStream/hydra/assets.h"
#include "hdStream/hydra/floatValues.h"

#include <pxr/base/gf/half.h>
#include <pxr/base/gf/matrix2d.h>
#include <pxr/base/gf/matrix3d.h>
#include <pxr/base/gf/matrix4d.h>
#include <pxr/base/tf/stringUtils.h>

#include <cstdint>
#include <utility>
#include <variant>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

using Parameter = std::optional<hds::ParameterValue>;

template <typename Type, typename Result>
bool TryNumber(const VtValue& value, Parameter* result) {
    if (!value.IsHolding<Type>()) {
        return false;
    }
    *result = static_cast<Result>(value.UncheckedGet<Type>());
    return true;
}

template <typename Matrix>
bool TryMatrix(const VtValue& value, Parameter* result) {
    if (!value.IsHolding<Matrix>()) {
        return false;
    }
    const double* items = value.UncheckedGet<Matrix>().GetArray();
    constexpr std::size_t count = Matrix::numRows * Matrix::numColumns;
    *result = std::vector<float>(items, items + count);
    return true;
}

/// Attributes of inputs ("typeName:x", "colorSpace:x") that newer versions of Hydra put among them.
bool IsMetadata(const std::string& name) {
    return TfStringStartsWith(name, "typeName:") || TfStringStartsWith(name, "colorSpace:");
}

/// Of images, of colours and of lists of them.
bool MayHaveColorSpace(const hds::ParameterValue& value) {
    const auto* numbers = std::get_if<std::vector<float>>(&value);
    return std::holds_alternative<hds::AssetReference>(value) ||
           (numbers != nullptr && (numbers->size() % 3 == 0 || numbers->size() == 4));
}

/// Paths of nodes: relative to the material or absolute in Hydra, absolute in the scene.
class NodePaths {
public:
    NodePaths(const SdfPath& scenePath, const SdfPath& materialId)
        : _scenePath(scenePath), _materialId(materialId) {}

    std::string operator()(const SdfPath& node) const {
        return node.MakeAbsolutePath(_scenePath).ReplacePrefix(_materialId, _scenePath).GetString();
    }

private:
    const SdfPath& _scenePath;
    const SdfPath& _materialId;
};

hds::MaterialNode NodeFrom(const SdfPath& path, const NodePaths& paths,
                           const HdMaterialNode2& source) {
    hds::MaterialNode node;
    node.path = paths(path);
    node.identifier = source.nodeTypeId.GetString();
    for (const auto& [input, connections] : source.inputConnections) {
        if (!connections.empty()) {
            const HdMaterialConnection2& first = connections.front();
            node.connections[input.GetString()] = {paths(first.upstreamNode),
                                                   first.upstreamOutputName.GetString()};
        }
    }
    for (const auto& [input, value] : source.parameters) {
        const std::string& name = input.GetString();
        if (IsMetadata(name) || node.connections.count(name) != 0) {
            continue;
        }
        Parameter parameter = HdStreamParameterFrom(value);
        if (!parameter) {
            continue;
        }
        if (MayHaveColorSpace(*parameter)) {
            const std::string key = "colorSpace:" + name;
            const auto space = source.parameters.find(TfToken(key));
            if (space != source.parameters.end() && space->second.IsHolding<TfToken>() &&
                !space->second.UncheckedGet<TfToken>().IsEmpty()) {
                node.parameters[key] = space->second.UncheckedGet<TfToken>().GetString();
            }
        }
        node.parameters[name] = std::move(*parameter);
    }
    return node;
}

} // namespace

std::optional<hds::ParameterValue> HdStreamParameterFrom(const VtValue& value) {
    Parameter result;
    if (value.IsHolding<SdfAssetPath>()) {
        return HdStreamAssetReference(value.UncheckedGet<SdfAssetPath>());
    }
    if (value.IsHolding<TfToken>()) {
        return value.UncheckedGet<TfToken>().GetString();
    }
    if (TryNumber<float, double>(value, &result) || TryNumber<bool, bool>(value, &result) ||
        TryNumber<int, std::int64_t>(value, &result) ||
        TryNumber<std::string, std::string>(value, &result) ||
        TryNumber<double, double>(value, &result) ||
        TryNumber<unsigned int, std::int64_t>(value, &result) ||
        TryNumber<std::int64_t, std::int64_t>(value, &result) ||
        TryNumber<GfHalf, double>(value, &result) || TryMatrix<GfMatrix4d>(value, &result) ||
        TryMatrix<GfMatrix3d>(value, &result) || TryMatrix<GfMatrix2d>(value, &result)) {
        return result;
    }
    if (const std::optional<HdStreamFloatRows> rows = HdStreamGetFloatRows(value)) {
        result = std::vector<float>(rows->values.begin(), rows->values.end());
    }
    return result;
}

hds::MaterialNetwork HdStreamMaterialNetworkFrom(const SdfPath& scenePath,
                                                 const SdfPath& materialId,
                                                 const HdMaterialNetworkMap& map) {
    const NodePaths paths(scenePath, materialId);
    const HdMaterialNetwork2 source = HdConvertToHdMaterialNetwork2(map);
    hds::MaterialNetwork network;
    for (const auto& [name, connection] : source.terminals) {
        network.terminals[name.GetString()] = {paths(connection.upstreamNode), name.GetString()};
    }
    for (const auto& [path, node] : source.nodes) {
        network.nodes.push_back(NodeFrom(path, paths, node));
    }
    return network;
}

PXR_NAMESPACE_CLOSE_SCOPE
