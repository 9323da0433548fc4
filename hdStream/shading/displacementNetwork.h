// SPDX-License-Identifier: Apache-2.0
// Displacement that a network computes, as steps that the host evaluates: what an expression
// (shaderExpression.h) is without its pointers, so that keys of geometry hold it. Patterns of
// volumes are bounded by the same steps. Explained in docs/geometry.md.
#pragma once

#include "hdStream/base/fields.h"
#include "hdStream/shading/imageQueries.h"
#include "hdStream/shading/shaderExpression.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// One channel of an image in linear light, rows from the top. Filled in by commit.
struct HeightImage {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> values;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(HeightImage, width), HDS_FIELD(HeightImage, height),
                         HDS_FIELD(HeightImage, values));
    }
};

/// A step, or one channel of it in all components.
struct DisplacementOperand {
    std::uint32_t step = 0;
    std::uint32_t channel = HDS_CHANNEL_ALL;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(DisplacementOperand, step),
                         HDS_FIELD(DisplacementOperand, channel));
    }
};

/// An image of a look-up.
struct DisplacementTile {
    MaterialTexture texture;
    std::uint32_t channels = 0; ///< that are read, as bits; 0: a hole
    /// Null until commit has read them; those that are not read, or not readable, stay so.
    std::array<std::shared_ptr<const HeightImage>, 4> heights;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(DisplacementTile, texture)
                             .NotInKey("the heights are: a file that changes makes other pages"),
                         HDS_FIELD(DisplacementTile, channels),
                         HDS_FIELD(DisplacementTile, heights));
    }
};

/// A step. Its value has four components; those that it does not have are 0.
struct DisplacementStep {
    enum class Kind {
        Constant,
        Primvar,  ///< `code` of the network's
        Position, ///< in object space, before it is displaced
        Affine,   ///< of coordinates by `rows`; operands: in
        Texture,  ///< operands: coordinates, fallback, scale, bias; HDS_LOOKUP_* `code`
        Math,     ///< HDS_MATH_* `code` of the operands
    };
    Kind kind = Kind::Constant;
    std::uint32_t code = 0;
    std::array<float, 4> constant{};
    std::vector<DisplacementOperand> operands; ///< earlier steps
    std::array<double, 6> rows{};
    std::vector<DisplacementTile> tiles; ///< Texture

    static constexpr auto Fields() {
        using Step = DisplacementStep;
        return FieldList(HDS_FIELD(Step, kind), HDS_FIELD(Step, code), HDS_FIELD(Step, constant),
                         HDS_FIELD(Step, operands), HDS_FIELD(Step, rows), HDS_FIELD(Step, tiles));
    }
};

struct DisplacementPrimvar {
    std::vector<std::string> names; ///< without "primvars:"; the first that the prim has
    std::uint32_t numComponents = 1;
    std::array<float, 4> missing{}; ///< where the prim has none

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(DisplacementPrimvar, names),
                         HDS_FIELD(DisplacementPrimvar, numComponents),
                         HDS_FIELD(DisplacementPrimvar, missing));
    }
};

struct DisplacementNetwork {
    std::vector<DisplacementPrimvar> primvars;
    std::vector<DisplacementStep> steps;
    DisplacementOperand result; ///< its first component, or of vectors three
    bool isVector = false;
    /// Of a vector: the primvar whose tangents are x and y, beside the normal, which is z;
    /// HDS_NONE: the vector is in object space.
    std::uint32_t coordinates = HDS_NONE;

    static constexpr auto Fields() {
        using Network = DisplacementNetwork;
        return FieldList(HDS_FIELD(Network, primvars), HDS_FIELD(Network, steps),
                         HDS_FIELD(Network, result), HDS_FIELD(Network, isVector),
                         HDS_FIELD(Network, coordinates));
    }
};

/// Networks are not longer.
constexpr std::size_t kMaxDisplacementSteps = 512;

/// The steps of an expression. \param textures what tiles of look-ups name. \param problem gets
/// what the host cannot evaluate, where the result is nothing.
std::optional<DisplacementNetwork>
MakeDisplacementNetwork(const ShaderValue& value, const std::vector<MaterialTexture>& textures,
                        std::string* problem);

} // namespace hds
