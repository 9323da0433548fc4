// SPDX-License-Identifier: Apache-2.0
// What the material of a volume computes beside sums and products of fields: patterns, which stand
// in products as fields do. Explained in docs/volumes.md.
#pragma once

#include "hdStream/shading/networkEvaluator.h"

#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace hds {

/// The name of a pattern among the fields of a product; no field of USD is called so.
std::string PatternName(std::size_t number);

/// The number of a pattern; nothing: it is a field.
std::optional<std::size_t> PatternNumber(const std::string& name);

/// Names of the fields that a value reads: its primvars.
std::set<std::string> FieldsOf(const ShaderValue& value);

/// Collects the patterns of one network. Externally synchronised; the arguments must outlive it.
class VolumePatterns {
public:
    VolumePatterns(const MaterialNetwork& network, const std::string& materialPath,
                   const ImageQueries& images, Warnings& warnings)
        : _evaluator(network, materialPath, images, warnings) {}

    /// The value of an input that is connected, three components.
    ShaderValue Evaluate(const MaterialNode& node, const std::string& input,
                         const std::array<float, 4>& fallback) {
        return _evaluator.EvaluateOr(node, input, fallback, 3);
    }

    /// The number of a value that varies; equal ones have one.
    std::size_t Add(const ShaderValue& value);

    const std::vector<ShaderValue>& Values() const { return _values; }
    /// What tiles of look-ups name.
    const std::vector<MaterialTexture>& Textures() const { return _evaluator.Textures(); }

private:
    NetworkEvaluator _evaluator;
    std::vector<ShaderValue> _values;
};

} // namespace hds
