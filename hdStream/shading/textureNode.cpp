// SPDX-License-Identifier: Apache-2.0
// UsdUVTexture and MaterialX's image: files, UDIM sets, wrap modes and outputs.
#include "hdStream/shading/colorInputs.h"
#include "hdStream/shading/networkEvaluator.h"
#include "hdStream/shading/shaderMath.h"
#include "kernels/shared/compat.h"

#include <algorithm>
#include <memory>

namespace hds {

namespace {

const char* const kUdim = "<UDIM>";

AssetReference FileOf(const MaterialNode& node, const std::string& input = "file") {
    const auto found = node.parameters.find(input);
    AssetReference file;
    if (found == node.parameters.end()) {
        return file;
    }
    if (const auto* asset = std::get_if<AssetReference>(&found->second)) {
        file = *asset;
    } else if (const auto* text = std::get_if<std::string>(&found->second)) {
        file.authoredPath = *text;
        file.file = *text;
    }
    return file;
}

/// Whether a node has one of MaterialX's definitions, which differ from USD's own of that name.
bool IsMaterialX(const MaterialNode& node) {
    return node.identifier.compare(0, 3, "ND_") == 0;
}

bool IsUdim(const AssetReference& file) {
    return file.file.find(kUdim) != std::string::npos ||
           (file.file.empty() && file.authoredPath.find(kUdim) != std::string::npos);
}

bool IsSame(const AssetReference& a, const AssetReference& b) {
    return a.file == b.file && a.offset == b.offset && a.size == b.size;
}

/// A colour space as MaterialX names it; what says nothing is not converted.
std::string MaterialXColorSpace(const std::string& name) {
    static const std::map<std::string, std::string> kNames = {{"srgb_texture", "sRGB"},
                                                              {"srgb_rec709_scene", "sRGB"},
                                                              {"", "raw"},
                                                              {"none", "raw"},
                                                              {"auto", "raw"},
                                                              {"lin_rec709", "raw"},
                                                              {"lin_srgb", "raw"},
                                                              {"lin_rec709_scene", "raw"}};
    const auto found = kNames.find(name);
    return found == kNames.end() ? name : found->second;
}

} // namespace

/// Index of the image in the node's colour space: an authored sourceColorSpace, else the colour
/// space of the file's attribute, else auto.
std::uint32_t NetworkEvaluator::AddTexture(const MaterialNode& node, const AssetReference& file,
                                           const std::string& input) {
    std::string space = Text(node, "sourceColorSpace");
    if (space.empty() || space == "auto") {
        space = Text(node, "colorSpace:" + input);
    }
    if (IsMaterialX(node) && node.identifier.find("Usd") == 3) {
        space = space.empty() || space == "auto" ? "auto" : MaterialXColorSpace(space);
    } else if (IsMaterialX(node)) {
        space = IsColorImage(node.identifier) ? MaterialXColorSpace(space) : "raw";
    }
    if (space.empty()) {
        space = "auto";
    }
    const auto found = std::find_if(_textures.begin(), _textures.end(), [&](const auto& texture) {
        return IsSame(texture.file, file) && texture.colorSpace == space;
    });
    if (found != _textures.end()) {
        return static_cast<std::uint32_t>(found - _textures.begin());
    }
    _textures.push_back({file, space, 0});
    return static_cast<std::uint32_t>(_textures.size() - 1);
}

/// Textures by tile, for a single image one; empty: none can be read (warns).
std::vector<std::uint32_t> NetworkEvaluator::FindTiles(const MaterialNode& node,
                                                       const AssetReference& file,
                                                       const std::string& input,
                                                       std::vector<ImageFacts>* facts) {
    std::vector<UdimTile> files;
    if (!IsUdim(file)) {
        files.push_back({0, file});
    } else if (_images.findTiles) {
        files = _images.findTiles(file);
    }
    std::vector<std::uint32_t> tiles;
    for (const UdimTile& tile : files) {
        const auto known =
            _images.probe && !tile.file.file.empty() ? _images.probe(tile.file) : std::nullopt;
        if (!known) {
            const std::string& name =
                tile.file.authoredPath.empty() ? tile.file.file : tile.file.authoredPath;
            const std::string reason = tile.file.file.empty() ? ": no such file" : "";
            Warn("cannot read image " + name + " of " + node.path + reason +
                 "; its fallback is used");
            continue;
        }
        tiles.resize(std::max<std::size_t>(tiles.size(), tile.index + 1), HDS_NONE);
        tiles[tile.index] = AddTexture(node, tile.file, input);
        facts->push_back(*known);
    }
    if (files.empty()) {
        Warn("there is no image " + file.authoredPath + " of " + node.path +
             "; its fallback is used");
    }
    return tiles;
}

/// HDS_WRAP_* of wrapS or wrapT. Their default is useMetadata, whose default is black; that of
/// MaterialX's definition is periodic.
std::uint32_t NetworkEvaluator::WrapOf(const MaterialNode& node, const std::string& input,
                                       const std::optional<std::uint32_t>& ofFile) {
    static const std::map<std::string, std::uint32_t> kModes = {{"black", HDS_WRAP_BLACK},
                                                                {"clamp", HDS_WRAP_CLAMP},
                                                                {"repeat", HDS_WRAP_REPEAT},
                                                                {"mirror", HDS_WRAP_MIRROR}};
    if (IsMaterialX(node) && Text(node, input).empty()) {
        return HDS_WRAP_REPEAT;
    }
    const std::string mode = Text(node, input) == "periodic" ? "repeat" : Text(node, input);
    const auto found = kModes.find(mode);
    if (found != kModes.end()) {
        return found->second;
    }
    if (!mode.empty() && mode != "useMetadata") {
        Warn(input + " of " + node.path + " is " + mode + "; useMetadata is used");
    }
    return ofFile.value_or(HDS_WRAP_BLACK);
}

/// The look-up with all four channels, or the node's fallback.
ShaderValue NetworkEvaluator::MakeTexture(const MaterialNode& node) {
    const ShaderValue fallback = EvaluateOr(node, "fallback", {0.0F, 0.0F, 0.0F, 1.0F}, 4);
    const AssetReference file = FileOf(node);
    if (file.authoredPath.empty() && file.file.empty()) {
        Warn(node.path + " names no image file; its fallback is used");
        return fallback;
    }
    std::vector<ImageFacts> facts;
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = ShaderExpression::Kind::Texture;
    expression->tiles = FindTiles(node, file, "file", &facts);
    if (facts.empty()) {
        return fallback;
    }
    const bool isUdim = IsUdim(file);
    for (const char* input : {"fallback", "scale", "bias"}) {
        WarnOfWidth(node, input, 4);
    }
    // Inside a tile nothing wraps.
    const std::uint32_t wrapS = isUdim ? HDS_WRAP_CLAMP : WrapOf(node, "wrapS", facts[0].wrapS);
    const std::uint32_t wrapT = isUdim ? HDS_WRAP_CLAMP : WrapOf(node, "wrapT", facts[0].wrapT);
    expression->lookup = HDS_LOOKUP_WRAPS(wrapS, wrapT) | (isUdim ? HDS_LOOKUP_UDIM : 0U);
    expression->operands = {
        IsMaterialX(node) ? ImageCoordinates(node, "st") : EvaluateOr(node, "st", {}, 2), fallback,
        EvaluateOr(node, "scale", {1.0F, 1.0F, 1.0F, 1.0F}, 4), EvaluateOr(node, "bias", {}, 4)};
    // Black borders and holes are not opaque whatever the image is.
    _hasAlpha[node.path] =
        isUdim || wrapS == HDS_WRAP_BLACK || wrapT == HDS_WRAP_BLACK ||
        std::any_of(facts.begin(), facts.end(), [](const auto& one) { return one.hasAlpha; });
    return {std::move(expression), HDS_CHANNEL_ALL, 4};
}

ShaderValue NetworkEvaluator::EvaluateTexture(const MaterialNode& node, const std::string& output) {
    const std::size_t channel = std::string("rgba").find(output);
    const bool isOne = output.size() == 1 && channel != std::string::npos;
    if (!isOne && output != "rgb" && output != "rgba") {
        Warn(node.path + " has no output " + output);
        return {};
    }
    auto known = _lookups.find(node.path);
    if (known == _lookups.end()) {
        known = _lookups.emplace(node.path, MakeTexture(node)).first;
    }
    const ShaderValue& value = known->second;
    const bool isLookup = value.expression->kind == ShaderExpression::Kind::Texture;
    const std::uint32_t channels = isOne ? 1U << channel : output == "rgb" ? 7U : 15U;
    if (isOne && channel == 3 && isLookup && !_hasAlpha.at(node.path)) {
        const ShaderValue& scale = value.expression->operands[2];
        const ShaderValue& bias = value.expression->operands[3];
        if (IsConstant(scale) && IsConstant(bias)) {
            return MakeConstant({ConstantOf(scale)[3] + ConstantOf(bias)[3], 0.0F, 0.0F, 1.0F}, 1);
        }
    }
    for (const std::uint32_t tile : value.expression->tiles) {
        if (tile != HDS_NONE) {
            _textures[tile].channels |= channels;
        }
    }
    if (isOne) {
        return SelectChannel(value, static_cast<std::uint32_t>(channel));
    }
    return {value.expression, value.channel, output == "rgb" ? 3U : 4U};
}

ShaderValue NetworkEvaluator::ImageCoordinates(const MaterialNode& node, const std::string& input) {
    const ShaderValue authored = Evaluate(node, input);
    if (authored && authored.numComponents >= 2) {
        return authored;
    }
    // OpenUSD's name for MaterialX's UV0; files that were converted may have kept the latter.
    auto other = std::make_shared<ShaderExpression>();
    other->kind = ShaderExpression::Kind::Primvar;
    other->primvar = "UV0";
    other->operands = {MakeConstant({}, 2)};
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = ShaderExpression::Kind::Primvar;
    expression->primvar = "st";
    expression->operands = {{std::move(other), HDS_CHANNEL_ALL, 2}};
    return {std::move(expression), HDS_CHANNEL_ALL, 2};
}

/// HDS_WRAP_* of uaddressmode or vaddressmode.
std::uint32_t NetworkEvaluator::AddressModeOf(const MaterialNode& node, const std::string& input) {
    static const std::map<std::string, std::uint32_t> kModes = {{"", HDS_WRAP_REPEAT},
                                                                {"periodic", HDS_WRAP_REPEAT},
                                                                {"constant", HDS_WRAP_BLACK},
                                                                {"clamp", HDS_WRAP_CLAMP},
                                                                {"mirror", HDS_WRAP_MIRROR}};
    const std::string mode = Text(node, input);
    const auto found = kModes.find(mode);
    if (found == kModes.end()) {
        Warn(input + " of " + node.path + " is " + mode + "; periodic is used");
        return HDS_WRAP_REPEAT;
    }
    return found->second;
}

/// A look-up of one of a node's images, or its default where that cannot be read.
ShaderValue NetworkEvaluator::MakeImage(const MaterialNode& node, const ImageRequest& request) {
    const ShaderValue fallback =
        EvaluateOr(node, "default", request.fallback, request.numComponents);
    const AssetReference file = FileOf(node, request.input);
    if (file.authoredPath.empty() && file.file.empty()) {
        Warn(node.path + " names no image file; its default is used");
        return fallback;
    }
    std::vector<ImageFacts> facts;
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = ShaderExpression::Kind::Texture;
    expression->tiles = FindTiles(node, file, request.input, &facts);
    if (facts.empty()) {
        return fallback;
    }
    const bool isUdim = IsUdim(file);
    const auto modeOf = [&](const char* input) {
        return isUdim               ? std::uint32_t{HDS_WRAP_CLAMP}
               : request.isPeriodic ? std::uint32_t{HDS_WRAP_REPEAT}
                                    : AddressModeOf(node, input);
    };
    expression->lookup =
        (request.wraps ? *request.wraps
                       : HDS_LOOKUP_WRAPS(modeOf("uaddressmode"), modeOf("vaddressmode"))) |
        (isUdim ? HDS_LOOKUP_UDIM : 0U);
    expression->operands = {request.coordinates, fallback,
                            MakeConstant({1.0F, 1.0F, 1.0F, 1.0F}, 4), MakeConstant({}, 4)};
    return {std::move(expression), HDS_CHANNEL_ALL, 4};
}

ShaderValue NetworkEvaluator::EvaluateImage(const MaterialNode& node, const ImageRequest& request) {
    const std::uint32_t numComponents = request.numComponents;
    const std::uint32_t channels = (1U << numComponents) - 1U;
    const std::string key = node.path + "." + request.input + "." + std::to_string(request.number);
    auto known = _lookups.find(key);
    if (known == _lookups.end()) {
        known = _lookups.emplace(key, MakeImage(node, request)).first;
    }
    const ShaderValue& value = known->second;
    for (const std::uint32_t tile : value.expression->tiles) {
        if (tile != HDS_NONE) {
            _textures[tile].channels |= channels;
        }
    }
    if (numComponents == 1) {
        return IsConstant(value) ? value : SelectChannel(value, 0);
    }
    return {value.expression, value.channel, numComponents};
}

} // namespace hds
