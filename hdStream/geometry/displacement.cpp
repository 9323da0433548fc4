// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/displacement.h"

#include "hdStream/geometry/primvars.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace hds {
namespace {

double Finite(double value) {
    return std::isfinite(value) ? value : 0.0;
}

class ConstantAmount : public DisplacementAmount {
public:
    explicit ConstantAmount(double amount) : _amount(Finite(amount)) {}
    const std::vector<AmountPrimvar>& Primvars() const override { return _primvars; }
    double At(const AmountPoint&) const override { return _amount; }
    AmountRange Over(const AmountBox&) const override { return {_amount, _amount}; }

private:
    std::vector<AmountPrimvar> _primvars;
    double _amount;
};

class PrimvarAmount : public DisplacementAmount {
public:
    PrimvarAmount(std::string primvar, double fallback)
        : _primvars{{{std::move(primvar)}, 1, {Finite(fallback)}}} {}
    const std::vector<AmountPrimvar>& Primvars() const override { return _primvars; }
    double At(const AmountPoint& point) const override { return point.primvars[0][0]; }
    AmountRange Over(const AmountBox& box) const override {
        return {box.low.primvars[0][0], box.high.primvars[0][0]};
    }

private:
    std::vector<AmountPrimvar> _primvars;
};

/// Index of the first of its names that is there and has enough components.
std::size_t FindPrimvar(const AmountPrimvar& primvar,
                        const std::vector<GeometryAttribute>& attributes) {
    for (const std::string& name : primvar.names) {
        const auto found = std::find_if(
            attributes.begin(), attributes.end(), [&](const GeometryAttribute& attribute) {
                return attribute.name == name && !attribute.values.empty() &&
                       attribute.numComponents >= primvar.numComponents;
            });
        if (found != attributes.end()) {
            return std::size_t(found - attributes.begin());
        }
    }
    return BoundAmount::kMissing;
}

/// The first four components of a value of a primvar.
std::array<double, 4> ReadValue(const GeometryAttribute& attribute, std::size_t element) {
    std::array<double, 4> value{};
    const float* from = ValueOf(attribute, element);
    std::transform(from, from + std::min(attribute.numComponents, 4U), value.begin(), Finite);
    return value;
}

/// Which value of a primvar a face-vertex has.
std::size_t ElementOf(const GeometryAttribute& attribute, std::size_t face, std::size_t corner,
                      std::size_t point) {
    switch (attribute.interpolation) {
    case Interpolation::Uniform:
        return face;
    case Interpolation::FaceVarying:
        return corner;
    case Interpolation::Constant:
        return 0;
    default:
        return point;
    }
}

/// All values of a primvar.
void AddRange(const GeometryAttribute& attribute, std::array<double, 4>* low,
              std::array<double, 4>* high) {
    low->fill(0.0);
    high->fill(0.0);
    for (std::size_t i = 0; i < attribute.values.size(); ++i) {
        const double value = Finite(attribute.values[i]);
        const std::size_t c = i % attribute.numComponents;
        if (c < 4) {
            const bool isFirst = i < attribute.numComponents;
            (*low)[c] = isFirst ? value : std::min((*low)[c], value);
            (*high)[c] = isFirst ? value : std::max((*high)[c], value);
        }
    }
}

/// Of all poses of a mesh, with what approximations of limit surfaces leave its points by.
void AddPositions(const GeometryDescription& mesh, glm::dvec3* low, glm::dvec3* high) {
    constexpr double kMargin = 1.0 / 64.0;
    constexpr double kFar = 1e18; // points beyond are dropped with their faces
    bool isFirst = true;
    const auto add = [&](const SharedSpan<float>& points) {
        for (std::size_t i = 0; i + 3 <= points.size(); i += 3) {
            const glm::dvec3 point(points[i], points[i + 1], points[i + 2]);
            if (!(std::fabs(point.x) <= kFar && std::fabs(point.y) <= kFar &&
                  std::fabs(point.z) <= kFar)) {
                continue;
            }
            *low = isFirst ? point : glm::min(*low, point);
            *high = isFirst ? point : glm::max(*high, point);
            isFirst = false;
        }
    };
    add(mesh.points);
    for (const ShutterKey& key : mesh.keys) {
        add(key.points);
    }
    const glm::dvec3 margin = kMargin * (*high - *low);
    *low -= margin;
    *high += margin;
}

AmountRange RangeOver(const BoundAmount& bound, const std::vector<GeometryAttribute>& attributes,
                      const GeometryDescription& mesh) {
    AmountBox box{MissingPoint(*bound.amount), MissingPoint(*bound.amount)};
    for (std::size_t i = 0; i < bound.attributes.size(); ++i) {
        if (bound.attributes[i] != BoundAmount::kMissing) {
            AddRange(attributes[bound.attributes[i]], &box.low.primvars[i], &box.high.primvars[i]);
        }
    }
    if (bound.amount->ReadsPosition()) {
        AddPositions(mesh, &box.low.position, &box.high.position);
    }
    AmountRange range = bound.amount->Over(box);
    if (!std::isfinite(range.low) || !std::isfinite(range.high)) {
        AddPositions(mesh, &box.low.position, &box.high.position);
        const double limit = glm::length(box.high.position - box.low.position);
        range.low = std::isfinite(range.low) ? range.low : std::min(-limit, range.high);
        range.high = std::isfinite(range.high) ? range.high : std::max(limit, range.low);
        range.low = std::isfinite(range.low) ? range.low : -limit;
        range.high = std::isfinite(range.high) ? range.high : limit;
    }
    return range;
}

} // namespace

std::shared_ptr<const DisplacementAmount> MakeConstantAmount(double amount) {
    return std::make_shared<ConstantAmount>(amount);
}

std::shared_ptr<const DisplacementAmount> MakePrimvarAmount(std::string primvar, double fallback) {
    return std::make_shared<PrimvarAmount>(std::move(primvar), fallback);
}

AmountPoint MissingPoint(const DisplacementAmount& amount) {
    AmountPoint point;
    for (const AmountPrimvar& primvar : amount.Primvars()) {
        point.primvars.push_back(primvar.missing);
    }
    return point;
}

std::vector<BoundAmount> BindAmounts(const Displacement& displacement,
                                     const std::vector<GeometryAttribute>& attributes) {
    std::vector<BoundAmount> result;
    for (const auto& amount : displacement) {
        BoundAmount& bound = result.emplace_back();
        if (!amount) {
            continue;
        }
        bool varies = amount->ReadsPosition() || amount->Space() != DisplacementSpace::Normal;
        for (const AmountPrimvar& primvar : amount->Primvars()) {
            const std::size_t index = FindPrimvar(primvar, attributes);
            bound.attributes.push_back(index);
            varies = varies || index != BoundAmount::kMissing;
        }
        bound.amount = varies ? amount.get() : nullptr;
        bound.constant = varies ? 0.0 : amount->At(MissingPoint(*amount));
    }
    return result;
}

bool HasVectors(const std::vector<BoundAmount>& amounts) {
    return std::any_of(amounts.begin(), amounts.end(), [](const BoundAmount& bound) {
        return bound.amount != nullptr && bound.amount->Space() != DisplacementSpace::Normal;
    });
}

bool LacksCoordinates(const std::vector<BoundAmount>& amounts) {
    return std::any_of(amounts.begin(), amounts.end(), [](const BoundAmount& bound) {
        return bound.amount != nullptr && bound.amount->Space() == DisplacementSpace::Tangent &&
               bound.attributes[bound.amount->Coordinates()] == BoundAmount::kMissing;
    });
}

glm::dvec3 FromTangentSpace(const CoordinateFrame& frame, const glm::dvec3& vector) {
    const glm::dvec2& u = frame.coordinatesU;
    const glm::dvec2& v = frame.coordinatesV;
    const glm::dvec3& normal = frame.normal;
    const glm::dvec3 up = vector.z * normal;
    const double determinant = u.x * v.y - u.y * v.x;
    const double side = determinant < 0.0 ? -1.0 : 1.0; // directions are all that counts
    const glm::dvec3 alongS = side * (v.y * frame.pointU - u.y * frame.pointV);
    const glm::dvec3 alongT = side * (u.x * frame.pointV - v.x * frame.pointU);
    const glm::dvec3 flat = alongS - glm::dot(alongS, normal) * normal;
    const double length = glm::length(flat);
    if (determinant == 0.0 || !(length > 1e-12 * glm::length(alongS)) || !std::isfinite(length)) {
        return up;
    }
    const glm::dvec3 tangent = flat / length;
    const glm::dvec3 across = glm::cross(normal, tangent);
    const glm::dvec3 bitangent = glm::dot(across, alongT) < 0.0 ? -across : across;
    return vector.x * tangent + vector.y * bitangent + up;
}

glm::dvec3 LimitedVector(const DisplacementAmount& amount, const AmountPoint& point,
                         const AmountRange& range) {
    const glm::dvec3 vector = amount.VectorAt(point);
    const double most = std::max(std::fabs(range.low), std::fabs(range.high));
    const double length = glm::length(vector);
    return length > most ? vector * (most / length) : vector;
}

AmountRange RangeOf(const std::vector<BoundAmount>& amounts,
                    const std::vector<GeometryAttribute>& attributes,
                    const GeometryDescription& mesh, bool hasOthers) {
    if (amounts.empty()) {
        return {};
    }
    AmountRange range{1e300, -1e300};
    const auto add = [&](const AmountRange& other) {
        range.low = std::min(range.low, other.low);
        range.high = std::max(range.high, other.high);
    };
    for (const BoundAmount& bound : amounts) {
        add(bound.amount == nullptr ? AmountRange{bound.constant, bound.constant}
                                    : RangeOver(bound, attributes, mesh));
    }
    if (hasOthers) {
        add({});
    }
    return range;
}

namespace {

/// A face-vertex that an amount moves.
struct DisplacedCorner {
    std::size_t face = 0;
    std::size_t corner = 0;
    std::size_t begin = 0; ///< of the face's face-vertices
    std::size_t end = 0;
    std::size_t point = 0;
};

/// Goes through the face-vertices of the faces. \param add what a displaced one adds, with its
/// amount \return how many face-vertices each point has
template <typename Add>
std::vector<std::uint32_t> ForEachCorner(const GeometryDescription& mesh,
                                         const std::vector<std::uint32_t>& entries,
                                         const std::vector<BoundAmount>& amounts, const Add& add) {
    const std::size_t numPoints = mesh.points.size() / 3;
    std::vector<std::uint32_t> counts(numPoints);
    std::size_t corner = 0;
    for (std::size_t face = 0; face < mesh.faceVertexCounts.size(); ++face) {
        const std::uint32_t entry = entries.empty() ? 0 : entries[face];
        const std::size_t begin = corner;
        const auto end = corner + std::size_t(std::max(mesh.faceVertexCounts[face], 0));
        for (; corner < end && corner < mesh.faceVertexIndices.size(); ++corner) {
            const std::int32_t point = mesh.faceVertexIndices[corner];
            if (point < 0 || std::size_t(point) >= numPoints) {
                continue;
            }
            ++counts[point];
            if (entry < amounts.size()) {
                add(DisplacedCorner{face, corner, begin, end, std::size_t(point)}, amounts[entry]);
            }
        }
        corner = end;
    }
    return counts;
}

/// What the amount of a face-vertex is asked with.
AmountPoint PointOf(const DisplacedCorner& at, const BoundAmount& bound,
                    const SharedSpan<float>& points,
                    const std::vector<GeometryAttribute>& attributes) {
    AmountPoint result = MissingPoint(*bound.amount);
    for (std::size_t i = 0; i < bound.attributes.size(); ++i) {
        if (bound.attributes[i] != BoundAmount::kMissing) {
            const GeometryAttribute& attribute = attributes[bound.attributes[i]];
            result.primvars[i] =
                ReadValue(attribute, ElementOf(attribute, at.face, at.corner, at.point));
        }
    }
    const auto xyz = 3 * at.point;
    result.position = {Finite(points[xyz]), Finite(points[xyz + 1]), Finite(points[xyz + 2])};
    return result;
}

/// By the edges of the face at the face-vertex.
CoordinateFrame FrameOf(const DisplacedCorner& at, const GeometryDescription& mesh,
                        const SharedSpan<float>& points, const GeometryAttribute& coordinates) {
    const auto read = [&](std::size_t corner, glm::dvec3* position, glm::dvec2* st) {
        const std::int32_t index = mesh.faceVertexIndices[corner];
        const std::size_t point = index < 0 || std::size_t(index) >= mesh.points.size() / 3
                                      ? at.point
                                      : std::size_t(index);
        const float* p = points.data() + 3 * point;
        *position = {Finite(p[0]), Finite(p[1]), Finite(p[2])};
        const std::array<double, 4> value =
            ReadValue(coordinates, ElementOf(coordinates, at.face, corner, point));
        *st = {value[0], value[1]};
    };
    const std::size_t end = std::min(at.end, mesh.faceVertexIndices.size());
    glm::dvec3 here;
    glm::dvec2 hereSt;
    CoordinateFrame frame;
    read(at.corner, &here, &hereSt);
    read(at.corner + 1 < end ? at.corner + 1 : at.begin, &frame.pointU, &frame.coordinatesU);
    read(at.corner > at.begin ? at.corner - 1 : end - 1, &frame.pointV, &frame.coordinatesV);
    frame.pointU -= here;
    frame.pointV -= here;
    frame.coordinatesU -= hereSt;
    frame.coordinatesV -= hereSt;
    return frame;
}

} // namespace

std::vector<glm::dvec3> PointVectors(const GeometryDescription& mesh,
                                     const SharedSpan<float>& points,
                                     const GeometryAttribute& normals, const AmountRange& range,
                                     const std::vector<std::uint32_t>& entries,
                                     const std::vector<GeometryAttribute>& attributes,
                                     const Displacement& displacement) {
    const std::vector<BoundAmount> amounts = BindAmounts(displacement, attributes);
    if (!HasVectors(amounts)) {
        return {};
    }
    std::vector<glm::dvec3> sums(mesh.points.size() / 3, glm::dvec3(0.0));
    const auto add = [&](const DisplacedCorner& at, const BoundAmount& bound) {
        if (bound.amount == nullptr || bound.amount->Space() == DisplacementSpace::Normal) {
            return;
        }
        const glm::dvec3 vector =
            LimitedVector(*bound.amount, PointOf(at, bound, points, attributes), range);
        if (bound.amount->Space() == DisplacementSpace::Object) {
            sums[at.point] += vector;
            return;
        }
        const std::size_t index = bound.attributes[bound.amount->Coordinates()];
        CoordinateFrame frame;
        if (index != BoundAmount::kMissing) {
            frame = FrameOf(at, mesh, points, attributes[index]);
        }
        const float* n = ValueOf(normals, at.point);
        frame.normal = {n[0], n[1], n[2]};
        sums[at.point] += FromTangentSpace(frame, vector);
    };
    const std::vector<std::uint32_t> counts = ForEachCorner(mesh, entries, amounts, add);
    for (std::size_t point = 0; point < sums.size(); ++point) {
        sums[point] /= std::max(counts[point], 1U);
    }
    return sums;
}

std::vector<float> PointAmounts(const GeometryDescription& mesh, const SharedSpan<float>& points,
                                const AmountRange& range, const std::vector<std::uint32_t>& entries,
                                const std::vector<GeometryAttribute>& attributes,
                                const Displacement& displacement) {
    const std::vector<BoundAmount> amounts = BindAmounts(displacement, attributes);
    std::vector<double> sums(mesh.points.size() / 3);
    const auto add = [&](const DisplacedCorner& at, const BoundAmount& bound) {
        if (bound.amount == nullptr) {
            sums[at.point] += bound.constant;
        } else if (bound.amount->Space() == DisplacementSpace::Normal) {
            const AmountPoint point = PointOf(at, bound, points, attributes);
            sums[at.point] += glm::clamp(bound.amount->At(point), range.low, range.high);
        }
    };
    const std::vector<std::uint32_t> counts = ForEachCorner(mesh, entries, amounts, add);
    std::vector<float> result(sums.size());
    for (std::size_t point = 0; point < sums.size(); ++point) {
        result[point] = counts[point] > 0 ? float(sums[point] / counts[point]) : 0.0F;
    }
    return result;
}

} // namespace hds
