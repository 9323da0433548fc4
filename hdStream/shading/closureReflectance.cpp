// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/closureReflectance.h"

#include "hdStream/shading/shaderMath.h"

#include <array>

namespace hds {

ShaderValue ConductorReflectance(const ShaderValue& n, const ShaderValue& k) {
    const ShaderValue one = MakeScalar(1.0F);
    const ShaderValue k2 = Multiply(k, k, 3);
    const ShaderValue up = Add(n, one, 3);
    const ShaderValue down = Subtract(n, one, 3);
    return MakeMath(
        HDS_MATH_MIN,
        {Divide(Add(Multiply(down, down, 3), k2, 3), Add(Multiply(up, up, 3), k2, 3), 3),
         MakeScalar(0.99F)},
        3);
}

bool IsDielectricGrey(const ShaderValue& front) {
    const std::array<float, 4> none{1.0F};
    const std::array<float, 4>& c = IsConstant(front) ? ConstantOf(front) : none;
    return c[0] <= 0.1F && c[0] == c[1] && c[0] == c[2];
}

ShaderValue IndexOfReflectance(const ShaderValue& front) {
    const ShaderValue third = MakeConstant({1.0F / 3.0F, 1.0F / 3.0F, 1.0F / 3.0F}, 3);
    const ShaderValue mean = IsDielectricGrey(front) ? SelectChannel(front, 0)
                                                     : MakeMath(HDS_MATH_DOT, {front, third}, 1);
    const ShaderValue root = MakeMath(HDS_MATH_SQRT, {mean}, 1);
    return Divide(Add(MakeScalar(1.0F), root, 1), OneMinus(root, 1), 1);
}

} // namespace hds
