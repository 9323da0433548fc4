// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/iesProfile.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

namespace hds {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMaxAngles = 1 << 16;
constexpr double kMaxValues = 1 << 24;
/// Of a light's radiance, too, there is no more.
constexpr double kMaxCandela = 1e30;
/// Polar angles that span more than a hemisphere by so much belong to a sphere.
constexpr double kHemisphereSlack = 0.1;

float Radians(double degrees) {
    return static_cast<float>(degrees * (kPi / 180.0));
}

/// The numbers of a text, which commas and white space separate.
class Numbers {
public:
    Numbers(const std::string& text, std::size_t begin)
        : _at(text.data() + begin), _end(text.data() + text.size()) {}

    /// False at the end, and at what is no finite number.
    bool Next(double* value) {
        while (_at != _end && (std::isspace(static_cast<unsigned char>(*_at)) || *_at == ',')) {
            ++_at;
        }
        if (_at != _end && *_at == '+') {
            ++_at;
        }
        const auto [end, problem] = std::from_chars(_at, _end, *value);
        _at = end;
        return problem == std::errc() && std::isfinite(*value);
    }

    /// A number of things, which must be whole.
    bool NextCount(double limit, std::size_t* count) {
        double value = 0.0;
        if (!Next(&value) || !(value >= 0.0 && value <= limit) || value != std::floor(value)) {
            return false;
        }
        *count = static_cast<std::size_t>(value);
        return true;
    }

    bool NextValues(std::size_t count, std::vector<double>* values) {
        values->resize(count);
        return std::all_of(values->begin(), values->end(),
                           [&](double& value) { return Next(&value); });
    }

private:
    const char* _at;
    const char* _end;
};

/// Where the numbers begin: behind the line TILT=..., whose value is told. npos: there is none.
std::size_t FindNumbers(const std::string& text, std::string* tilt) {
    std::size_t found = text.find("TILT=");
    while (found != std::string::npos && found > 0 && text[found - 1] != '\n' &&
           text[found - 1] != '\r') {
        found = text.find("TILT=", found + 1);
    }
    if (found == std::string::npos) {
        return found;
    }
    const std::size_t end = std::min(text.find_first_of("\r\n", found), text.size());
    *tilt = text.substr(found + 5, end - found - 5);
    tilt->erase(tilt->find_last_not_of(" \t") + 1);
    return end;
}

bool SkipTilt(Numbers* numbers) {
    std::size_t geometry = 0;
    std::size_t count = 0;
    std::vector<double> skipped;
    return numbers->NextCount(3.0, &geometry) && numbers->NextCount(kMaxAngles, &count) &&
           numbers->NextValues(2 * count, &skipped);
}

/// Of angles in degrees, once they are radians in single precision.
bool IsAscending(const std::vector<double>& angles) {
    return std::adjacent_find(angles.begin(), angles.end(), [](double a, double b) {
               return !(Radians(a) < Radians(b));
           }) == angles.end();
}

/// A file as it is, angles in degrees.
struct Table {
    std::vector<double> polars;
    std::vector<double> azimuths;
    std::vector<double> candela; ///< [azimuths][polars]
};

/// Reads what follows the line TILT=NONE. \return empty, or what is wrong.
std::string ReadTable(Numbers* numbers, Table* table) {
    std::size_t numPolars = 0;
    std::size_t numAzimuths = 0;
    std::size_t type = 0;
    double ignored = 0.0;
    double multiplier = 0.0;
    if (!numbers->Next(&ignored) || !numbers->Next(&ignored) || !numbers->Next(&multiplier) ||
        !numbers->NextCount(kMaxAngles, &numPolars) ||
        !numbers->NextCount(kMaxAngles, &numAzimuths) || !numbers->NextCount(3.0, &type)) {
        return "its header is incomplete";
    }
    if (type != 1) {
        return "its photometric type is not C";
    }
    if (numPolars < 2 || numAzimuths < 1 || double(numPolars) * double(numAzimuths) > kMaxValues) {
        return "its numbers of angles are out of range";
    }
    double ballast = 0.0;
    double ballastLamp = 0.0;
    std::vector<double> sizes;
    if (!numbers->NextValues(4, &sizes) || !numbers->Next(&ballast) ||
        !numbers->Next(&ballastLamp) || !numbers->Next(&ignored)) {
        return "its header is incomplete";
    }
    if (!numbers->NextValues(numPolars, &table->polars) ||
        !numbers->NextValues(numAzimuths, &table->azimuths) ||
        !numbers->NextValues(numPolars * numAzimuths, &table->candela)) {
        return "it ends before its last value, or has a word among the values";
    }
    if (!IsAscending(table->polars) || !IsAscending(table->azimuths) ||
        table->polars.front() < 0.0 || table->polars.back() > 180.0) {
        return "its angles are not in ascending order, or out of range";
    }
    for (double& value : table->candela) {
        value *= multiplier * ballast * ballastLamp;
        if (!(value <= kMaxCandela)) {
            return "its values are out of range";
        }
        value = std::max(value, 0.0);
    }
    return {};
}

/// Adds a column between two others, linear from `a` at 0 to `b` at 1. \return its number.
std::size_t AddBetween(std::size_t a, std::size_t b, double at, Table* table) {
    const std::size_t numPolars = table->polars.size();
    const std::size_t column = table->candela.size() / numPolars;
    for (std::size_t i = 0; i < numPolars; ++i) {
        table->candela.push_back((1.0 - at) * table->candela[a * numPolars + i] +
                                 at * table->candela[b * numPolars + i]);
    }
    return column;
}

/// The columns of azimuths around the whole circle, by the symmetry that the last angle tells.
/// \return pairs of azimuth and column; empty: not a range that LM-63 knows.
std::vector<std::pair<double, std::size_t>> WholeCircle(Table* table) {
    const std::vector<double>& azimuths = table->azimuths;
    const std::size_t count = azimuths.size();
    const double first = azimuths.front();
    const double last = azimuths.back();
    std::vector<std::pair<double, std::size_t>> columns;
    if (count == 1) { // the same all around
        return {{0.0, 0}, {360.0, 0}};
    }
    for (std::size_t i = 0; i < count; ++i) {
        columns.emplace_back(azimuths[i], i);
    }
    const auto mirrorAt = [&](double middle) {
        for (std::size_t i = columns.size(); i-- > 0;) {
            if (columns[i].first < middle) {
                columns.emplace_back(2.0 * middle - columns[i].first, columns[i].second);
            }
        }
    };
    if (first == 0.0 && last == 90.0) {
        mirrorAt(90.0);
        mirrorAt(180.0);
    } else if (first == 0.0 && last == 180.0) {
        mirrorAt(180.0);
    } else if (first == 90.0 && last == 270.0) {
        // Symmetric about the plane through 90 and 270 degrees: azimuth a has the column of 180 -
        // a.
        std::vector<std::pair<double, std::size_t>> whole;
        for (const auto& [azimuth, column] : columns) {
            whole.emplace_back(azimuth, column);
            const double mirrored = 180.0 - azimuth;
            if (azimuth > 90.0 && azimuth < 270.0) {
                whole.emplace_back(mirrored < 0.0 ? mirrored + 360.0 : mirrored, column);
            }
        }
        std::sort(whole.begin(), whole.end());
        if (whole.front().first > 0.0) { // none at 180 degrees, and so none at 0
            const double after = whole.front().first;
            const double before = 360.0 - whole.back().first;
            whole.insert(whole.begin(), {0.0, AddBetween(whole.front().second, whole.back().second,
                                                         after / (after + before), table)});
        }
        whole.emplace_back(360.0, whole.front().second);
        return whole;
    } else if (first != 0.0 || last > 360.0) {
        return {};
    } else if (last < 360.0) {
        columns.emplace_back(360.0, 0);
    }
    return columns;
}

/// Integrals of 1 - t and of t, times sin, over [a, b], t from 0 to 1.
std::pair<double, double> SineWeights(double a, double b) {
    const double whole = std::cos(a) - std::cos(b);
    const double high = (std::sin(b) - std::sin(a)) / (b - a) - std::cos(b);
    return {whole - high, high};
}

} // namespace

double IesProfile::MeanIntensity() const {
    double sum = 0.0;
    const std::size_t numPolars = polars.size();
    for (std::size_t i = 0; i + 1 < numPolars; ++i) {
        const auto [low, high] = SineWeights(polars[i], polars[i + 1]);
        for (std::size_t j = 0; j + 1 < azimuths.size(); ++j) {
            const float* a = &candela[j * numPolars + i];
            const float* b = a + numPolars;
            sum += 0.5 * (double(azimuths[j + 1]) - azimuths[j]) *
                   (low * (double(a[0]) + b[0]) + high * (double(a[1]) + b[1]));
        }
    }
    const bool isSphere = polars.back() - polars.front() > 0.5 * kPi + kHemisphereSlack;
    return sum / (isSphere ? 4.0 * kPi : 2.0 * kPi);
}

IesProfile ParseIesProfile(const std::string& text, std::string* error) {
    std::string tilt;
    const std::size_t begin = FindNumbers(text, &tilt);
    if (begin == std::string::npos) {
        *error = "it has no line TILT=";
        return {};
    }
    Numbers numbers(text, begin);
    if (tilt == "INCLUDE" && !SkipTilt(&numbers)) {
        *error = "its TILT data are incomplete";
        return {};
    }
    Table table;
    *error = ReadTable(&numbers, &table);
    if (!error->empty()) {
        return {};
    }
    const auto columns = WholeCircle(&table);
    if (columns.empty()) {
        *error = "its horizontal angles do not go from 0 to 0, 90, 180 or 360 degrees";
        return {};
    }
    IesProfile profile;
    for (const double polar : table.polars) {
        profile.polars.push_back(Radians(polar));
    }
    const std::size_t numPolars = table.polars.size();
    for (const auto& [azimuth, column] : columns) {
        profile.azimuths.push_back(Radians(azimuth));
        for (std::size_t i = 0; i < numPolars; ++i) {
            profile.candela.push_back(static_cast<float>(table.candela[column * numPolars + i]));
        }
    }
    return profile;
}

} // namespace hds
