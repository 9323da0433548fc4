// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/instanceTransforms.h"

#include "kernels/shared/textureCodec.h"

#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <limits>

namespace hds {

namespace {

constexpr unsigned kHalfExponent = 0x7c00U; ///< all of its bits: infinity, or no number

/// GfMatrix4d::SetRotate of a quaternion; columns of the result are Gf's rows.
glm::dmat4 RotationMatrix(const glm::dvec3& i, double r) {
    glm::dmat4 matrix(1.0);
    matrix[0][0] = 1.0 - 2.0 * (i[1] * i[1] + i[2] * i[2]);
    matrix[0][1] = 2.0 * (i[0] * i[1] + i[2] * r);
    matrix[0][2] = 2.0 * (i[2] * i[0] - i[1] * r);
    matrix[1][0] = 2.0 * (i[0] * i[1] - i[2] * r);
    matrix[1][1] = 1.0 - 2.0 * (i[2] * i[2] + i[0] * i[0]);
    matrix[1][2] = 2.0 * (i[1] * i[2] + i[0] * r);
    matrix[2][0] = 2.0 * (i[2] * i[0] + i[1] * r);
    matrix[2][1] = 2.0 * (i[1] * i[2] - i[0] * r);
    matrix[2][2] = 1.0 - 2.0 * (i[1] * i[1] + i[0] * i[0]);
    return matrix;
}

} // namespace

std::size_t InstanceTransforms::Size() const {
    if (!matrices.empty()) {
        return matrices.size() / 16;
    }
    return std::max({translations.size() / 3, rotations.size() / 4, halfRotations.size() / 4,
                     scales.size() / 3});
}

glm::dmat4 InstanceTransforms::At(std::size_t index) const {
    if (!matrices.empty()) {
        return glm::make_mat4(matrices.data() + 16 * index);
    }
    glm::dmat4 matrix(1.0);
    if (4 * index < rotations.size()) {
        const float* q = rotations.data() + 4 * index;
        matrix = RotationMatrix(glm::dvec3(q[0], q[1], q[2]), q[3]);
    } else if (rotations.empty() && 4 * index < halfRotations.size()) {
        const std::uint16_t* q = halfRotations.data() + 4 * index;
        const auto at = [q](int i) { // floatOfHalf knows finite numbers only
            return (q[i] & kHalfExponent) == kHalfExponent
                       ? std::numeric_limits<double>::quiet_NaN()
                       : double{shared::codec_floatOfHalf(q[i])};
        };
        matrix = RotationMatrix(glm::dvec3(at(0), at(1), at(2)), at(3));
    }
    if (3 * index < scales.size()) {
        for (int i = 0; i < 3; ++i) {
            const double scale = scales[3 * index + static_cast<std::size_t>(i)];
            for (int k = 0; k < 3; ++k) {
                matrix[i][k] = scale * matrix[i][k] + 0.0; // -0 becomes +0, as in a sum of products
            }
        }
    }
    if (3 * index < translations.size()) {
        for (int k = 0; k < 3; ++k) {
            matrix[3][k] = translations[3 * index + static_cast<std::size_t>(k)];
        }
    }
    return matrix;
}

SharedSpan<double> InstanceTransforms::Matrices() const {
    if (!matrices.empty() || Size() == 0) {
        return matrices;
    }
    std::vector<double> all;
    all.reserve(16 * Size());
    for (std::size_t i = 0; i < Size(); ++i) {
        const glm::dmat4 matrix = At(i);
        all.insert(all.end(), glm::value_ptr(matrix), glm::value_ptr(matrix) + 16);
    }
    return all;
}

} // namespace hds
