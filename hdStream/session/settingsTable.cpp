// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/settingsTable.h"

#include "hdStream/base/error.h"
#include "hdStream/session/settingsCheck.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <type_traits>
#include <utility>

namespace hds {

namespace {

struct Row {
    SettingInfo info;
    std::function<SettingValue(const Settings&)> get;
    std::function<void(Settings*, const SettingValue&)> set; ///< the value is checked
};

template <typename T>
Row MakeRow(T Settings::*member, SettingInfo info) {
    // What a member of this type is in a SettingValue.
    using Held = std::conditional_t<
        std::is_same_v<T, bool>, bool,
        std::conditional_t<std::is_integral_v<T>, std::int64_t,
                           std::conditional_t<std::is_floating_point_v<T>, double, T>>>;
    return {std::move(info),
            [member](const Settings& settings) {
                return SettingValue(static_cast<Held>(settings.*member));
            },
            [member](Settings* settings, const SettingValue& value) {
                settings->*member = static_cast<T>(std::get<Held>(value));
            }};
}

SettingInfo Info(SettingKind kind, const char* name, const char* option, const char* label,
                 const char* description) {
    SettingInfo info;
    info.kind = kind;
    info.name = name;
    info.option = option;
    info.label = label;
    info.description = description;
    return info;
}

SettingInfo Ranged(SettingKind kind, const char* name, const char* option, const char* label,
                   const char* description, double minimum, double maximum) {
    SettingInfo info = Info(kind, name, option, label, description);
    info.minimum = minimum;
    info.maximum = maximum;
    return info;
}

SettingInfo OneOf(const char* name, const char* option, const char* label, const char* description,
                  std::vector<std::string> choices) {
    SettingInfo info = Info(SettingKind::Choice, name, option, label, description);
    info.choices = std::move(choices);
    return info;
}

SettingInfo OfHost(SettingInfo info) {
    info.isUserSetting = false;
    return info;
}

constexpr double kMaxSeconds = 1e9;
constexpr double kMaxError = 1e6;
constexpr double kMaxFilterWidth = 64.0;
constexpr double kMaxMipBias = 16.0;
constexpr double kMaxShadeIterations = 64.0;
constexpr double kMaxPixelAspect = 1000.0;
/// Path depths are kept in 16 bits together with their sampling dimensions.
constexpr double kMaxDepth = 4096;
constexpr double kMaxCount = 1U << 24U;
constexpr double kMaxSeed = std::numeric_limits<std::uint32_t>::max();
constexpr double kMaxRefineLevel = 8;
constexpr double kMinChunkBytes = 4U << 10U;
constexpr double kMaxChunkBytes = 256U << 20U;
constexpr double kMaxHostBytes = 1ULL << 50U;

/// What to render: the hosts of the plug-in decide these.
std::vector<Row> HostRows() {
    using S = Settings;
    using K = SettingKind;
    return {
        MakeRow(&S::camera, OfHost(Info(K::Text, "camera", "--camera", "Camera",
                                        "prim path of the camera to render"))),
        MakeRow(&S::imageWidth,
                OfHost(Ranged(K::Integer, "imageWidth", "--imageWidth", "Image width",
                              "pixels of the image", 1, kMaxImageSize))),
        MakeRow(&S::imageHeight,
                OfHost(Ranged(K::Integer, "imageHeight", "--imageHeight", "Image height",
                              "pixels of the image", 1, kMaxImageSize))),
        MakeRow(
            &S::pixelAspectRatio,
            OfHost(Ranged(K::Number, "pixelAspectRatio", "", "Pixel aspect ratio",
                          "width over height of a pixel", 1.0 / kMaxPixelAspect, kMaxPixelAspect))),
        MakeRow(&S::conformPolicy,
                OfHost(OneOf("conformPolicy", "", "Conform policy",
                             "how an aperture of another aspect ratio is fitted to the image",
                             {"expandAperture", "cropAperture", "adjustApertureWidth",
                              "adjustApertureHeight", "adjustPixelAspectRatio"}))),
        MakeRow(&S::aovs, OfHost(Info(K::Names, "aovs", "--aovs", "AOVs", "layers of the image"))),
        MakeRow(&S::purposes, OfHost(Info(K::Names, "purposes", "--purposes", "Purposes",
                                          "purposes of the prims that are drawn"))),
        MakeRow(&S::cullStyle,
                OfHost(OneOf("cullStyle", "", "Cull style",
                             "faces that camera rays do not see, of meshes that do not say",
                             {"nothing", "back", "front", "backUnlessDoubleSided",
                              "frontUnlessDoubleSided"}))),
        MakeRow(&S::cameraMoves,
                OfHost(Info(K::Bool, "cameraMoves", "", "Camera moves",
                            "what the first camera does not see is diced finely too"))),
    };
}

std::vector<Row> UserRows() {
    using S = Settings;
    using K = SettingKind;
    return {
        MakeRow(&S::samples, Ranged(K::Integer, "samples", "--samples", "Samples",
                                    "samples per pixel", 1, kMaxCount)),
        MakeRow(&S::maxDepth, Ranged(K::Integer, "maxDepth", "--maxDepth", "Bounces",
                                     "bounces after the first hit", 0, kMaxDepth)),
        MakeRow(&S::seed,
                Ranged(K::Integer, "seed", "--seed", "Seed", "of the random numbers", 0, kMaxSeed)),
        MakeRow(&S::timeLimit,
                Ranged(K::Number, "timeLimit", "--time", "Time limit",
                       "seconds after which rendering ends; 0: no limit", 0.0, kMaxSeconds)),
        MakeRow(&S::noise,
                Ranged(K::Number, "noise", "--noise", "Noise",
                       "relative error at which a pixel is done; 0: never", 0.0, kMaxError)),
        MakeRow(&S::pixelFilter,
                OneOf("pixelFilter", "", "Pixel filter", "weights of the samples of a pixel",
                      {"blackmanHarris", "box"})),
        MakeRow(&S::pixelFilterWidth,
                Ranged(K::Number, "pixelFilterWidth", "", "Pixel filter width",
                       "full width of the filter in pixels", 1.0 / kMaxFilterWidth,
                       kMaxFilterWidth)),
        MakeRow(&S::domeVisible, Info(K::Bool, "domeVisible", "", "Dome visible",
                                      "dome lights are seen by the camera")),
        MakeRow(&S::russianRoulette,
                Info(K::Bool, "russianRoulette", "", "Russian roulette",
                     "dim paths end by chance; switching it off changes the noise only")),
        MakeRow(&S::motionBlur,
                OneOf("motionBlur", "--motionBlur", "Motion blur",
                      "of what moves while the camera's shutter is open", {"on", "off"})),
        MakeRow(&S::denoise, Info(K::Bool, "denoise", "--denoise", "Denoise",
                                  "the picture, by Open Image Denoise where it is installed")),
        MakeRow(&S::mipBias, Ranged(K::Number, "mipBias", "", "Mip bias",
                                    "mips that texture look-ups are moved by; positive: coarser",
                                    -kMaxMipBias, kMaxMipBias)),
        MakeRow(&S::subdivision, OneOf("subdivision", "--subdivision", "Subdivision",
                                       "limit surface, uniform level, or cage as it is",
                                       {"adaptive", "complexity", "cage"})),
        MakeRow(&S::refineLevel,
                OfHost(Ranged(K::Integer, "refineLevel", "--complexity", "Refine level",
                              "subdivision level of all meshes with subdivision complexity", 0,
                              kMaxRefineLevel))),
        MakeRow(&S::waveSize, Ranged(K::Integer, "waveSize", "--waveSize", "Wave size",
                                     "paths in flight; 0: measured for the device", 0, kMaxCount)),
        MakeRow(&S::device, Info(K::Text, "device", "--device", "Device",
                                 "OpenCL device by part of its name; empty: the first GPU, else "
                                 "the first CPU")),
        MakeRow(&S::cacheDirectory,
                Info(K::Text, "cacheDirectory", "--cacheDir", "Cache folder",
                     "persistent cache; empty: $HDSTREAM_CACHE_DIR, else the platform's")),
        MakeRow(&S::noCache,
                Info(K::Bool, "noCache", "--noCache", "No cache", "use no persistent cache")),
        MakeRow(&S::traversal,
                OneOf("traversal", "", "Traversal", "form of the traversal kernel; equal bits",
                      {"auto", "wide", "lane"})),
        MakeRow(&S::chunkBytes,
                Ranged(K::Bytes, "chunkBytes", "--chunkSize", "Chunk size",
                       "upper bound of a unit of geometry", kMinChunkBytes, kMaxChunkBytes)),
        MakeRow(&S::residency, OneOf("residency", "--residency", "Residency",
                                     "geometry and textures in device memory: all, what rays ask "
                                     "for, whichever fits, or "
                                     "none (mapped: CPU devices read the cache's files in place)",
                                     {"auto", "resident", "stream", "mapped"})),
        MakeRow(&S::geometryMemory,
                Info(K::Text, "geometryMemory", "--geometryMemory", "Geometry memory",
                     "pool for geometry that streams: bytes (K, M, G) or a percentage of all of "
                     "it; empty: a quarter of the device's memory")),
        MakeRow(&S::textureMemory,
                Info(K::Text, "textureMemory", "--textureMemory", "Texture memory",
                     "pool for textures that stream: bytes (K, M, G) or a percentage of all of "
                     "them; empty: a quarter of the device's memory")),
        MakeRow(&S::geometryEviction,
                OneOf("geometryEviction", "--geometryEviction", "Geometry eviction",
                      "what leaves a full pool: what was used least recently, or everything",
                      {"clock", "flush"})),
        MakeRow(&S::request,
                OneOf("request", "--request", "Request",
                      "the missing chunks a ray asks for: the nearest in its way after its walk, "
                      "or the first it meets",
                      {"last", "first"})),
        MakeRow(&S::shadeIterations,
                Ranged(K::Integer, "shadeIterations", "--shadeIterations", "Shade iterations",
                       "times that a point is shaded before coarser mips are taken for texels "
                       "that are not there yet; 0: until all are",
                       0, kMaxShadeIterations)),
        MakeRow(&S::plainTextures,
                Info(K::Bool, "plainTextures", "", "Plain textures",
                     "textures whole and uncompressed in device memory, to compare with")),
        MakeRow(&S::hostMemory,
                Ranged(K::Bytes, "hostMemory", "--hostMemory", "Host memory",
                       "bound on prepared geometry kept in host memory; 0: a quarter of it", 0,
                       kMaxHostBytes)),
        MakeRow(&S::prepare, OneOf("prepare", "--prepare", "Prepare",
                                   "geometry that streams is prepared when rays ask for it, or all "
                                   "of it before the first one",
                                   {"lazy", "eager"})),
    };
}

const std::vector<Row>& Rows() {
    static const std::vector<Row> rows = [] {
        std::vector<Row> all = HostRows();
        for (Row& row : UserRows()) {
            all.push_back(std::move(row));
        }
        return all;
    }();
    return rows;
}

const Row* FindRow(const std::string& name) {
    const auto found = std::find_if(Rows().begin(), Rows().end(),
                                    [&](const Row& row) { return row.info.name == name; });
    return found == Rows().end() ? nullptr : &*found;
}

std::string Text(double number) {
    char text[40];
    std::snprintf(text, sizeof(text), "%.12g", number);
    return text;
}

[[noreturn]] void Fail(const SettingInfo& info, const std::string& text) {
    throw Error((info.option.empty() ? info.name : info.option) + ": " + text, ErrorKind::Usage);
}

void CheckInRange(const SettingInfo& info, double number) {
    if (!(number >= info.minimum && number <= info.maximum)) {
        Fail(info, Text(number) + " is not in " + Text(info.minimum) + ".." + Text(info.maximum));
    }
}

/// A number that is whole, if it is.
const std::int64_t* WholeNumber(const SettingValue& value, std::int64_t* storage) {
    if (const auto* integer = std::get_if<std::int64_t>(&value)) {
        return integer;
    }
    const auto* number = std::get_if<double>(&value);
    if (number == nullptr || std::abs(*number) > 9e15 || std::floor(*number) != *number) {
        return nullptr;
    }
    *storage = static_cast<std::int64_t>(*number);
    return storage;
}

/// The value in the type of the row's kind.
SettingValue Converted(const SettingInfo& info, const SettingValue& value) {
    std::int64_t storage = 0;
    switch (info.kind) {
    case SettingKind::Bool:
        if (std::holds_alternative<bool>(value)) {
            return value;
        }
        Fail(info, "is either true or false");
    case SettingKind::Integer:
    case SettingKind::Bytes:
        if (const std::int64_t* number = WholeNumber(value, &storage)) {
            return *number;
        }
        Fail(info, "must be a whole number");
    case SettingKind::Number:
        if (const auto* integer = std::get_if<std::int64_t>(&value)) {
            return static_cast<double>(*integer);
        }
        if (std::holds_alternative<double>(value)) {
            return value;
        }
        Fail(info, "must be a number");
    case SettingKind::Text:
    case SettingKind::Choice:
        if (std::holds_alternative<std::string>(value)) {
            return value;
        }
        Fail(info, "must be a text");
    case SettingKind::Names:
        if (std::holds_alternative<std::vector<std::string>>(value)) {
            return value;
        }
        Fail(info, "must be a list of names");
    }
    Fail(info, "has no kind");
}

} // namespace

const std::vector<SettingInfo>& SettingTable() {
    static const std::vector<SettingInfo> table = [] {
        std::vector<SettingInfo> infos;
        for (const Row& row : Rows()) {
            infos.push_back(row.info);
        }
        return infos;
    }();
    return table;
}

const SettingInfo* FindSetting(const std::string& name) {
    const Row* row = FindRow(name);
    return row != nullptr ? &row->info : nullptr;
}

SettingValue GetSetting(const Settings& settings, const std::string& name) {
    const Row* row = FindRow(name);
    HDS_VERIFY(row != nullptr, name);
    return row->get(settings);
}

void CheckSettingValue(const SettingInfo& info, const SettingValue& value) {
    if (const auto* integer = std::get_if<std::int64_t>(&value)) {
        CheckInRange(info, static_cast<double>(*integer));
    } else if (const auto* number = std::get_if<double>(&value)) {
        if (!std::isfinite(*number)) {
            Fail(info, "must be a finite number");
        }
        CheckInRange(info, *number);
    } else if (info.kind == SettingKind::Choice) {
        const auto& text = std::get<std::string>(value);
        if (std::find(info.choices.begin(), info.choices.end(), text) == info.choices.end()) {
            std::string message = text + " is none of ";
            for (std::size_t i = 0; i < info.choices.size(); ++i) {
                message += (i > 0 ? ", " : "") + info.choices[i];
            }
            Fail(info, message);
        }
    }
}

void SetSetting(Settings* settings, const std::string& name, const SettingValue& value) {
    const Row* row = FindRow(name);
    if (row == nullptr) {
        throw Error(name + ": there is no such setting", ErrorKind::Usage);
    }
    const SettingValue converted = Converted(row->info, value);
    CheckSettingValue(row->info, converted);
    row->set(settings, converted);
}

} // namespace hds
