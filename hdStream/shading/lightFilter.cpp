// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/lightFilter.h"

#include "kernels/shared/filterCombine.h"

#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <set>
#include <utility>

namespace hds {

namespace {

using Names = std::initializer_list<const char*>;

constexpr const char* kIntMult = "PxrIntMultLightFilter";
constexpr const char* kBarn = "PxrBarnLightFilter";
constexpr const char* kBlocker = "PxrBlockerLightFilter"; // a rod with fewer inputs
constexpr const char* kCookie = "PxrCookieLightFilter";
constexpr const char* kGobo = "PxrGoboLightFilter";
constexpr const char* kRamp = "PxrRampLightFilter";
constexpr const char* kRod = "PxrRodLightFilter";

/// The node's parameters by name: "ri:" in front of a name says nothing. Those that nobody asked
/// for are told.
class Parameters {
public:
    explicit Parameters(const MaterialNode& node) : _node(node) {}

    const ParameterValue* Find(Names names) {
        for (const char* name : names) {
            for (const std::string& key : {std::string(name), std::string("ri:") + name}) {
                _asked.insert(key);
                const auto found = _node.parameters.find(key);
                if (found != _node.parameters.end()) {
                    _known.insert(key);
                    return &found->second;
                }
            }
        }
        return nullptr;
    }

    double Number(Names names, double fallback) {
        const ParameterValue* value = Find(names);
        if (value == nullptr) {
            return fallback;
        }
        double result = fallback;
        if (const auto* number = std::get_if<double>(value)) {
            result = *number;
        } else if (const auto* integer = std::get_if<std::int64_t>(value)) {
            result = double(*integer);
        } else if (const auto* flag = std::get_if<bool>(value)) {
            result = *flag ? 1.0 : 0.0;
        }
        return std::isfinite(result) ? result : fallback;
    }

    /// The index of a choice among texts, or a number as RenderMan has it.
    std::uint32_t Choice(Names names, Names choices, std::uint32_t fallback) {
        const ParameterValue* value = Find(names);
        if (value == nullptr) {
            return fallback;
        }
        if (const auto* text = std::get_if<std::string>(value)) {
            const auto* found = std::find(choices.begin(), choices.end(), *text);
            return found == choices.end() ? fallback : std::uint32_t(found - choices.begin());
        }
        const auto* number = std::get_if<std::int64_t>(value);
        const bool isKnown =
            number != nullptr && *number >= 0 && *number < std::int64_t(choices.size());
        return isKnown ? std::uint32_t(*number) : fallback;
    }

    std::vector<float> Floats(Names names) {
        const ParameterValue* value = Find(names);
        const auto* floats = value == nullptr ? nullptr : std::get_if<std::vector<float>>(value);
        return floats == nullptr ? std::vector<float>() : *floats;
    }

    glm::dvec3 Color(Names names, const glm::dvec3& fallback) {
        const std::vector<float> rgb = Floats(names);
        return rgb.size() == 3
                   ? glm::dvec3(LightFactor(rgb[0]), LightFactor(rgb[1]), LightFactor(rgb[2]))
                   : fallback;
    }

    /// All names that were asked for.
    const std::set<std::string>& Asked() const { return _asked; }

    /// What is authored and was not asked for, in the order of names.
    std::vector<std::string> Unknown() const {
        std::vector<std::string> unknown;
        for (const auto& [name, value] : _node.parameters) {
            const bool isOfAnalytic = name.rfind("analytic:", 0) == 0; // of modes that are left out
            const bool isMetadata = name.rfind("colorSpace:", 0) == 0;
            if (_known.count(name) == 0 && !isMetadata && !isOfAnalytic && !IsNeutral(value)) {
                unknown.push_back(name);
            }
        }
        for (const auto& [name, source] : _node.connections) {
            unknown.push_back("a shader on " + name);
        }
        return unknown;
    }

private:
    /// Exporters write every input.
    static bool IsNeutral(const ParameterValue& value) {
        const auto* flag = std::get_if<bool>(&value);
        const auto* number = std::get_if<double>(&value);
        const auto* integer = std::get_if<std::int64_t>(&value);
        const auto* text = std::get_if<std::string>(&value);
        return (flag != nullptr && !*flag) || (number != nullptr && *number == 0.0) ||
               (integer != nullptr && *integer == 0) ||
               (text != nullptr && (text->empty() || *text == "physical" || *text == "linear"));
    }

    const MaterialNode& _node;
    std::set<std::string> _known;
    std::set<std::string> _asked;
};

void Write(const glm::dvec3& v, float* out) {
    for (int i = 0; i < 3; ++i) {
        out[i] = float(v[i]);
    }
}

/// Half the size along an axis and the ends of the inner box there.
void WriteExtent(double size, double scale, double low, double high, float* lowOut,
                 float* highOut) {
    *lowOut = float(-(0.5 * size + low) * scale);
    *highOut = float((0.5 * size + high) * scale);
}

/// The region of a barn or a rod; the region of a barn has no depth.
void ReadRegion(Parameters* in, bool isBarn, shared::HdsLightFilter* out) {
    const double scaleX = in->Number({"scale:width", "scaleWidth"}, 1.0);
    const double scaleY = in->Number({"scale:height", "scaleHeight"}, 1.0);
    double least = std::min(scaleX, scaleY);
    WriteExtent(in->Number({"width"}, 1.0), scaleX, in->Number({"refine:left", "left"}, 0.0),
                in->Number({"refine:right", "right"}, 0.0), &out->low[0], &out->high[0]);
    WriteExtent(in->Number({"height"}, 1.0), scaleY, in->Number({"refine:bottom", "bottom"}, 0.0),
                in->Number({"refine:top", "top"}, 0.0), &out->low[1], &out->high[1]);
    if (!isBarn) {
        const double scaleZ = in->Number({"scale:depth", "scaleDepth"}, 1.0);
        least = std::min(least, scaleZ);
        WriteExtent(in->Number({"depth"}, 1.0), scaleZ, in->Number({"refine:back", "back"}, 0.0),
                    in->Number({"refine:front", "front"}, 0.0), &out->low[2], &out->high[2]);
    }
    out->radius = float(std::max(in->Number({"radius"}, 0.5) * least, 0.0));
    out->edge = float(std::max(in->Number({"edgeThickness", "edge"}, 0.0), 0.0));
}

void ReadBarn(Parameters* in, shared::HdsLightFilter* out) {
    out->type |= HDS_FILTER_BARN;
    ReadRegion(in, true, out);
    out->mode = in->Choice({"preBarnEffect", "preBarn"}, {"noEffect", "cone", "noLight"},
                           HDS_FILTER_PASSES);
    Write(glm::dvec3(in->Number({"intensity"}, 1.0)), out->inside);
}

/// Appends a ramp: positions from 0 to 1 and a colour each; white without one.
std::uint32_t AppendRamp(Parameters* in, Names positionNames, Names colorNames, int channels,
                         std::vector<float>* data, double* peak) {
    const std::vector<float> positions = in->Floats(positionNames);
    const std::vector<float> colors = in->Floats(colorNames);
    const std::size_t count = std::min(positions.size(), colors.size() / std::size_t(channels));
    if (count == 0 || !std::is_sorted(positions.begin(), positions.end())) {
        return 0;
    }
    data->insert(data->end(), positions.begin(), positions.begin() + std::ptrdiff_t(count));
    double largest = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            data->push_back(LightFactor(colors[channels == 3 ? 3 * i + c : i]));
            largest = std::max(largest, double(data->back()));
        }
    }
    *peak *= largest;
    return std::uint32_t(count);
}

void ReadRamp(Parameters* in, std::vector<float>* data, shared::HdsLightFilter* out, double* peak) {
    out->type |= HDS_FILTER_RAMP;
    out->mode =
        in->Choice({"rampMode", "rampType"}, {"distanceToLight", "linear", "spherical", "radial"},
                   HDS_FILTER_TO_LIGHT);
    const double begin = in->Number({"falloffRamp:beginDistance", "beginDist"}, 0.0);
    const double end = in->Number({"falloffRamp:endDistance", "endDist"}, 10.0);
    out->begin = float(begin);
    out->perLength = end != begin ? float(1.0 / (end - begin)) : 0.0F;
    out->dataBase = std::uint32_t(data->size());
    out->dataSize[0] = AppendRamp(in, {"colorRamp:spline:positions", "colorRamp_Knots"},
                                  {"colorRamp:spline:values", "colorRamp_Colors"}, 3, data, peak);
    out->dataSize[1] = AppendRamp(in, {"falloffRamp:spline:positions", "ramp_Knots"},
                                  {"falloffRamp:spline:values", "ramp_Floats"}, 1, data, peak);
}

/// False, after a warning of who reads it: there is no image.
bool ReadCookie(Parameters* in, const FilterImage* image, std::vector<float>* data,
                shared::HdsLightFilter* out, double* peak) {
    out->type |= HDS_FILTER_COOKIE;
    out->mode =
        in->Choice({"texture:wrapMode", "tileMode"}, {"off", "repeat", "clamp"}, HDS_FILTER_FILL);
    const std::array<double, 2> sizes{in->Number({"width"}, 1.0), in->Number({"height"}, 1.0)};
    const std::array<double, 2> scales{in->Number({"texture:scaleU", "scaleU"}, 1.0),
                                       in->Number({"texture:scaleV", "scaleV"}, 1.0)};
    const std::array<double, 2> offsets{in->Number({"texture:offsetU", "offsetU"}, 0.0),
                                        in->Number({"texture:offsetV", "offsetV"}, 0.0)};
    const std::array<bool, 2> flips{in->Number({"texture:invertU", "invertU"}, 0.0) != 0.0,
                                    in->Number({"texture:invertV", "invertV"}, 0.0) == 0.0};
    for (int i = 0; i < 2; ++i) { // y of the image points down
        const double sign = flips[i] ? -1.0 : 1.0;
        const double scale = scales[i] * sizes[i];
        out->texture[i] = scale != 0.0 ? float(sign / scale) : 0.0F;
        out->texture[2 + i] =
            float(0.5 - (sizes[i] != 0.0 ? offsets[i] * sizes[i] * out->texture[i] : 0.0));
    }
    Write(in->Color({"color:tint", "tint"}, glm::dvec3(1.0)) * in->Number({"intensity"}, 1.0),
          out->inside);
    Write(in->Color({"texture:fillColor", "fillColor"}, glm::dvec3(0.0)), out->outside);
    in->Find({"texture:map", "map"});
    if (image == nullptr) {
        return false;
    }
    out->dataBase = std::uint32_t(data->size());
    out->dataSize[0] = image->width;
    out->dataSize[1] = image->height;
    std::transform(image->rgb.begin(), image->rgb.end(), std::back_inserter(*data), LightFactor);
    const auto largestOf = [](const float* rgb) { return std::max({rgb[0], rgb[1], rgb[2]}); };
    const double texel = *std::max_element(data->begin() + out->dataBase, data->end());
    *peak = std::max(texel * double(largestOf(out->inside)), double(largestOf(out->outside)));
    return true;
}

struct Multiplier {
    double intensity;
    double exposure;
    double saturation;
};

Multiplier ReadMultiplier(Parameters* in) {
    return {in->Number({"intensity"}, 1.0), in->Number({"exposure"}, 0.0),
            in->Number({"saturation", "colorSaturation"}, 1.0)};
}

/// What filters of all kinds have in common.
void ReadCommon(Parameters* in, const LightFilter& filter, shared::HdsLightFilter* out) {
    out->density = float(glm::clamp(in->Number({"density"}, 1.0), 0.0, 1.0));
    out->inverted = in->Number({"invert"}, 0.0) != 0.0 ? 1.0F : 0.0F;
    const glm::dmat4 filterFromWorld = glm::inverse(filter.worldFromFilter);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
            out->filterFromWorld[4 * row + column] = float(filterFromWorld[column][row]);
        }
    }
    const std::uint32_t way =
        in->Choice({"combineMode"}, {"multiply", "max", "min", "screen"}, HDS_COMBINE_MULTIPLY);
    out->type |= way << HDS_COMBINE_SHIFT;
    in->Number({"diffuse"}, 1.0); // ApplyFilterMultipliers
    in->Number({"specular"}, 1.0);
}

void WarnUnknown(const Parameters& in, const LightFilter& filter, Warnings& warnings) {
    std::string names;
    for (const std::string& name : in.Unknown()) {
        names += (names.empty() ? "" : ", ") + name;
    }
    if (!names.empty()) {
        warnings.Add(filter.node.path, "light filter: not supported and left out: " + names);
    }
}

/// The record of a filter with its data appended; empty: left out, with a warning.
std::optional<shared::HdsLightFilter> ReadFilter(const LightFilter& filter,
                                                 const LoadFilterImage& load, Warnings& warnings,
                                                 std::vector<float>* data, double* peak) {
    const MaterialNode& node = filter.node;
    if (!(std::abs(glm::determinant(filter.worldFromFilter)) > 0.0)) {
        warnings.Add(node.path, "light filter has a singular transform; left out");
        return {};
    }
    Parameters in(node);
    shared::HdsLightFilter out{};
    ReadCommon(&in, filter, &out);
    if (node.identifier == kBarn) {
        ReadBarn(&in, &out);
        *peak = std::max(1.0, double(out.inside[0]));
    } else if (node.identifier == kRod || node.identifier == kBlocker) {
        out.type |= HDS_FILTER_ROD;
        ReadRegion(&in, false, &out);
        Write(glm::dvec3(std::max(in.Number({"intensity"}, 0.0), 0.0)), out.inside);
        Write(glm::dvec3(1.0), out.outside);
        *peak = std::max(1.0, double(out.inside[0]));
    } else if (node.identifier == kRamp) {
        ReadRamp(&in, data, &out, peak);
    } else if (node.identifier == kCookie || node.identifier == kGobo) {
        const AssetReference* file = FilterImageFile(filter);
        const std::shared_ptr<const FilterImage> image =
            file == nullptr || !load ? nullptr : load(*file);
        if (!ReadCookie(&in, image.get(), data, &out, peak)) {
            warnings.Add(node.path, "light filter has no image that can be read; left out");
            return {};
        }
    } else {
        const std::string kind = node.identifier.empty() ? "without a kind" : node.identifier;
        warnings.Add(node.path, "light filter " + kind + " is not supported yet; left out");
        return {};
    }
    WarnUnknown(in, filter, warnings);
    *peak = std::max(*peak, 1.0 - double(out.density));
    *peak = out.inverted != 0.0F ? std::max(*peak, 1.0) : *peak;
    return out;
}

} // namespace

const std::set<std::string>& LightFilterInputs() {
    static const std::set<std::string> names = [] {
        const LightFilter filter;
        std::vector<float> data;
        shared::HdsLightFilter out{};
        double peak = 1.0;
        Parameters in(filter.node);
        ReadCommon(&in, filter, &out);
        ReadMultiplier(&in);
        ReadBarn(&in, &out);
        ReadRegion(&in, false, &out);
        ReadRamp(&in, &data, &out, &peak);
        ReadCookie(&in, nullptr, &data, &out, &peak);
        return in.Asked();
    }();
    return names;
}

const AssetReference* FilterImageFile(const LightFilter& filter) {
    for (const char* name : {"texture:map", "map", "ri:texture:map", "ri:map"}) {
        const auto found = filter.node.parameters.find(name);
        if (found != filter.node.parameters.end()) {
            return std::get_if<AssetReference>(&found->second);
        }
    }
    return nullptr;
}

void ApplyFilterMultipliers(const std::vector<LightFilter>& filters, Warnings& warnings,
                            LightDescription* light) {
    for (const LightFilter& filter : filters) {
        Parameters in(filter.node);
        light->diffuse *= float(in.Number({"diffuse"}, 1.0));
        light->specular *= float(in.Number({"specular"}, 1.0));
        if (filter.node.identifier != kIntMult) {
            continue;
        }
        const Multiplier multiplier = ReadMultiplier(&in);
        light->intensity *= float(multiplier.intensity);
        light->exposure += float(multiplier.exposure);
        const double saturation = multiplier.saturation;
        if (saturation != 1.0 && !light->textureFile.authoredPath.empty()) {
            warnings.Add(filter.node.path,
                         "light filter: the saturation of an image is not changed");
        } else if (saturation != 1.0) {
            auto& rgb = light->color;
            const double luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
            for (float& c : rgb) {
                c = float(std::max(luminance + saturation * (c - luminance), 0.0));
            }
        }
        in.Find({"combineMode"});
        WarnUnknown(in, filter, warnings);
    }
}

std::uint32_t AppendFilters(const std::vector<LightFilter>& filters, const LoadFilterImage& load,
                            Warnings& warnings, std::vector<float>* data, double* peak) {
    std::vector<shared::HdsLightFilter> records;
    *peak = 1.0;
    std::optional<double> most;
    std::optional<double> least;
    for (const LightFilter& filter : filters) {
        double own = 1.0;
        const auto record = filter.node.identifier == kIntMult
                                ? std::nullopt
                                : ReadFilter(filter, load, warnings, data, &own);
        if (!record) {
            continue;
        }
        records.push_back(*record);
        switch (record->type >> HDS_COMBINE_SHIFT) {
        case HDS_COMBINE_MULTIPLY:
            *peak *= own;
            break;
        case HDS_COMBINE_MAX:
            most = std::max(most.value_or(own), own);
            break;
        case HDS_COMBINE_MIN:
            least = std::min(least.value_or(own), own);
            break;
        default:
            break; // screens leave at most all
        }
    }
    *peak *= most.value_or(1.0) * least.value_or(1.0);
    const std::size_t at = data->size();
    const std::size_t bytes = records.size() * sizeof(shared::HdsLightFilter);
    data->resize(at + bytes / sizeof(float));
    if (bytes > 0) {
        std::memcpy(data->data() + at, records.data(), bytes);
    }
    return std::uint32_t(records.size());
}

} // namespace hds
