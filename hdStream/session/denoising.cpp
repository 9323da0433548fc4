// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/denoising.h"

#include <algorithm>

namespace hds {

namespace {

constexpr const char* kGuides[] = {"albedo", "normal"};

ImageLayer* FindLayer(std::vector<ImageLayer>* layers, const std::string& name) {
    const auto found = std::find_if(layers->begin(), layers->end(),
                                    [&](const ImageLayer& layer) { return layer.name == name; });
    return found != layers->end() ? &*found : nullptr;
}

} // namespace

std::vector<std::string> WithDenoiserGuides(std::vector<std::string> aovs) {
    const auto has = [&](const std::string& name) {
        return std::find(aovs.begin(), aovs.end(), name) != aovs.end();
    };
    for (const char* guide : kGuides) {
        if (has("color") && !has(guide)) {
            aovs.emplace_back(guide);
        }
    }
    return aovs;
}

void DenoiseColor(const Denoiser& denoiser, std::vector<ImageLayer>* layers) {
    if (ImageLayer* const color = FindLayer(layers, "color")) {
        denoiser.Apply(FindLayer(layers, kGuides[0]), FindLayer(layers, kGuides[1]), color);
    }
}

} // namespace hds
