// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/aov.h"

#include "hdStream/base/error.h"

#include <limits>

namespace hds {

namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

std::vector<AovInfo> MakeTable() {
    const std::vector<std::string> rgb{"R", "G", "B"};
    const std::vector<std::string> xyz{"X", "Y", "Z"};
    return {
        {"color",
         {"R", "G", "B", "A"},
         false,
         true,
         AovFilter::Weighted,
         0.0f,
         0,
         "radiance in the working space, premultiplied by alpha"},
        {"alpha",
         {"A"},
         false,
         false,
         AovFilter::Weighted,
         0.0f,
         0,
         "coverage of the pixel by geometry, 0 to 1"},
        {"depth",
         {"Z"},
         false,
         false,
         AovFilter::First,
         1.0f,
         0,
         "depth after projection, 0 at the near and 1 at the far clipping plane"},
        {"cameraDepth",
         {"Z"},
         false,
         false,
         AovFilter::First,
         kFar,
         0,
         "distance along the camera's -Z axis in scene units; infinite where nothing is hit"},
        {"normal", xyz, false, false, AovFilter::First, 0.0f, 0,
         "shading normal in world space, unit length"},
        {"Neye", xyz, false, false, AovFilter::First, 0.0f, 0,
         "shading normal in camera space, unit length"},
        {"position", xyz, false, false, AovFilter::First, 0.0f, 0,
         "position of the hit in world space, scene units"},
        {"albedo", rgb, false, true, AovFilter::Weighted, 0.0f, 0,
         "directional albedo of the first hit's material"},
        {"primId",
         {"id"},
         true,
         false,
         AovFilter::First,
         0.0f,
         -1,
         "prim, -1 where nothing is hit"},
        {"instanceId",
         {"id"},
         true,
         false,
         AovFilter::First,
         0.0f,
         -1,
         "instance inside its instancer, -1 where nothing is hit or not instanced"},
        {"elementId",
         {"id"},
         true,
         false,
         AovFilter::First,
         0.0f,
         -1,
         "authored face, -1 where nothing is hit"},
        {"variance", rgb, false, false, AovFilter::Counter, 0.0f, 0,
         "estimated variance of the pixel's color (of the mean, not of one sample)"},
        {"sampleCount",
         {"count"},
         true,
         false,
         AovFilter::Counter,
         0.0f,
         0,
         "samples taken in the pixel"},
    };
}

} // namespace

const std::vector<AovInfo>& AovTable() {
    static const std::vector<AovInfo> table = MakeTable();
    return table;
}

const AovInfo* FindAov(const std::string& name) {
    for (const AovInfo& info : AovTable()) {
        if (info.name == name) {
            return &info;
        }
    }
    return nullptr;
}

const AovSlot* AovLayout::Find(const std::string& name) const {
    for (const AovSlot& slot : slots) {
        if (slot.info->name == name) {
            return &slot;
        }
    }
    return nullptr;
}

AovLayout MakeAovLayout(const std::vector<std::string>& names) {
    if (names.empty()) {
        throw Error("--aovs: no AOV is named", ErrorKind::Usage);
    }
    AovLayout layout;
    for (const std::string& name : names) {
        const AovInfo* info = FindAov(name);
        if (!info) {
            std::string known;
            for (const AovInfo& row : AovTable()) {
                known += (known.empty() ? "" : ", ") + row.name;
            }
            throw Error("--aovs: there is no AOV '" + name + "' (there are " + known + ")",
                        ErrorKind::Usage);
        }
        if (layout.Find(name)) {
            throw Error("--aovs: '" + name + "' is named twice", ErrorKind::Usage);
        }
        std::uint32_t& used = info->isInteger ? layout.intsPerPixel : layout.floatsPerPixel;
        layout.slots.push_back({info, used});
        used += info->NumChannels();
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

std::vector<ImageLayer> MakeLayers(const AovLayout& layout, std::uint32_t width,
                                   std::uint32_t height, const float* floats,
                                   const std::int32_t* ints) {
    HDS_VERIFY(floats || layout.floatsPerPixel == 0, "no float buffer for the float AOVs");
    HDS_VERIFY(ints || layout.intsPerPixel == 0, "no int buffer for the integer AOVs");
    const std::size_t numPixels = std::size_t{width} * height;
    std::vector<ImageLayer> layers;
    for (const AovSlot& slot : layout.slots) {
        ImageLayer layer = MakeClearLayer(*slot.info, width, height);
        const std::uint32_t numChannels = slot.info->NumChannels();
        for (std::size_t pixel = 0; pixel < numPixels; ++pixel) {
            for (std::uint32_t c = 0; c < numChannels; ++c) {
                if (slot.info->isInteger) {
                    layer.ids[pixel * numChannels + c] =
                        ints[pixel * layout.intsPerPixel + slot.offset + c];
                } else {
                    layer.values[pixel * numChannels + c] =
                        floats[pixel * layout.floatsPerPixel + slot.offset + c];
                }
            }
        }
        layers.push_back(std::move(layer));
    }
    return layers;
}

} // namespace hds
