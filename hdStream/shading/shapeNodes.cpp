// SPDX-License-Identifier: Apache-2.0
// MaterialX's shapes in the plane, alone and on tiles, as expressions: circles, lines, hexagons,
// cloverleafs. Definitions: nprlib and stdlib 1.39. The table of what there is: docs/materials.md.
#include "hdStream/shading/patternNode.h"

namespace hds {

namespace {

constexpr float kRowHeight = 0.866025F; ///< of staggered circles and hexagons: half the root of 3

ShaderValue Scalar(std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
    return MakeMath(code, {a, b}, 1);
}
ShaderValue Pair(std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
    return MakeMath(code, {a, b}, 2);
}
ShaderValue PointAt(const ShaderValue& x, const ShaderValue& y) {
    return CombineChannels(x, y, MakeScalar(0.0F), MakeScalar(0.0F), 2);
}
ShaderValue Modulo(const ShaderValue& x, float period) {
    return Scalar(HDS_MATH_MODULO, x, MakeScalar(period));
}
/// 1 where `value` is at most 0, else 0.
ShaderValue IsWithin(const ShaderValue& value) {
    return MakeMath(
        HDS_MATH_SELECT,
        {Scalar(HDS_MATH_GREATER, value, MakeScalar(0.0F)), MakeScalar(0.0F), MakeScalar(1.0F)}, 1);
}
ShaderValue LengthOf(const ShaderValue& value) {
    return MakeMath(HDS_MATH_SQRT, {DotProduct(value, value, 2)}, 1);
}

/// A shape around the origin: 1 inside, 0 outside.
using Shape = ShaderValue (*)(const ShaderValue& place, const ShaderValue& radius);

ShaderValue CircleAt(const ShaderValue& place, const ShaderValue& radius) {
    return IsWithin(Scalar(HDS_MATH_SUBTRACT, DotProduct(place, place, 2),
                           Scalar(HDS_MATH_MULTIPLY, radius, radius)));
}

/// By a reflection at a side, as distances to hexagons are computed, in a quarter of the plane.
ShaderValue HexagonAt(const ShaderValue& place, const ShaderValue& radius) {
    const ShaderValue zero = MakeScalar(0.0F);
    const ShaderValue both = MakeMath(HDS_MATH_ABS, {place}, 2);
    const ShaderValue quarter = PointAt(ChannelOf(both, 1), ChannelOf(both, 0));
    const ShaderValue side = MakeConstant({-kRowHeight, 0.5F, 0.0F, 0.0F}, 2);
    const ShaderValue beyond = Scalar(HDS_MATH_MIN, DotProduct(side, quarter, 2), zero);
    const ShaderValue twice = Scalar(HDS_MATH_MULTIPLY, beyond, MakeScalar(2.0F));
    const ShaderValue p = Pair(HDS_MATH_SUBTRACT, quarter, Pair(HDS_MATH_MULTIPLY, side, twice));
    const ShaderValue half = Scalar(HDS_MATH_MULTIPLY, radius, MakeScalar(0.57735F));
    const ShaderValue x = ChannelOf(p, 0);
    const ShaderValue across = ClampTo(x, Scalar(HDS_MATH_SUBTRACT, zero, half), half, 1);
    return IsWithin(Scalar(HDS_MATH_ADD, Scalar(HDS_MATH_SUBTRACT, x, across),
                           Scalar(HDS_MATH_SUBTRACT, ChannelOf(p, 1), radius)));
}

ShaderValue CloverleafAt(const ShaderValue& place, const ShaderValue& radius) {
    const ShaderValue doubled = Pair(HDS_MATH_MULTIPLY, place, MakeScalar(2.0F));
    const ShaderValue x = ChannelOf(doubled, 0);
    const ShaderValue y = ChannelOf(doubled, 1);
    ShaderValue result = MakeScalar(0.0F);
    for (const std::uint32_t code : {HDS_MATH_ADD, HDS_MATH_SUBTRACT}) {
        result =
            Scalar(HDS_MATH_MAX, result, CircleAt(PointAt(Scalar(code, x, radius), y), radius));
        result =
            Scalar(HDS_MATH_MAX, result, CircleAt(PointAt(x, Scalar(code, y, radius)), radius));
    }
    return result;
}

/// 1 at most `radius` from the line between two points.
ShaderValue LineAt(const ShaderValue& place, const ShaderValue& begin, const ShaderValue& end,
                   const ShaderValue& radius) {
    const ShaderValue toPoint = Pair(HDS_MATH_SUBTRACT, place, begin);
    const ShaderValue toEnd = Pair(HDS_MATH_SUBTRACT, end, begin);
    const ShaderValue share =
        ClampTo(Scalar(HDS_MATH_DIVIDE, DotProduct(toPoint, toEnd, 2), DotProduct(toEnd, toEnd, 2)),
                MakeScalar(0.0F), MakeScalar(1.0F), 1);
    const ShaderValue nearest = Pair(HDS_MATH_MULTIPLY, toEnd, share);
    const ShaderValue distance = LengthOf(Pair(HDS_MATH_SUBTRACT, toPoint, nearest));
    return IsWithin(Scalar(HDS_MATH_SUBTRACT, distance, radius));
}

class ShapeNode : public PatternNode {
public:
    using PatternNode::PatternNode;

    ShaderValue Centred() {
        return Pair(HDS_MATH_SUBTRACT, Coordinates(), Vector("center", {}, 2));
    }
    template <Shape kShape>
    ShaderValue Alone() {
        return kShape(Centred(), In("radius", 0.5F));
    }
    ShaderValue Line() {
        return LineAt(Centred(), Vector("point1", {0.25F, 0.25F, 0.0F, 0.0F}, 2),
                      Vector("point2", {0.75F, 0.75F, 0.0F, 0.0F}, 2), In("radius", 0.1F));
    }

    /// Coordinates that are repeated and moved.
    ShaderValue Tiled() {
        const auto at = [&](const char* input, float value) {
            return Vector(input, {value, value, 0.0F, 0.0F}, 2);
        };
        return Pair(HDS_MATH_SUBTRACT, Pair(HDS_MATH_MULTIPLY, Coordinates(), at("uvtiling", 1.0F)),
                    at("uvoffset", 0.0F));
    }
    /// -1 to 1 across a tile.
    static ShaderValue InTile(const ShaderValue& x) {
        return Scalar(HDS_MATH_SUBTRACT,
                      Scalar(HDS_MATH_MULTIPLY, Modulo(x, 1.0F), MakeScalar(2.0F)),
                      MakeScalar(1.0F));
    }
    /// `value` where `x` is beyond the middle of a period, else 0.
    static ShaderValue InOddRow(const ShaderValue& x, float period, float value) {
        return MakeMath(HDS_MATH_SELECT,
                        {Scalar(HDS_MATH_GREATER, Modulo(x, period), MakeScalar(0.5F * period)),
                         MakeScalar(value), MakeScalar(0.0F)},
                        1);
    }
    ShaderValue IsStaggered() {
        return Scalar(HDS_MATH_EQUAL, In("staggered", 0.0F), MakeScalar(1.0F));
    }
    /// One a tile, or in rows of a height that lie between each other.
    ShaderValue OnTiles(Shape shape, float height, float period) {
        const ShaderValue st = Tiled();
        const ShaderValue size = In("size", 0.5F);
        const ShaderValue regular =
            shape(PointAt(InTile(ChannelOf(st, 0)), InTile(ChannelOf(st, 1))), size);
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue x = Modulo(
            Scalar(HDS_MATH_ADD, ChannelOf(st, 0), InOddRow(ChannelOf(st, 1), period, 0.5F)), 1.0F);
        const ShaderValue y = Modulo(ChannelOf(st, 1), height);
        const ShaderValue half = Scalar(HDS_MATH_DIVIDE, size, MakeScalar(2.0F));
        ShaderValue rows = shape(PointAt(x, y), half);
        rows =
            Scalar(HDS_MATH_MAX, rows, shape(PointAt(Scalar(HDS_MATH_SUBTRACT, one, x), y), half));
        rows = Scalar(HDS_MATH_MAX, rows,
                      shape(PointAt(Scalar(HDS_MATH_SUBTRACT, x, MakeScalar(0.5F)),
                                    Scalar(HDS_MATH_SUBTRACT, MakeScalar(height), y)),
                            half));
        return MakeMath(HDS_MATH_SELECT, {IsStaggered(), rows, regular}, 1);
    }
    template <Shape kShape>
    ShaderValue InRows() {
        return OnTiles(kShape, kRowHeight, 2.0F * kRowHeight);
    }
    ShaderValue TiledCloverleafs() { return OnTiles(&CloverleafAt, 0.5F, 1.0F); }
    ShaderValue Crosshatch() {
        const ShaderValue st = Tiled();
        const ShaderValue moved =
            Scalar(HDS_MATH_ADD, ChannelOf(st, 0), InOddRow(ChannelOf(st, 1), 2.0F, 0.5F));
        const ShaderValue x =
            MakeMath(HDS_MATH_SELECT, {IsStaggered(), moved, ChannelOf(st, 0)}, 1);
        const ShaderValue place = PointAt(InTile(x), InTile(ChannelOf(st, 1)));
        const ShaderValue thickness = In("thickness", 0.05F);
        const auto line = [&](float sign) {
            return LineAt(place, MakeConstant({sign, 1.0F, 0.0F, 0.0F}, 2),
                          MakeConstant({-sign, -1.0F, 0.0F, 0.0F}, 2), thickness);
        };
        return Scalar(HDS_MATH_MAX, line(1.0F), line(-1.0F));
    }
};

constexpr PatternType kTypes[] = {
    {"circle", kPattern<&ShapeNode::Alone<&CircleAt>>},
    {"hexagon", kPattern<&ShapeNode::Alone<&HexagonAt>>},
    {"cloverleaf", kPattern<&ShapeNode::Alone<&CloverleafAt>>},
    {"line", kPattern<&ShapeNode::Line>},
    {"tiledcircles", kPattern<&ShapeNode::InRows<&CircleAt>>},
    {"tiledhexagons", kPattern<&ShapeNode::InRows<&HexagonAt>>},
    {"tiledcloverleafs", kPattern<&ShapeNode::TiledCloverleafs>},
    {"crosshatch", kPattern<&ShapeNode::Crosshatch>},
};

} // namespace

PatternTable ShapeNodes() {
    return PatternTable(kTypes);
}

} // namespace hds
