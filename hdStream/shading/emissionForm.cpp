// SPDX-License-Identifier: Apache-2.0
// Source of names and formulas: MaterialX 1.39, pbrlib and bxdf.
#include "hdStream/shading/emissionForm.h"

#include "hdStream/shading/patternNode.h"
#include "hdStream/shading/shaderMath.h"
#include "kernels/shared/material.h"

namespace hds {

namespace {

using Kind = ShaderExpression::Kind;

/// Of half an angle, which is at most half of a straight one.
ShaderValue CosineOfHalf(const ShaderValue& degrees) {
    constexpr float kHalfRadians = 0.0087266463F; // pi / 360
    const ShaderValue limited =
        MakeMath(HDS_MATH_MAX,
                 {MakeMath(HDS_MATH_MIN, {degrees, MakeScalar(180.0F)}, 1), MakeScalar(0.0F)}, 1);
    return MakeMath(HDS_MATH_COS, {Multiply(limited, MakeScalar(kHalfRadians), 1)}, 1);
}

} // namespace

ShaderValue ViewCosine() {
    const ShaderValue cosine =
        DotProduct(MakeGeometry(Kind::View, 0), MakeGeometry(Kind::Normal, HDS_SPACE_WORLD), 3);
    return Multiply(cosine, MakeScalar(-1.0F), 1); // the other one is that from the viewer
}

ShaderValue SchlickEmission(const ShaderValue& color0, const ShaderValue& color90,
                            const ShaderValue& exponent) {
    if (AreSame(color0, color90)) {
        return color0;
    }
    const ShaderValue facing =
        MakeMath(HDS_MATH_MIN, {MakeMath(HDS_MATH_ABS, {ViewCosine()}, 1), MakeScalar(1.0F)}, 1);
    return Mix(color0, color90, Power(OneMinus(facing, 1), exponent, 1), 3);
}

ShaderValue ConicalEmission(const ShaderValue& innerAngle, const ShaderValue& outerAngle) {
    constexpr float kEdge = 1e-6F; // the narrowest falloff
    const ShaderValue inner = CosineOfHalf(innerAngle);
    const ShaderValue outer = MakeMath(
        HDS_MATH_MIN, {CosineOfHalf(outerAngle), Subtract(inner, MakeScalar(kEdge), 1)}, 1);
    return MakeMath(HDS_MATH_SMOOTHSTEP, {ViewCosine(), outer, inner}, 1);
}

ShaderValue CoatedEmission(const ShaderValue& emission, const ShaderValue& coat,
                           const ShaderValue& coatIor, const ShaderValue& tint) {
    if (IsAll(emission, 0.0F) || IsAll(coat, 0.0F)) {
        return emission;
    }
    const ShaderValue one = MakeScalar(1.0F);
    const ShaderValue root = Divide(Subtract(coatIor, one, 1), Add(coatIor, one, 1), 1);
    const ShaderValue left =
        SchlickEmission(OneMinus(Multiply(root, root, 1), 1), MakeScalar(0.0F), MakeScalar(5.0F));
    return Multiply(emission, Mix(one, Multiply(left, tint, 3), coat, 3), 3);
}

} // namespace hds
