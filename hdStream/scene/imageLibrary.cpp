// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/imageLibrary.h"

#include "hdStream/texture/imageReader.h"

namespace hds {

namespace {

/// A dome keeps at most this many texels; larger images are box filtered in linear light.
constexpr std::uint64_t kMaxDomeTexels = 8192ULL * 4096ULL;

ImageSource SourceOf(const AssetReference& asset) {
    return {asset.file, asset.offset, asset.size, asset.authoredPath};
}

/// Equal for equal images; files that were not found are told apart by what the scene calls them.
std::string KeyOf(const AssetReference& asset) {
    const std::string& name = asset.file.empty() ? asset.authoredPath : asset.file;
    return name + '\n' + std::to_string(asset.offset) + '\n' + std::to_string(asset.size);
}

TextureUse UseOf(const AssetReference& asset, const ImageInfo& info, const std::string& error) {
    return {asset.authoredPath, info.width, info.height, info.channels, info.bytesDecoded, error};
}

} // namespace

void ImageLibrary::Record(const AssetReference& asset, const TextureUse& use) {
    const std::lock_guard<std::mutex> lock(_mutex);
    _uses[KeyOf(asset)] = use;
}

std::optional<std::array<float, 4>> ImageLibrary::MeanOf(const AssetReference& asset,
                                                         const std::string& colorSpace) {
    const std::string key = KeyOf(asset) + '\n' + colorSpace;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        const auto known = _means.find(key);
        if (known != _means.end()) {
            return known->second;
        }
    }
    std::optional<std::array<float, 4>> mean;
    if (asset.file.empty()) {
        Record(asset, UseOf(asset, {}, "the file does not exist"));
    } else {
        const MeanColorResult result = MeanColor(SourceOf(asset), colorSpace);
        Record(asset, UseOf(asset, result.info, result.error));
        if (result.Ok()) {
            mean = std::array<float, 4>{};
            for (std::size_t i = 0; i < 4; ++i) {
                (*mean)[i] = static_cast<float>(result.rgba[i]);
            }
        }
        if (!result.warning.empty()) {
            _warnings.Add("", result.warning);
        }
    }
    const std::lock_guard<std::mutex> lock(_mutex);
    return _means.emplace(key, mean).first->second;
}

std::shared_ptr<const DomeImage> ImageLibrary::LoadDome(const AssetReference& asset) {
    if (asset.file.empty()) {
        Record(asset, UseOf(asset, {}, "the file does not exist"));
        return nullptr;
    }
    LinearImage image = LoadLinearImage(SourceOf(asset), "auto", kMaxDomeTexels);
    Record(asset, UseOf(asset, image.info, image.error));
    if (!image.warning.empty()) {
        _warnings.Add("", image.warning);
    }
    if (image.numNonFinite > 0) {
        _warnings.Add(asset.authoredPath, std::to_string(image.numNonFinite) +
                                              " values are not finite and were replaced");
    }
    if (!image.Ok()) {
        return nullptr;
    }
    auto dome = std::make_shared<DomeImage>();
    dome->width = image.width;
    dome->height = image.height;
    dome->rgb = std::move(image.pixels);
    return dome;
}

std::vector<TextureUse> ImageLibrary::Uses() const {
    const std::lock_guard<std::mutex> lock(_mutex);
    std::vector<TextureUse> uses;
    for (const auto& [path, use] : _uses) {
        uses.push_back(use);
    }
    return uses;
}

} // namespace hds
