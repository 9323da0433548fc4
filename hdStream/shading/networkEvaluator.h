// SPDX-License-Identifier: Apache-2.0
// Follows the connections of a material network from one shader input to what feeds it: a constant,
// or a primvar reader. Part of the material compiler.
#pragma once

#include "hdStream/shading/materialCompiler.h"

#include <map>
#include <set>
#include <string>

namespace hds {

/// What feeds an input.
struct InputValue {
    enum class Kind { None, Constant, Primvar };
    Kind kind = Kind::None;
    std::array<float, 4> value{0.0F, 0.0F, 0.0F, 1.0F}; ///< the constant, or the reader's fallback
    std::uint32_t numComponents = 0;                    ///< of the value: 1 to 4
    std::string primvar;                                ///< Kind::Primvar
};

/// Evaluates inputs of a network's nodes. Externally synchronised; the network must outlive it.
class NetworkEvaluator {
public:
    NetworkEvaluator(const MaterialNetwork& network, const std::string& materialPath,
                     const MeanColorCallback& meanColor, Warnings& warnings);

    /// The node, or null.
    const MaterialNode* FindNode(const std::string& path) const;

    /// Follows the input's connection; without one, or when it gives nothing, the authored
    /// parameter. Kind::None: neither. Cycles end with a warning.
    InputValue Evaluate(const MaterialNode& node, const std::string& input);

    /// The authored parameter as numbers; Kind::None when absent, not numeric or not finite
    /// (warns).
    InputValue Parameter(const MaterialNode& node, const std::string& input);

private:
    InputValue EvaluateOutput(const MaterialNode& node, const std::string& output);
    InputValue EvaluateReader(const MaterialNode& node);
    InputValue EvaluateTexture(const MaterialNode& node, const std::string& output);
    std::array<float, 4> TextureMean(const MaterialNode& node);
    std::array<float, 4> Constant4(const MaterialNode& node, const std::string& input,
                                   const std::array<float, 4>& fallback);
    std::string Text(const MaterialNode& node, const std::string& input) const;
    void Warn(const std::string& text);

    const std::string& _materialPath;
    const MeanColorCallback& _meanColor;
    Warnings& _warnings;
    std::map<std::string, const MaterialNode*> _nodeByPath;
    std::set<std::pair<std::string, std::string>> _visiting; ///< (node, output) on the present walk
};

} // namespace hds
