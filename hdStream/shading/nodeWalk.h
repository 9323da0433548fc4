// SPDX-License-Identifier: Apache-2.0
// Walks through a network's nodes whose values are no values of the machine: closures, surfaces,
// matrices. Each node is read once, since there may be exponentially many ways to it, and a node
// that feeds itself is met while it is read. Part of the material compiler. Explained in
// docs/materials.md.
#pragma once

#include "hdStream/shading/materialNetwork.h"

#include <cstddef>
#include <map>
#include <optional>
#include <string>

namespace hds {

/// What nodes give, each read once. Of one walk, by one thread.
template <typename Value>
class NodeWalk {
public:
    /// Nodes in a row; behind them the walk ends.
    static constexpr std::size_t kMaxDepth = 64;

    /// What `read` makes of a node, or made of it before. Nothing: the node feeds itself, or lies
    /// too deep.
    template <typename Read>
    std::optional<Value> Visit(const MaterialNode& node, const Read& read) {
        const auto known = _values.find(&node);
        if (known != _values.end()) {
            return known->second;
        }
        if (_depth >= kMaxDepth) {
            return std::nullopt;
        }
        const auto place = _values.emplace(&node, std::nullopt).first;
        ++_depth;
        place->second = read();
        --_depth;
        return place->second;
    }

    /// What to tell where there is nothing.
    static std::string EndText(const MaterialNode& node) {
        return "the connections of " + node.path + " form a cycle, or a chain of more than " +
               std::to_string(kMaxDepth) + " nodes";
    }

private:
    std::map<const MaterialNode*, std::optional<Value>> _values; ///< nothing: being read
    std::size_t _depth = 0;
};

} // namespace hds
