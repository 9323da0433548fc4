// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/imageLibrary.h"

#include "hdStream/base/fieldHash.h"
#include "hdStream/texture/imageChannel.h"
#include "hdStream/texture/udim.h"

namespace hds {

namespace {

/// Equal for equal images; files that were not found are told apart by what the scene calls them.
std::string KeyOf(const AssetReference& asset) {
    const std::string& name = asset.file.empty() ? asset.authoredPath : asset.file;
    return name + '\n' + std::to_string(asset.offset) + '\n' + std::to_string(asset.size);
}

/// HDS_WRAP_* of a file's wrap mode as OpenImageIO or UsdUVTexture calls it.
std::optional<std::uint32_t> WrapFrom(const std::string& mode) {
    static const std::map<std::string, std::uint32_t> kModes = {{"black", HDS_WRAP_BLACK},
                                                                {"clamp", HDS_WRAP_CLAMP},
                                                                {"periodic", HDS_WRAP_REPEAT},
                                                                {"repeat", HDS_WRAP_REPEAT},
                                                                {"mirror", HDS_WRAP_MIRROR}};
    const auto found = kModes.find(mode);
    return found == kModes.end() ? std::nullopt : std::make_optional(found->second);
}

TextureUse UseOf(const AssetReference& asset, const ImageInfo& info, const std::string& error) {
    return {asset.authoredPath, info.width,       info.height, info.channels,
            info.bytesDecoded,  info.channelType, error};
}

} // namespace

std::string MaterialTextureKey(const MaterialTexture& texture) {
    MaterialTexture named = texture;
    if (!named.file.file.empty()) {
        named.file.authoredPath.clear();
    }
    Hasher hasher;
    FieldHasher(&hasher).Add(named);
    return hasher.Hex();
}

ImageSource SourceOf(const AssetReference& asset) {
    return {asset.file, asset.offset, asset.size, asset.authoredPath};
}

TextureRequest RequestOf(const MaterialTexture& texture) {
    TextureRequest request;
    request.colorSpace = texture.colorSpace;
    request.channels = texture.channels;
    request.isRadiance = texture.isRadiance;
    return request;
}

MaterialTexture LightTextureOf(const AssetReference& asset) {
    MaterialTexture texture;
    texture.file = asset;
    texture.file.colorSpace.clear();
    texture.colorSpace = asset.colorSpace.empty() ? "auto" : asset.colorSpace;
    texture.channels = TextureRequest::kRed | TextureRequest::kGreen | TextureRequest::kBlue;
    texture.isRadiance = true;
    return texture;
}

std::optional<ImageFacts> ImageLibrary::Probe(const AssetReference& asset) {
    const std::string key = KeyOf(asset);
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        const auto known = _headers.find(key);
        if (known != _headers.end()) {
            _uses[key] = known->second.use;
            return known->second.facts;
        }
    }
    Header header = ReadHeader(asset);
    const std::lock_guard<std::mutex> lock(_mutex);
    _uses[key] = header.use;
    return _headers.emplace(key, std::move(header)).first->second.facts;
}

ImageLibrary::Header ImageLibrary::ReadHeader(const AssetReference& asset) const {
    if (asset.file.empty()) {
        return {std::nullopt, UseOf(asset, {}, "the file does not exist")};
    }
    const ImageInfo info = ProbeImage(SourceOf(asset), _store.get());
    Header header{std::nullopt, UseOf(asset, info, info.error)};
    if (info.Ok()) {
        header.facts = ImageFacts{info.hasAlpha, WrapFrom(info.wrapS), WrapFrom(info.wrapT)};
    }
    return header;
}

std::vector<UdimTile> ImageLibrary::FindTiles(const AssetReference& pattern) {
    std::vector<UdimTile> tiles;
    for (const UdimFile& file : FindUdimFiles(pattern.file)) {
        const std::string name = TileName(pattern.authoredPath, file.index);
        tiles.push_back({file.index, {name, file.place.file, file.place.offset, file.place.size}});
    }
    return tiles;
}

std::shared_ptr<const HeightImage> ImageLibrary::LoadHeights(const MaterialTexture& texture,
                                                             std::uint32_t channel) {
    const std::lock_guard<std::mutex> lock(_mutex);
    std::weak_ptr<const HeightImage>& known =
        _heights[MaterialTextureKey(texture) + '\n' + std::to_string(channel)];
    if (auto image = known.lock()) {
        return image;
    }
    ImageChannel heights = LoadImageChannel(SourceOf(texture.file), texture.colorSpace, channel);
    if (!heights.warning.empty()) {
        _warnings.Add("", heights.warning);
    }
    if (!heights.error.empty()) {
        _warnings.Add("", heights.error);
        return nullptr;
    }
    auto image = std::make_shared<HeightImage>();
    image->width = heights.width;
    image->height = heights.height;
    image->values = std::move(heights.values);
    known = image;
    return image;
}

void ImageLibrary::LoadHeights(DisplacementNetwork* network) {
    for (DisplacementStep& step : network->steps) {
        for (DisplacementTile& tile : step.tiles) {
            for (std::uint32_t channel = 0; channel < 4; ++channel) {
                if ((tile.channels >> channel & 1U) != 0) {
                    tile.heights[channel] = LoadHeights(tile.texture, channel);
                }
            }
        }
    }
}

std::shared_ptr<const LightImage> ImageLibrary::LoadLightImage(const AssetReference& asset,
                                                               TexturePreparer* preparer) {
    const std::string key = KeyOf(asset) + '\n' + asset.colorSpace;
    const std::lock_guard<std::mutex> lock(_mutex);
    auto known = _ofLights.find(key);
    if (known == _ofLights.end()) {
        known = _ofLights.emplace(key, ReadLightImage(asset, preparer)).first;
    }
    known->second.isAskedFor = true;
    _uses[KeyOf(asset)] = known->second.use;
    return known->second.image;
}

void ImageLibrary::DropLightImages() {
    const std::lock_guard<std::mutex> lock(_mutex);
    for (auto known = _ofLights.begin(); known != _ofLights.end();) {
        const bool isKept = known->second.isAskedFor;
        known->second.isAskedFor = false;
        known = isKept ? std::next(known) : _ofLights.erase(known);
    }
}

ImageLibrary::OfLight ImageLibrary::ReadLightImage(const AssetReference& asset,
                                                   TexturePreparer* preparer) const {
    OfLight light;
    const Header header = ReadHeader(asset);
    light.use = header.use;
    if (!header.facts) {
        return light;
    }
    light.texture = preparer->Prepare(SourceOf(asset), RequestOf(LightTextureOf(asset)));
    light.use.error = light.texture->Description().error;
    auto image = std::make_shared<LightImage>();
    const shared::HdsTexture& record = light.texture->Record();
    image->mip = FindTableMip(record.width, record.height);
    image->width = shared::texture_mipSize(record.width, image->mip);
    image->height = shared::texture_mipSize(record.height, image->mip);
    const std::vector<float> rgba = light.texture->DecodeMip(image->mip);
    if (!light.texture->Ok() || rgba.empty()) {
        return light;
    }
    image->rgb.reserve(rgba.size() / 4 * 3);
    for (std::size_t i = 0; i < rgba.size(); i += 4) {
        image->rgb.insert(image->rgb.end(), {rgba[i], rgba[i + 1], rgba[i + 2]});
    }
    light.image = std::move(image);
    return light;
}

void ImageLibrary::BeginCommit() {
    const std::lock_guard<std::mutex> lock(_mutex);
    _uses.clear();
}

std::vector<TextureUse> ImageLibrary::Uses() const {
    const std::lock_guard<std::mutex> lock(_mutex);
    std::vector<TextureUse> uses;
    for (const auto& [path, use] : _uses) {
        uses.push_back(use);
    }
    return uses;
}

void ImageLibrary::Clear() {
    const std::lock_guard<std::mutex> lock(_mutex);
    _headers.clear();
    _heights.clear();
    _ofLights.clear();
    ++_epoch;
}

std::uint64_t ImageLibrary::Epoch() const {
    const std::lock_guard<std::mutex> lock(_mutex);
    return _epoch;
}

std::optional<TextureUse> ImageLibrary::FindUse(const AssetReference& asset) const {
    const std::lock_guard<std::mutex> lock(_mutex);
    const auto use = _uses.find(KeyOf(asset));
    return use == _uses.end() ? std::nullopt : std::make_optional(use->second);
}

} // namespace hds
