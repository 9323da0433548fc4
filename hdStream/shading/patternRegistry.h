// SPDX-License-Identifier: Apache-2.0
// The pattern nodes that there are, by the ids of their definitions. Each file that evaluates some
// of them has a table of them; patternRegistry.cpp puts the tables together. The nodes in groups,
// and what they do: docs/materials.md.
#pragma once

#include "hdStream/shading/networkEvaluator.h"

#include <cstddef>
#include <string>
#include <string_view>

namespace hds {

/// Evaluates an output of a node. Empty: not to be had, which has been warned of.
using PatternFunction = ShaderValue (*)(NetworkEvaluator& network, const MaterialNode& node,
                                        const std::string& output);

/// A kind of node.
struct PatternType {
    std::string_view name; ///< MaterialX's category, "mix", or USD's name, "UsdUVTexture"
    PatternFunction evaluate = nullptr;
    /// What ids have between "ND_" and the types; empty: the name.
    std::string_view idName = {};
};

/// A file's table. The array has to outlive it.
class PatternTable {
public:
    template <std::size_t kCount>
    explicit constexpr PatternTable(const PatternType (&types)[kCount])
        : _begin(types), _end(types + kCount) {}
    const PatternType* begin() const { return _begin; }
    const PatternType* end() const { return _end; }

private:
    const PatternType* _begin;
    const PatternType* _end;
};

// The tables, each in the .cpp file of its name.
PatternTable StandardNodes(); ///< patternNodes.cpp
PatternTable LibraryNodes();
PatternTable ColorNodes();
PatternTable FlakeNodes();
PatternTable MapNodes();
PatternTable MatrixNodes();
PatternTable PbrNodes();
PatternTable ShapeNodes();
PatternTable SpaceNodes();
PatternTable UsdNodes();

/// The type of a shader id: the longest name that the id, or what follows "ND_" in it, is, or
/// begins with before an underscore. Only USD's nodes have ids without "ND_". Null: not a known
/// node.
const PatternType* FindPatternType(const std::string& identifier);

/// Whether a type is of the UsdPreviewSurface specification.
bool IsOfUsd(const PatternType& type);

} // namespace hds
