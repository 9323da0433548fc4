// SPDX-License-Identifier: Apache-2.0
// MaterialX's nodes of matrices, and of colour spaces, which are matrices and curves. No value of
// the machine is a matrix: one is read as rows from the nodes that make it. Definitions: stdlib and
// cmlib 1.39. The table of what there is: docs/materials.md.
#include "hdStream/shading/matrixNodes.h"

#include "hdStream/shading/nodeWalk.h"
#include "hdStream/shading/patternNode.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>

namespace hds {

namespace {

using Entries = std::array<std::array<ShaderValue, 4>, 4>; ///< by row and column

struct Matrix {
    std::uint32_t size = 4;
    Entries at;
};

ShaderValue Scalar(std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
    return MakeMath(code, {a, b}, 1);
}
ShaderValue Product(const ShaderValue& a, const ShaderValue& b) {
    return Scalar(HDS_MATH_MULTIPLY, a, b);
}

Matrix Identity(std::uint32_t size) {
    Matrix matrix;
    matrix.size = size;
    for (std::uint32_t row = 0; row < 4; ++row) {
        for (std::uint32_t column = 0; column < 4; ++column) {
            matrix.at[row][column] = MakeScalar(row == column ? 1.0F : 0.0F);
        }
    }
    return matrix;
}

/// What is left of it without a row and a column.
Matrix Minor(const Matrix& matrix, std::uint32_t row, std::uint32_t column) {
    Matrix minor = Identity(matrix.size - 1);
    for (std::uint32_t i = 0; i < minor.size; ++i) {
        for (std::uint32_t k = 0; k < minor.size; ++k) {
            minor.at[i][k] = matrix.at[i + (i >= row)][k + (k >= column)];
        }
    }
    return minor;
}

ShaderValue DeterminantOf(const Matrix& matrix) {
    if (matrix.size == 1) {
        return matrix.at[0][0];
    }
    ShaderValue sum = MakeScalar(0.0F);
    for (std::uint32_t column = 0; column < matrix.size; ++column) {
        const ShaderValue part =
            Product(matrix.at[0][column], DeterminantOf(Minor(matrix, 0, column)));
        sum = Scalar(column % 2 == 0 ? HDS_MATH_ADD : HDS_MATH_SUBTRACT, sum, part);
    }
    return sum;
}

Matrix TransposeOf(const Matrix& matrix) {
    Matrix result = matrix;
    for (std::uint32_t row = 0; row < matrix.size; ++row) {
        for (std::uint32_t column = 0; column < matrix.size; ++column) {
            result.at[row][column] = matrix.at[column][row];
        }
    }
    return result;
}

/// By cofactors.
Matrix InverseOf(const Matrix& matrix) {
    const ShaderValue determinant = DeterminantOf(matrix);
    Matrix result = matrix;
    for (std::uint32_t row = 0; row < matrix.size; ++row) {
        for (std::uint32_t column = 0; column < matrix.size; ++column) {
            const ShaderValue cofactor =
                Product(DeterminantOf(Minor(matrix, column, row)),
                        MakeScalar((row + column) % 2 == 0 ? 1.0F : -1.0F));
            result.at[row][column] = Scalar(HDS_MATH_DIVIDE, cofactor, determinant);
        }
    }
    return result;
}

/// \param scale of the diagonal
Matrix Diagonal(std::uint32_t size, float scale) {
    Matrix matrix = Identity(size);
    for (std::uint32_t k = 0; k < size; ++k) {
        matrix.at[k][k] = MakeScalar(scale);
    }
    return matrix;
}

/// What a function makes of the entries of two matrices, one by one.
template <typename Function>
Matrix ByEntry(const Matrix& a, const Matrix& b, Function function) {
    Matrix result = a;
    for (std::uint32_t row = 0; row < a.size; ++row) {
        for (std::uint32_t column = 0; column < a.size; ++column) {
            result.at[row][column] = function(a.at[row][column], b.at[row][column]);
        }
    }
    return result;
}

Matrix ByCode(std::uint32_t code, const Matrix& a, const Matrix& b) {
    return ByEntry(
        a, b, [code](const ShaderValue& x, const ShaderValue& y) { return Scalar(code, x, y); });
}

Matrix Choice(const ShaderValue& condition, const Matrix& a, const Matrix& b) {
    return ByEntry(a, b, [&](const ShaderValue& x, const ShaderValue& y) {
        return MakeMath(HDS_MATH_SELECT, {condition, x, y}, 1);
    });
}

/// a, then b, of row vectors.
Matrix ProductOf(const Matrix& a, const Matrix& b) {
    Matrix result = a;
    for (std::uint32_t row = 0; row < a.size; ++row) {
        for (std::uint32_t column = 0; column < a.size; ++column) {
            ShaderValue sum = Product(a.at[row][0], b.at[0][column]);
            for (std::uint32_t k = 1; k < a.size; ++k) {
                sum = Scalar(HDS_MATH_ADD, sum, Product(a.at[row][k], b.at[k][column]));
            }
            result.at[row][column] = sum;
        }
    }
    return result;
}

/// A row vector times the matrix, as USD and MaterialX have it.
ShaderValue Transformed(const std::array<ShaderValue, 4>& vector, const Matrix& matrix,
                        std::uint32_t numComponents) {
    std::array<ShaderValue, 4> result;
    for (std::uint32_t column = 0; column < 4; ++column) {
        result[column] = MakeScalar(0.0F);
        for (std::uint32_t row = 0; row < matrix.size && column < numComponents; ++row) {
            result[column] =
                Scalar(HDS_MATH_ADD, result[column], Product(vector[row], matrix.at[row][column]));
        }
    }
    return CombineChannels(result[0], result[1], result[2], result[3], numComponents);
}

class MatrixNode : public PatternNode {
public:
    using PatternNode::PatternNode;

    /// \param diagonal of the matrix that it is by default
    Matrix MatrixInput(const MaterialNode& node, const std::string& input, std::uint32_t size,
                       float diagonal = 1.0F) {
        const MaterialNode* source = _network.FindSource(node, input);
        const auto read = [&] { return MatrixFrom(*source, size); };
        const auto connected = source == nullptr ? std::nullopt : _walks[size].Visit(*source, read);
        if (connected) {
            return *connected;
        }
        if (source != nullptr) {
            _network.Warn(_walks[size].EndText(node));
        }
        Matrix matrix = Diagonal(size, diagonal);
        const auto found = node.parameters.find(input);
        const auto* numbers = found == node.parameters.end()
                                  ? nullptr
                                  : std::get_if<std::vector<float>>(&found->second);
        if (numbers != nullptr && numbers->size() == std::size_t{size} * size) {
            for (std::uint32_t i = 0; i < size * size; ++i) {
                matrix.at[i / size][i % size] = MakeScalar((*numbers)[i]);
            }
        } else if (source == nullptr && numbers != nullptr) {
            _network.Warn("input " + input + " of " + node.path + " is no matrix of " +
                          std::to_string(size) + " rows");
        }
        return matrix;
    }
    /// The second input of arithmetic: a matrix, or a number in all places.
    Matrix SecondInput(const MaterialNode& node, std::uint32_t size, float diagonal) {
        const bool isNumber =
            node.identifier.compare(node.identifier.size() - 2, std::string::npos, "FA") == 0;
        if (!isNumber) {
            return MatrixInput(node, "in2", size, diagonal);
        }
        const ShaderValue number = _network.EvaluateOr(node, "in2", {}, 1);
        Matrix matrix = Identity(size);
        for (auto& row : matrix.at) {
            row.fill(number);
        }
        return matrix;
    }
    ShaderValue Condition(const MaterialNode& node, std::uint32_t code, float value1) {
        return MakeMath(code,
                        {_network.EvaluateOr(node, "value1", {value1, 0.0F, 0.0F, 0.0F}, 1),
                         _network.EvaluateOr(node, "value2", {}, 1)},
                        1);
    }
    Matrix If(const MaterialNode& node, const ShaderValue& condition, std::uint32_t size) {
        return Choice(condition, MatrixInput(node, "in1", size, 0.0F),
                      MatrixInput(node, "in2", size, 0.0F));
    }
    Matrix SwitchOf(const MaterialNode& node, std::uint32_t size) {
        const ShaderValue which = _network.EvaluateOr(node, "which", {}, 1);
        Matrix result = Diagonal(size, 0.0F);
        for (int i = 10; i > 0; --i) {
            const ShaderValue isBelow =
                MakeMath(HDS_MATH_GREATER, {MakeScalar(static_cast<float>(i)), which}, 1);
            const std::string input = "in" + std::to_string(i);
            result = Choice(isBelow, MatrixInput(node, input, size, 0.0F), result);
        }
        return result;
    }
    /// What arithmetic and conditions make of matrices; nothing: the node is none of these.
    std::optional<Matrix> ComputedFrom(const MaterialNode& node, const std::string& category,
                                       std::uint32_t size) {
        if (category == "add" || category == "subtract") {
            return ByCode(category == "add" ? HDS_MATH_ADD : HDS_MATH_SUBTRACT,
                          MatrixInput(node, "in1", size), SecondInput(node, size, 0.0F));
        }
        if (category == "multiply") {
            return ProductOf(MatrixInput(node, "in1", size), MatrixInput(node, "in2", size));
        }
        if (category == "divide") {
            return ProductOf(MatrixInput(node, "in1", size),
                             InverseOf(MatrixInput(node, "in2", size)));
        }
        if (category == "ifgreater") {
            return If(node, Condition(node, HDS_MATH_GREATER, 1.0F), size);
        }
        if (category == "ifgreatereq") {
            return If(node, Condition(node, HDS_MATH_GREATER_OR_EQUAL, 1.0F), size);
        }
        if (category == "ifequal") {
            return If(node, Condition(node, HDS_MATH_EQUAL, 0.0F), size);
        }
        return std::nullopt;
    }
    Matrix MatrixFrom(const MaterialNode& node, std::uint32_t size) {
        const NodeId id = ParseId(node.identifier);
        if (id.category == "constant") {
            return MatrixInput(node, "value", size);
        }
        if (id.category == "dot") {
            return MatrixInput(node, "in", size);
        }
        if (id.category == "switch") {
            return SwitchOf(node, size);
        }
        if (const auto computed = ComputedFrom(node, id.category, size)) {
            return *computed;
        }
        if (id.category == "transpose") {
            return TransposeOf(MatrixInput(node, "in", size));
        }
        if (id.category == "invertmatrix") {
            return InverseOf(MatrixInput(node, "in", size));
        }
        Matrix matrix = Identity(size);
        if (id.category != "creatematrix") {
            _network.Warn("node " + node.identifier + " of " + node.path +
                          " gives no matrix that is known");
            return matrix;
        }
        const char* const inputs[] = {"in1", "in2", "in3", "in4"};
        for (std::uint32_t row = 0; row < size; ++row) {
            std::array<float, 4> fallback{};
            fallback[row] = 1.0F;
            const ShaderValue value =
                _network.EvaluateOr(node, inputs[row], fallback, id.firstComponents);
            for (std::uint32_t column = 0; column < std::min(id.firstComponents, size); ++column) {
                matrix.at[row][column] = ChannelOf(value, column);
            }
        }
        return matrix;
    }
    std::uint32_t SizeInId() const {
        return _node.identifier.find("matrix33") != std::string::npos ? 3 : 4;
    }

    ShaderValue Determinant() { return DeterminantOf(MatrixInput(_node, "in", SizeInId())); }
    /// vector2M3 and vector3M4 are points, whose last component is 1.
    ShaderValue Transform() {
        const char last = _node.identifier.back();
        const bool isPoint = _node.identifier[_node.identifier.size() - 2] == 'M';
        const std::uint32_t size = static_cast<std::uint32_t>(last - '0');
        const ShaderValue in = Vector("in", {}, _n);
        std::array<ShaderValue, 4> vector;
        for (std::uint32_t k = 0; k < 4; ++k) {
            vector[k] = k < _n ? ChannelOf(in, k) : MakeScalar(isPoint ? 1.0F : 0.0F);
        }
        return Transformed(vector, MatrixInput(_node, "mat", size), _n);
    }
    ShaderValue Unshown() {
        _network.Warn("node " + _node.identifier + " of " + _node.path +
                      " gives a matrix, which cannot be shown");
        return {};
    }

    // Colours. Alpha passes.
    ShaderValue WithAlpha(const ShaderValue& color, const ShaderValue& in) const {
        return _n != 4 ? color
                       : CombineChannels(ChannelOf(color, 0), ChannelOf(color, 1),
                                         ChannelOf(color, 2), ChannelOf(in, 3), 4);
    }
    ShaderValue ColorInput() { return Vector("in", {0.0F, 0.0F, 0.0F, 1.0F}, _n); }
    static ShaderValue Gamma(const ShaderValue& in, float exponent) {
        const ShaderValue least = MakeMath(HDS_MATH_MAX, {in, MakeScalar(0.0F)}, 3);
        return MakeMath(HDS_MATH_POWER, {least, MakeScalar(exponent)}, 3);
    }
    /// IEC 61966-2-1.
    static ShaderValue FromSrgb(const ShaderValue& in) {
        const ShaderValue moved = MakeMath(HDS_MATH_ADD, {in, MakeScalar(0.055F)}, 3);
        const ShaderValue high =
            Gamma(MakeMath(HDS_MATH_DIVIDE, {moved, MakeScalar(1.055F)}, 3), 2.4F);
        const ShaderValue low = MakeMath(HDS_MATH_DIVIDE, {in, MakeScalar(12.92F)}, 3);
        return MakeMath(HDS_MATH_SELECT,
                        {MakeMath(HDS_MATH_GREATER, {in, MakeScalar(0.04045F)}, 3), high, low}, 3);
    }
    /// \param matrix by rows, for row vectors.
    static ShaderValue ByMatrix(const ShaderValue& in, const std::array<float, 9>& matrix) {
        Matrix values = Identity(3);
        for (std::uint32_t i = 0; i < 9; ++i) {
            values.at[i / 3][i % 3] = MakeScalar(matrix[i]);
        }
        return Transformed({ChannelOf(in, 0), ChannelOf(in, 1), ChannelOf(in, 2), ShaderValue()},
                           values, 3);
    }
    static constexpr std::array<float, 9> kAp1 = {
        1.705050992658F,  -0.130256417507F, -0.024003356805F, -0.621792120657F, 1.140804736575F,
        -0.128968976065F, -0.083258872001F, -0.010548319068F, 1.15297233287F};
    static constexpr std::array<float, 9> kAdobeRgb = {
        1.39835574F, 0.0F, 0.0F, -0.398355744F, 1.0F, -0.0429289893F, 0.0F, 0.0F, 1.04292899F};
    static constexpr std::array<float, 9> kDisplayP3 = {1.22493029F,  -0.04205868F, -0.01964128F,
                                                        -0.22492968F, 1.04205894F,  -0.07864794F,
                                                        0.00000006F,  -0.00000001F, 1.09828925F};

    /// \tparam kThousandths exponent times 1000; 1000: none
    template <int kThousandths, const std::array<float, 9>* kMatrix>
    ShaderValue ByCurveAndMatrix() {
        const ShaderValue in = ColorInput();
        ShaderValue color = in;
        if constexpr (kThousandths != 1000) {
            color = Gamma(color, float(kThousandths) / 1000.0F);
        }
        if constexpr (kMatrix != nullptr) {
            color = ByMatrix(color, *kMatrix);
        }
        return WithAlpha(color, in);
    }
    template <bool kIsP3>
    ShaderValue Srgb() {
        const ShaderValue in = ColorInput();
        const ShaderValue color = FromSrgb(in);
        return WithAlpha(kIsP3 ? ByMatrix(color, kDisplayP3) : color, in);
    }
    /// The exponent is 563 / 256.
    ShaderValue AdobeRgb() {
        const ShaderValue in = ColorInput();
        return WithAlpha(ByMatrix(Gamma(in, 2.19921875F), kAdobeRgb), in);
    }

private:
    std::map<std::uint32_t, NodeWalk<Matrix>> _walks; ///< by the size of the matrices
};

template <int kThousandths, const std::array<float, 9>* kMatrix = nullptr>
constexpr PatternFunction kColor = kPattern<&MatrixNode::ByCurveAndMatrix<kThousandths, kMatrix>>;

constexpr PatternType kTypes[] = {
    {"creatematrix", kPattern<&MatrixNode::Unshown>},
    {"transpose", kPattern<&MatrixNode::Unshown>},
    {"invertmatrix", kPattern<&MatrixNode::Unshown>},
    {"determinant", kPattern<&MatrixNode::Determinant>},
    {"transformmatrix", kPattern<&MatrixNode::Transform>},
    {"g18_rec709_to_lin_rec709", kColor<1800>},
    {"g22_rec709_to_lin_rec709", kColor<2200>},
    {"rec709_display_to_lin_rec709", kColor<2400>},
    {"acescg_to_lin_rec709", kColor<1000, &MatrixNode::kAp1>},
    {"g22_ap1_to_lin_rec709", kColor<2200, &MatrixNode::kAp1>},
    {"srgb_texture_to_lin_rec709", kPattern<&MatrixNode::Srgb<false>>},
    {"lin_adobergb_to_lin_rec709", kColor<1000, &MatrixNode::kAdobeRgb>},
    {"adobergb_to_lin_rec709", kPattern<&MatrixNode::AdobeRgb>},
    {"srgb_displayp3_to_lin_rec709", kPattern<&MatrixNode::Srgb<true>>},
    {"lin_displayp3_to_lin_rec709", kColor<1000, &MatrixNode::kDisplayP3>},
};

} // namespace

ShaderValue ExtractRow(NetworkEvaluator& network, const MaterialNode& node, std::uint32_t index) {
    const std::string output;
    MatrixNode reader(network, node, output);
    const std::uint32_t size = reader.SizeInId();
    const Matrix matrix = reader.MatrixInput(node, "in", size, 0.0F);
    const std::array<ShaderValue, 4>& row = matrix.at[std::min(index, size - 1)];
    return CombineChannels(row[0], row[1], row[2], row[3], size);
}

PatternTable MatrixNodes() {
    return PatternTable(kTypes);
}

} // namespace hds
