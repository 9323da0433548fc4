// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/aov.h"

#include "hdStream/base/error.h"
#include "hdStream/film/cryptomatte.h"
#include "hdStream/film/lightPaths.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

namespace hds {

namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

using Channels = std::vector<std::string>;

AovInfo Color(const char* name, const Channels& channels, AovFilter filter,
              const char* description) {
    return {name, channels, false, true, filter, 0.0f, 0, description, ""};
}

AovInfo Data(const char* name, const Channels& channels, AovFilter filter, float clearValue,
             const char* description) {
    return {name, channels, false, false, filter, clearValue, 0, description, ""};
}

/// A Cryptomatte, or a layer of it.
AovInfo Matte(const std::string& name, const char* description) {
    return {name, {"R", "G", "B", "A"}, false, false, AovFilter::Matte, 0.0f, 0, description, ""};
}

/// The light of a light path expression.
AovInfo Light(const std::string& name, const std::string& expression,
              const std::string& description) {
    return {name, {"R", "G", "B"}, false,     true, AovFilter::Weighted, 0.0f,
            0,    description,     expression};
}

AovInfo Integer(const char* name, const char* channel, AovFilter filter, std::int32_t clearId,
                const char* description) {
    return {name, {channel}, true, false, filter, 0.0f, clearId, description, ""};
}

std::vector<AovInfo> MakeTable() {
    const Channels xyz{"X", "Y", "Z"};
    const AovFilter first = AovFilter::First;
    return {
        Color("color", {"R", "G", "B", "A"}, AovFilter::Weighted,
              "radiance in the working space, premultiplied by alpha"),
        Data("alpha", {"A"}, AovFilter::Weighted, 0.0f,
             "coverage of the pixel by geometry, 0 to 1"),
        Data("depth", {"Z"}, first, 1.0f,
             "depth after projection, 0 at the near and 1 at the far clipping plane"),
        Data("cameraDepth", {"Z"}, first, kFar,
             "distance along the camera's -Z axis in scene units; infinite where nothing is hit"),
        Data("normal", xyz, first, 0.0f, "shading normal in world space, unit length"),
        Data("Neye", xyz, first, 0.0f, "shading normal in camera space, unit length"),
        Data("position", xyz, first, 0.0f, "position of the hit in world space, scene units"),
        Data("Peye", xyz, first, 0.0f, "position of the hit in camera space, scene units"),
        Data("facingRatio", {"Y"}, first, 0.0f,
             "cosine between the shading normal and the direction to the camera, 0 to 1"),
        Data("motionForward", {"X", "Y"}, first, 0.0f,
             "pixels by which the hit moves on the picture to the next frame, y down"),
        Data("motionBackward", {"X", "Y"}, first, 0.0f,
             "pixels by which the hit lies elsewhere on the picture of the frame before, y down"),
        Data(kOcclusionAov, {"Y"}, AovFilter::Weighted, 0.0f,
             "share of the hemisphere, by cosine, in which nothing is nearer than "
             "occlusionDistance; 0 where nothing is hit"),
        Color("albedo", {"R", "G", "B"}, first,
              "directional albedo of the first hit, with that of the volumes and media before it"),
        Data("volumeDepth", {"Z"}, first, kFar,
             "distance along the camera's -Z axis in scene units at which volumes or media of "
             "meshes have taken half of the light; infinite where none do"),
        Integer("primId", "id", first, -1, "prim, -1 where nothing is hit"),
        Integer("instanceId", "id", first, -1,
                "instance inside its instancer, -1 where nothing is hit or not instanced"),
        Integer("elementId", "id", first, -1, "authored face, -1 where nothing is hit"),
        Data("variance", {"Y"}, AovFilter::Counter, 0.0f,
             "estimated variance of the pixel's luminance (of the mean, not of one sample)"),
        Color("noisy", {"R", "G", "B", "A"}, AovFilter::Weighted, "color before it is denoised"),
        Integer("sampleCount", "count", AovFilter::Counter, 0, "samples taken in the pixel"),
        Matte("crypto_object", "Cryptomatte of prims: three layers of two ids with coverages each"),
        Matte("crypto_material", "Cryptomatte of materials"),
        Matte("crypto_instance", "Cryptomatte of instances"),
        Light("emission", "C[LO]", "light of what is seen directly"),
        Light("diffuse", "C<RD>.*[LO]", "light that the surface seen reflects diffusely"),
        Light("specular", "C<R[GS]>.*[LO]", "light that the surface seen reflects otherwise"),
        Light("transmission", "CT.*[LO]", "light that the surface seen transmits"),
        Light("volume", "CV.*[LO]", "light that the volume seen scatters"),
        Light("direct", "C.[LO]", "light after one scattering"),
        Light("indirect", "C..+[LO]", "light after more than one scattering"),
        Light("directDiffuse", "C<RD>[LO]", "what diffuse has after one scattering"),
        Light("indirectDiffuse", "C<RD>.+[LO]", "what diffuse has after more than one"),
        Light("directSpecular", "C<R[GS]>[LO]", "what specular has after one scattering"),
        Light("indirectSpecular", "C<R[GS]>.+[LO]", "what specular has after more than one"),
        Light("directTransmission", "CT[LO]", "what transmission has after one scattering"),
        Light("indirectTransmission", "CT.+[LO]", "what transmission has after more than one"),
    };
}

/// All layers of all Cryptomattes.
std::vector<AovInfo> MakeMatteLayerTable() {
    std::vector<AovInfo> rows;
    for (const AovInfo& row : AovTable()) {
        for (std::uint32_t layer = 0; layer < kMaxMatteLayers && row.filter == AovFilter::Matte;
             ++layer) {
            rows.push_back(Matte(MatteLayerName(row.name, layer), "a layer of a Cryptomatte"));
        }
    }
    return rows;
}

bool HasPrefix(const std::string& name, const char* prefix) {
    const std::size_t length = std::strlen(prefix);
    return name.size() > length && name.compare(0, length, prefix) == 0;
}

bool IsPrimvarAov(const std::string& name) {
    return HasPrefix(name, kPrimvarAovPrefix);
}

bool IsLightPathAov(const std::string& name) {
    return HasPrefix(name, kLightPathPrefix) || HasPrefix(name, kLightGroupPrefix);
}

std::shared_ptr<const AovInfo> MakeLightPathAov(const std::string& name) {
    if (HasPrefix(name, kLightPathPrefix)) {
        return std::make_shared<const AovInfo>(
            Light(name, name.substr(std::strlen(kLightPathPrefix)), "the light of an expression"));
    }
    const std::string group = name.substr(std::strlen(kLightGroupPrefix));
    return std::make_shared<const AovInfo>(
        Light(name, "C.*<L.'" + group + "'>", "the light of a group of lights"));
}

/// The AOV whose variance that one is; null: it is no variance.
std::shared_ptr<const AovInfo> FindVaryingAov(const std::string& name) {
    if (!HasPrefix(name, kVariancePrefix)) {
        return nullptr;
    }
    const std::string of = name.substr(std::strlen(kVariancePrefix));
    if (IsLightPathAov(of)) {
        return MakeLightPathAov(of);
    }
    const AovInfo* info = FindAov(of);
    return info != nullptr && !info->lightPaths.empty() ? std::make_shared<const AovInfo>(*info)
                                                        : nullptr;
}

std::shared_ptr<const AovInfo> MakeVarianceAov(const std::string& name, const AovInfo& of) {
    AovInfo info = Data(name.c_str(), {"Y"}, AovFilter::Counter, 0.0F,
                        "estimated variance of the luminance of an AOV");
    info.lightPaths = of.lightPaths;
    return std::make_shared<const AovInfo>(info);
}

std::shared_ptr<const AovInfo> MakePrimvarAov(const std::string& name) {
    return std::make_shared<const AovInfo>(
        Data(name.c_str(), {"X", "Y", "Z"}, AovFilter::First, 0.0F, "a primvar of the first hit"));
}

[[noreturn]] void FailUnknown(const std::string& name) {
    std::string message = "--aovs: there is no AOV '" + name + "' (there are";
    for (const AovInfo& row : AovTable()) {
        message.append(" ").append(row.name);
    }
    throw Error(message + " " + kPrimvarAovPrefix + "NAME " + kLightPathPrefix + "EXPRESSION " +
                    kLightGroupPrefix + "NAME " + kVariancePrefix + "NAME of light)",
                ErrorKind::Usage);
}

/// Appends an AOV with the place that it has among the floats or ids of a pixel.
void PlaceSlot(const std::shared_ptr<const AovInfo>& info, AovLayout* layout) {
    std::uint32_t lightPath = 0;
    if (!info->lightPaths.empty()) {
        std::vector<std::string>& all = layout->lightPaths;
        lightPath = static_cast<std::uint32_t>(std::find(all.begin(), all.end(), info->lightPaths) -
                                               all.begin());
        if (lightPath == all.size()) {
            all.push_back(info->lightPaths);
        }
    }
    std::uint32_t& used = info->isInteger ? layout->intsPerPixel : layout->floatsPerPixel;
    layout->slots.push_back({info, used, lightPath});
    used += info->NumChannels();
}

/// Appends an AOV; primvars have no place yet.
void AddSlot(const std::string& name, AovLayout* layout) {
    if (layout->Find(name)) {
        throw Error("--aovs: '" + name + "' is named twice", ErrorKind::Usage);
    }
    if (IsPrimvarAov(name)) {
        layout->primvars.push_back(name.substr(std::strlen(kPrimvarAovPrefix)));
        layout->slots.push_back({MakePrimvarAov(name), 0, 0});
        return;
    }
    if (IsLightPathAov(name)) {
        PlaceSlot(MakeLightPathAov(name), layout);
        return;
    }
    if (const std::shared_ptr<const AovInfo> of = FindVaryingAov(name)) {
        PlaceSlot(MakeVarianceAov(name, *of), layout);
        return;
    }
    const AovInfo* info = FindAov(name);
    if (!info) {
        FailUnknown(name);
    }
    // The table lives as long as the process: nothing is owned.
    const std::shared_ptr<const AovInfo> shared(std::shared_ptr<void>(), info);
    if (info->filter == AovFilter::Matte) {
        layout->hasMattes = true;
        layout->slots.push_back({shared, 0, 0});
        return;
    }
    layout->hasOcclusion = layout->hasOcclusion || name == kOcclusionAov;
    PlaceSlot(shared, layout);
}

} // namespace

const std::vector<AovInfo>& AovTable() {
    static const std::vector<AovInfo> table = MakeTable();
    return table;
}

const AovInfo* FindAov(const std::string& name) {
    static const std::vector<AovInfo> matteLayers = MakeMatteLayerTable();
    for (const std::vector<AovInfo>* table : {&AovTable(), &matteLayers}) {
        for (const AovInfo& info : *table) {
            if (info.name == name) {
                return &info;
            }
        }
    }
    return nullptr;
}

std::vector<std::string> LayersOf(const std::string& name) {
    const std::optional<MatteAov> matte = ParseMatteAov(name);
    if (!matte || matte->layer) {
        return {name};
    }
    std::vector<std::string> layers;
    for (std::uint32_t layer = 0; layer < kMatteLayers; ++layer) {
        layers.push_back(MatteLayerName(name, layer));
    }
    return layers;
}

bool HasAov(const std::string& name) {
    return FindAov(name) != nullptr || IsPrimvarAov(name) || IsLightPathAov(name) ||
           FindVaryingAov(name) != nullptr;
}

bool IsSummed(const std::string& name) {
    const AovInfo* info = FindAov(name);
    return IsLightPathAov(name) || FindVaryingAov(name) != nullptr ||
           (info && (info->filter == AovFilter::Matte || !info->lightPaths.empty() ||
                     name == kOcclusionAov));
}

void CheckAovs(const std::vector<std::string>& names) {
    const AovLayout layout = MakeAovLayout(names);
    if (!layout.lightPaths.empty()) {
        CompileLightPaths(layout.lightPaths);
    }
}

const AovSlot* AovLayout::Find(const std::string& name) const {
    for (const AovSlot& slot : slots) {
        if (slot.info->name == name) {
            return &slot;
        }
    }
    return nullptr;
}

std::vector<std::string> AovLayout::SumNames() const {
    std::vector<std::string> names = lightPaths;
    if (hasCatchers) {
        names.insert(names.end(), {"catchers", "catchersAlone"});
    }
    if (hasOcclusion) {
        names.emplace_back(kOcclusionAov);
    }
    return names;
}

AovLayout MakeAovLayout(const std::vector<std::string>& names) {
    if (names.empty()) {
        throw Error("--aovs: no AOV is named", ErrorKind::Usage);
    }
    AovLayout layout;
    for (const std::string& name : names) {
        for (const std::string& layer : LayersOf(name)) {
            AddSlot(layer, &layout);
        }
    }
    layout.primvarOffset = layout.floatsPerPixel;
    for (AovSlot& slot : layout.slots) {
        if (IsPrimvarAov(slot.info->name)) {
            slot.offset = layout.floatsPerPixel;
            layout.floatsPerPixel += slot.info->NumChannels();
        }
    }
    return layout;
}

ImageLayer MakeClearLayer(const AovInfo& info, std::uint32_t width, std::uint32_t height) {
    ImageLayer layer;
    layer.name = info.name;
    layer.channels = info.channels;
    layer.isInteger = info.isInteger;
    layer.width = width;
    layer.height = height;
    const std::size_t numValues = std::size_t{width} * height * info.NumChannels();
    if (info.isInteger) {
        layer.ids.assign(numValues, info.clearId);
    } else {
        layer.values.assign(numValues, info.clearValue);
    }
    return layer;
}

ImageLayer EnlargePreview(const AovInfo& info, const ImageLayer& known, std::uint32_t width,
                          std::uint32_t height, std::uint32_t stride, PreviewFill fill) {
    // Each row is made once and written once: who edits waits for the first pictures.
    ImageLayer layer = MakeClearLayer(info, fill == PreviewFill::Squares ? 0 : width, 1);
    const std::size_t channels = info.NumChannels();
    const auto enlarge = [&](const auto& from, auto* to) {
        const auto clear = std::exchange(*to, {});
        auto row = clear;
        row.resize(width * channels);
        to->reserve(row.size() * height);
        for (std::uint32_t y = 0; y < height; ++y) {
            const bool isKnown = y % stride == 0;
            for (std::uint32_t x = 0; isKnown && x < width; ++x) {
                const std::size_t at = std::size_t{y / stride} * known.width + x / stride;
                if (fill == PreviewFill::Squares || x % stride == 0) {
                    std::copy_n(from.data() + at * channels, channels, row.data() + x * channels);
                }
            }
            const auto& source = isKnown || fill == PreviewFill::Squares ? row : clear;
            to->insert(to->end(), source.begin(), source.end());
        }
    };
    if (info.isInteger) {
        enlarge(known.ids, &layer.ids);
    } else {
        enlarge(known.values, &layer.values);
    }
    layer.width = width;
    layer.height = height;
    return layer;
}

std::vector<ImageLayer> MakeLayers(const AovLayout& layout, std::uint32_t width,
                                   std::uint32_t height, const float* floats,
                                   const std::int32_t* ints) {
    HDS_VERIFY(floats || layout.floatsPerPixel == 0, "no float buffer for the float AOVs");
    HDS_VERIFY(ints || layout.intsPerPixel == 0, "no int buffer for the integer AOVs");
    const std::size_t numPixels = std::size_t{width} * height;
    std::vector<ImageLayer> layers;
    for (const AovSlot& slot : layout.slots) {
        const AovInfo& info = *slot.info;
        ImageLayer layer = MakeClearLayer(info, width, height);
        const std::size_t channels = info.NumChannels();
        const auto copy = [&](const auto* from, std::size_t stride, auto* to) {
            for (std::size_t pixel = 0; pixel < numPixels; ++pixel) {
                std::copy_n(from + pixel * stride + slot.offset, channels, to + pixel * channels);
            }
        };
        if (info.filter == AovFilter::Matte) {
            // lies in neither buffer
        } else if (info.isInteger) {
            copy(ints, layout.intsPerPixel, layer.ids.data());
        } else {
            copy(floats, layout.floatsPerPixel, layer.values.data());
        }
        layers.push_back(std::move(layer));
    }
    return layers;
}

} // namespace hds
