// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/motion.h"

#include "hdStream/scene/transforms.h"
#include "kernels/shared/frame.h"

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>

namespace hds {

namespace {

/// How far a box may be from where it should be, as a part of the way that it goes.
constexpr double kTolerance = 1.0 / 256.0;
/// What a light may be stretched by and still count as rigid.
constexpr double kMostStretch = 1e-4;

/// A matrix as translation, rotation and stretch (Shoemake and Duff 1992, "Matrix Animation and
/// Polar Decomposition").
struct Decomposed {
    glm::dvec3 translation{0.0};
    glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
    glm::dmat3 stretch{1.0};
};

/// \pre the matrix is usable.
Decomposed Decompose(const glm::dmat4& matrix) {
    const glm::dmat3 linear(matrix);
    glm::dmat3 rotation = linear;
    constexpr int kMaxIterations = 100;
    for (int i = 0; i < kMaxIterations; ++i) {
        const glm::dmat3 inverse = glm::transpose(glm::inverse(rotation));
        // Scaled by the determinant at first, which brings any size near 1 at once (Higham 1986).
        const double scale = std::pow(std::abs(glm::determinant(rotation)), -1.0 / 3.0);
        const glm::dmat3 next = 0.5 * (scale * rotation + inverse / scale);
        const glm::dmat3 change = next - rotation;
        rotation = next;
        if (glm::dot(change[0], change[0]) + glm::dot(change[1], change[1]) +
                glm::dot(change[2], change[2]) <
            1e-28) {
            break;
        }
    }
    if (glm::determinant(rotation) < 0.0) {
        rotation = -rotation; // a mirror image: its stretch is negative
    }
    return {glm::dvec3(matrix[3]), glm::quat_cast(rotation), glm::transpose(rotation) * linear};
}

glm::dmat4 Interpolate(const Decomposed& a, const Decomposed& b, double part) {
    const glm::dmat3 linear = glm::mat3_cast(glm::slerp(a.rotation, b.rotation, part)) *
                              ((1.0 - part) * a.stretch + part * b.stretch);
    glm::dmat4 matrix(linear);
    matrix[3] = glm::dvec4(glm::mix(a.translation, b.translation, part), 1.0);
    return matrix;
}

/// Of a matrix that maps space onto a plane: it has one for each side that the determinant may be
/// of. Nothing: it maps onto less, and any rotation is one of it. \param isMirrored the side
std::optional<glm::dquat> RotationOfFlat(const glm::dmat4& matrix, bool isMirrored) {
    const glm::dmat4 thick = ThickenFlat(matrix);
    if (!IsUsableTransform(thick)) {
        return std::nullopt;
    }
    return Decompose(isMirrored ? 2.0 * matrix - thick : thick).rotation;
}

/// Samples, decomposed once. What has no rotation of its own has that of the sample before, else of
/// the one behind: so what grows from nothing turns while it does.
class PoseCurve {
public:
    explicit PoseCurve(std::vector<TransformSample> samples) : _samples(std::move(samples)) {
        const auto usable =
            std::find_if(_samples.begin(), _samples.end(), [](const TransformSample& sample) {
                return IsUsableTransform(sample.matrix);
            });
        const bool isMirrored =
            usable != _samples.end() && glm::determinant(glm::dmat3(usable->matrix)) < 0.0;
        std::optional<glm::dquat> last;
        std::size_t numWithout = 0; // at the beginning
        for (const TransformSample& sample : _samples) {
            Decomposed pose;
            if (IsUsableTransform(sample.matrix)) {
                pose = Decompose(sample.matrix);
                last = pose.rotation;
            } else {
                const auto own = RotationOfFlat(sample.matrix, isMirrored);
                last = own ? own : last;
                numWithout += last ? 0 : 1;
                pose = WithRotation(sample.matrix, last.value_or(pose.rotation));
            }
            _poses.push_back(pose);
        }
        for (std::size_t i = 0; i < numWithout && numWithout < _poses.size(); ++i) {
            _poses[i] = WithRotation(_samples[i].matrix, _poses[numWithout].rotation);
        }
    }

    glm::dmat4 At(double time) const {
        const auto after =
            std::find_if(_samples.begin(), _samples.end(),
                         [time](const TransformSample& sample) { return sample.time >= time; });
        if (after == _samples.end()) {
            return _samples.back().matrix;
        }
        if (after == _samples.begin() || after->time == time) {
            return after->matrix;
        }
        const auto i = static_cast<std::size_t>(after - _samples.begin());
        const TransformSample& before = _samples[i - 1];
        const double part = (time - before.time) / (after->time - before.time);
        const glm::dmat4 between = (1.0 - part) * before.matrix + part * after->matrix;
        if (glm::dmat3(before.matrix) == glm::dmat3(after->matrix)) {
            glm::dmat4 matrix = before.matrix; // to the bit but for the translation
            matrix[3] = between[3];
            return matrix;
        }
        return Interpolate(_poses[i - 1], _poses[i], part);
    }

private:
    static Decomposed WithRotation(const glm::dmat4& matrix, const glm::dquat& rotation) {
        return {glm::dvec3(matrix[3]), rotation,
                glm::transpose(glm::mat3_cast(rotation)) * glm::dmat3(matrix)};
    }

    std::vector<TransformSample> _samples;
    std::vector<Decomposed> _poses; ///< of the samples
};

std::array<glm::dvec3, 8> CornersOf(const Bounds& bounds, const glm::dmat4& matrix) {
    std::array<glm::dvec3, 8> corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec4 corner((i & 1U) != 0 ? bounds.max.x : bounds.min.x,
                                (i & 2U) != 0 ? bounds.max.y : bounds.min.y,
                                (i & 4U) != 0 ? bounds.max.z : bounds.min.z, 1.0);
        corners[i] = glm::dvec3(matrix * corner);
    }
    return corners;
}

/// The largest distance between corners of the box in two poses.
double Distance(const Bounds& bounds, const glm::dmat4& a, const glm::dmat4& b) {
    const std::array<glm::dvec3, 8> corners = CornersOf(bounds, a);
    const std::array<glm::dvec3, 8> others = CornersOf(bounds, b);
    double largest = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        largest = std::max(largest, glm::distance(corners[i], others[i]));
    }
    return largest;
}

} // namespace

glm::dmat4 InterpolateTransform(const std::vector<TransformSample>& samples, double time) {
    return PoseCurve(samples).At(time);
}

std::vector<TransformSample> SamplesWithin(const std::vector<TransformSample>& samples,
                                           const Shutter& shutter) {
    if (!shutter.IsOpen() || samples.size() < 2) {
        return {};
    }
    const PoseCurve curve(samples);
    std::vector<TransformSample> within{{shutter.open, curve.At(shutter.open)}};
    for (const TransformSample& sample : samples) {
        if (sample.time > shutter.open && sample.time < shutter.close) {
            within.push_back(sample);
        }
    }
    within.push_back({shutter.close, curve.At(shutter.close)});
    const bool isAtRest =
        std::all_of(within.begin(), within.end(), [&within](const TransformSample& sample) {
            return sample.matrix == within[0].matrix;
        });
    return isAtRest ? std::vector<TransformSample>() : within;
}

MovingTransform::MovingTransform(const glm::dmat4& atFrame,
                                 const std::vector<TransformSample>& samples,
                                 const Shutter& shutter)
    : _transform(atFrame) {
    std::vector<TransformSample> within = SamplesWithin(samples, shutter);
    if (!within.empty()) {
        _at = [curve = std::make_shared<PoseCurve>(std::move(within)), shutter](double time) {
            return curve->At(time < 1.0 ? shutter.open + time * (shutter.close - shutter.open)
                                        : shutter.close);
        };
    }
}

MovingTransform MovingTransform::Directions() const {
    const auto directions = [](glm::dmat4 matrix) {
        const double size = std::cbrt(std::abs(glm::determinant(glm::dmat3(matrix))));
        matrix = glm::dmat4(glm::dmat3(matrix));
        return size > 0.0 ? glm::dmat4(glm::dmat3(matrix) / size) : matrix;
    };
    MovingTransform result(directions(_transform));
    if (Moves()) {
        result._at = [directions, at = _at](double time) { return directions(at(time)); };
    }
    return result;
}

MovingTransform operator*(const MovingTransform& outer, const MovingTransform& inner) {
    MovingTransform product(outer._transform * inner._transform);
    if (outer.Moves() || inner.Moves()) {
        product._at = [outer, inner](double time) { return outer.At(time) * inner.At(time); };
    }
    return product;
}

std::vector<glm::dmat4> MakeMotionKeys(const MovingTransform& transform, const Bounds& bounds) {
    for (std::size_t segments = 1;; segments *= 2) {
        std::vector<glm::dmat4> keys;
        for (std::size_t i = 0; i <= segments; ++i) {
            keys.push_back(transform.At(double(i) / double(segments)));
        }
        if (segments == HDS_MAX_MOTION_SEGMENTS) {
            return keys;
        }
        double way = 0.0;
        double error = 0.0;
        for (std::size_t i = 0; i < segments; ++i) {
            for (const double part : {0.25, 0.5, 0.75}) {
                const glm::dmat4 pose = transform.At((double(i) + part) / double(segments));
                const glm::dmat4 between = (1.0 - part) * keys[i] + part * keys[i + 1];
                way = std::max(way, Distance(bounds, pose, keys[0]));
                error = std::max(error, Distance(bounds, pose, between));
            }
            way = std::max(way, Distance(bounds, keys[i + 1], keys[0]));
        }
        if (!(error > kTolerance * way)) {
            return keys;
        }
    }
}

std::vector<glm::dvec4> TurnsOf(const std::vector<glm::dmat4>& poses, const glm::dmat4& rest,
                                bool* isRigid) {
    *isRigid = true;
    const glm::dmat3 objectFromWorld = glm::inverse(glm::dmat3(rest));
    std::vector<glm::dvec4> turns;
    for (const glm::dmat4& pose : poses) {
        glm::dmat4 turned(glm::dmat3(pose) * objectFromWorld);
        const Decomposed parts = Decompose(turned);
        const glm::dmat3 change = parts.stretch - glm::dmat3(1.0);
        for (int column = 0; column < 3; ++column) {
            *isRigid = *isRigid && glm::length(change[column]) < kMostStretch;
        }
        const glm::dquat& q = parts.rotation;
        const glm::dvec4 turn(q.x, q.y, q.z, q.w);
        const bool isLonger = !turns.empty() && glm::dot(turn, turns.back()) < 0.0;
        turns.push_back(isLonger ? -turn : turn);
    }
    return turns;
}

std::vector<LightKey> MakeLightKeys(const MovingTransform& worldFromLight, bool* isRigid) {
    *isRigid = true;
    const glm::dmat4& rest = worldFromLight.AtFrame();
    if (!worldFromLight.Moves() || !IsUsableTransform(rest)) {
        return {};
    }
    const std::vector<glm::dmat4> poses =
        MakeMotionKeys(worldFromLight, {glm::vec3(-1.0F), glm::vec3(1.0F)});
    if (!std::all_of(poses.begin(), poses.end(), IsUsableTransform)) {
        *isRigid = false;
        return {};
    }
    const std::vector<glm::dvec4> turns = TurnsOf(poses, rest, isRigid);
    std::vector<LightKey> keys;
    for (std::size_t i = 0; i < poses.size(); ++i) {
        keys.push_back({turns[i], glm::dvec3(poses[i][3] - rest[3])});
    }
    return keys;
}

bool MovesOver(const CameraPrim& camera, const Shutter& shutter) {
    return !SamplesWithin(camera.samples, shutter).empty();
}

LensSample LensOfFrame(const CameraPrim& camera) {
    return {0.0,
            camera.focalLength,
            camera.fStop,
            camera.focusDistance,
            camera.horizontalAperture,
            camera.verticalAperture,
            camera.horizontalApertureOffset,
            camera.verticalApertureOffset};
}

LensSample LensAt(const CameraPrim& camera, double time) {
    const std::vector<LensSample>& samples = camera.lensSamples;
    if (samples.empty()) {
        LensSample lens = LensOfFrame(camera);
        lens.time = time;
        return lens;
    }
    const auto after =
        std::find_if(samples.begin(), samples.end(),
                     [time](const LensSample& sample) { return sample.time >= time; });
    LensSample lens = after == samples.end() ? samples.back() : *after;
    if (after != samples.begin() && after != samples.end() && after->time > time) {
        const LensSample& before = *std::prev(after);
        const auto part = static_cast<float>((time - before.time) / (after->time - before.time));
        ForEachField<LensSample>([&](const auto& field) {
            if (!field.Is(&LensSample::time)) {
                lens.*field.member = glm::mix(before.*field.member, (*after).*field.member,
                                              static_cast<decltype(lens.*field.member + 0)>(part));
            }
        });
    }
    lens.time = time;
    return lens;
}

bool LensChangesOver(const CameraPrim& camera, const Shutter& shutter) {
    if (!shutter.IsOpen() || camera.lensSamples.empty()) {
        return false;
    }
    const auto differs = [](LensSample a, const LensSample& b) {
        a.time = b.time;
        return a != b;
    };
    const LensSample first = LensAt(camera, shutter.open);
    return differs(first, LensAt(camera, shutter.close)) ||
           std::any_of(camera.lensSamples.begin(), camera.lensSamples.end(),
                       [&](const LensSample& sample) {
                           return sample.time > shutter.open && sample.time < shutter.close &&
                                  differs(first, sample);
                       });
}

std::vector<glm::dmat4> MakeCameraKeys(const CameraPrim& camera, const Shutter& shutter) {
    const MovingTransform pose(camera.worldFromCamera, camera.samples, shutter);
    // What it sees moves with its rotation and its translation: the finer keys of the two.
    std::vector<TransformSample> turning = camera.samples;
    for (TransformSample& sample : turning) {
        sample.matrix[3] = glm::dvec4(0.0, 0.0, 0.0, 1.0);
    }
    const MovingTransform rotation(glm::dmat4(1.0), turning, shutter);
    const Bounds point{glm::vec3(0.0F), glm::vec3(0.0F)};
    const Bounds box{glm::vec3(-1.0F), glm::vec3(1.0F)};
    const std::size_t segments =
        std::max(MakeMotionKeys(pose, point).size(), MakeMotionKeys(rotation, box).size()) - 1;
    std::vector<glm::dmat4> keys;
    for (std::size_t i = 0; i <= segments; ++i) {
        keys.push_back(pose.At(double(i) / double(segments)));
    }
    return keys;
}

} // namespace hds
