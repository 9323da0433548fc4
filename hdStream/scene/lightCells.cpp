// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/lightCells.h"

#include "hdStream/shading/lightShaping.h"
#include "hdStream/shading/lightUnits.h"

#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace hds {

namespace {

/// By how much of its greatest value a number may change from cell to cell.
constexpr double kStep = 1.0 / 128.0;
/// What transforms differ by that say the same.
constexpr double kRounding = 1e-12;
/// What is as small as that of its greatest size still has one.
constexpr float kLeastSize = 1.0F / 65536.0F;

/// A size, and what kinds of light have it.
struct Size {
    float LightDescription::*value;
    std::array<LightType, 3> types;

    bool IsOf(const LightDescription& light) const {
        return std::find(types.begin(), types.end(), light.type) != types.end();
    }
};

constexpr std::array<Size, 5> kSizes{{
    {&LightDescription::angle, {LightType::Distant, LightType::Distant, LightType::Distant}},
    {&LightDescription::radius, {LightType::Sphere, LightType::Disk, LightType::Cylinder}},
    {&LightDescription::width, {LightType::Rect, LightType::Rect, LightType::Rect}},
    {&LightDescription::height, {LightType::Rect, LightType::Rect, LightType::Rect}},
    {&LightDescription::length, {LightType::Cylinder, LightType::Cylinder, LightType::Cylinder}},
}};

/// What the keys say of the light's motion at a time, as kernels interpolate them, taken away.
glm::dmat4 WithoutKeys(const glm::dmat4& pose, const glm::dvec3& pivot,
                       const std::vector<LightKey>& keys, double time) {
    const double scaled = time * double(keys.size() - 1);
    const std::size_t segment = std::min(std::size_t(scaled), keys.size() - 2);
    const double part = scaled - double(segment);
    const glm::dvec4 turn =
        glm::normalize(glm::mix(keys[segment].turn, keys[segment + 1].turn, part));
    const glm::dvec3 offset = glm::mix(keys[segment].offset, keys[segment + 1].offset, part);
    const glm::dmat3 back =
        glm::transpose(glm::mat3_cast(glm::dquat(turn.w, turn.x, turn.y, turn.z)));
    glm::dmat4 rest(back * glm::dmat3(pose));
    rest[3] = glm::dvec4(pivot + back * (glm::dvec3(pose[3]) - pivot - offset), 1.0);
    return rest;
}

/// What of the transform counts. A distant light has a direction alone, unless it is shaped, and a
/// sky without an image has none.
glm::dmat4 TransformOf(const LightCell& cell) {
    if (cell.light.type == LightType::Dome && cell.light.textureFile.authoredPath.empty()) {
        return glm::dmat4(0.0);
    }
    const double length = glm::length(cell.worldFromLight[2]);
    if (cell.light.type != LightType::Distant || !IsUnshaped(cell.light) || !(length > 0.0)) {
        return cell.worldFromLight;
    }
    glm::dmat4 direction(0.0);
    direction[2] = cell.worldFromLight[2] / length;
    return direction;
}

/// All that may change of a cell and that its kind of light has, as numbers.
std::array<double, 20> NumbersOf(const LightCell& cell) {
    std::array<double, 20> numbers{};
    const glm::dvec3 emission = LightEmission(cell.light);
    auto out = numbers.begin();
    for (int i = 0; i < 3; ++i) {
        *out++ = emission[i];
    }
    for (const Size& size : kSizes) {
        *out++ = size.IsOf(cell.light) ? double(cell.light.*size.value) : 0.0;
    }
    const glm::dmat4 transform = TransformOf(cell);
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 3; ++row) {
            *out++ = transform[column][row];
        }
    }
    return numbers;
}

/// The greatest change between neighbours, each number as part of its greatest value: of a matrix,
/// of its lengths.
double GreatestStep(const std::vector<LightCell>& cells) {
    std::vector<std::array<double, 20>> numbers;
    std::array<double, 20> greatest{};
    for (const LightCell& cell : cells) {
        numbers.push_back(NumbersOf(cell));
        for (std::size_t i = 0; i < greatest.size(); ++i) {
            greatest[i] = std::max(greatest[i], std::abs(numbers.back()[i]));
        }
    }
    constexpr std::size_t kMatrix = 8; // its first number
    const double length =
        *std::max_element(greatest.begin() + kMatrix, greatest.begin() + kMatrix + 9);
    std::fill(greatest.begin() + kMatrix, greatest.end(), length);
    double step = 0.0;
    for (std::size_t n = 1; n < numbers.size(); ++n) {
        for (std::size_t i = 0; i < greatest.size(); ++i) {
            const double change = std::abs(numbers[n][i] - numbers[n - 1][i]);
            step = change > 0.0 ? std::max(step, change / std::max(greatest[i], 1e-300)) : step;
        }
    }
    return step;
}

} // namespace

std::vector<LightCell> MakeLightCells(const LightPrim& prim, const Shutter& shutter,
                                      const MovingTransform& worldFromLight,
                                      const std::vector<LightKey>& keys, bool isRigid,
                                      std::size_t most) {
    const bool isPlain = prim.samples.empty() || !shutter.IsOpen();
    const bool keepsPlace =
        (!keys.empty() && isRigid) || !worldFromLight.Moves() || !prim.portals.empty();
    if (isPlain && keepsPlace) {
        return {};
    }
    const glm::dmat4& frame = worldFromLight.AtFrame();
    const auto at = [&](double time) {
        LightCell cell{prim.light, frame};
        if (!isPlain) {
            cell.light = LightAt(prim.light, prim.samples,
                                 shutter.open + time * (shutter.close - shutter.open));
        }
        if (!keepsPlace) {
            cell.worldFromLight = worldFromLight.At(time);
            if (!keys.empty()) {
                cell.worldFromLight =
                    WithoutKeys(cell.worldFromLight, glm::dvec3(frame[3]), keys, time);
            }
        }
        return cell;
    };
    const auto cut = [&](std::size_t count) {
        std::vector<LightCell> cells;
        for (std::size_t i = 0; i < count; ++i) {
            cells.push_back(at((double(i) + 0.5) / double(count)));
        }
        return cells;
    };
    std::vector<LightCell> cells = cut(most);
    const double step = GreatestStep(cells);
    std::size_t count = 1;
    while (count < most && step * double(most) / double(count) > kStep) {
        count *= 2;
    }
    if (count < most) {
        cells = cut(count);
    }
    if (cells.size() == 1 && GreatestStep({cells[0], LightCell{prim.light, frame}}) <= kRounding) {
        return {};
    }
    const LightDescription largest = MostOf(prim.light, cells);
    for (LightCell& cell : cells) {
        for (const Size& size : kSizes) {
            float& own = cell.light.*size.value;
            own = std::max(own, kLeastSize * (largest.*size.value));
        }
    }
    return cells;
}

LightDescription MostOf(const LightDescription& light, const std::vector<LightCell>& cells) {
    LightDescription most = light;
    double brightest = -1.0;
    for (const LightCell& cell : cells) {
        for (const Size& size : kSizes) {
            most.*size.value = std::max(most.*size.value, cell.light.*size.value);
        }
        const glm::dvec3 emission = LightEmission(cell.light);
        const double luminance = 0.2126 * emission.x + 0.7152 * emission.y + 0.0722 * emission.z;
        if (luminance > brightest) {
            brightest = luminance;
            most.intensity = cell.light.intensity;
            most.exposure = cell.light.exposure;
            most.color = cell.light.color;
            most.colorTemperature = cell.light.colorTemperature;
        }
    }
    return most;
}

} // namespace hds
