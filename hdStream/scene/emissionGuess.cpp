// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/emissionGuess.h"

#include "hdStream/scene/textureAmount.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hds {

namespace {

/// The mip that is read has at most so many texels.
constexpr std::uint64_t kMaxTexels = 1U << 20U;
/// Points on a triangle, and on all of a mesh if it has few triangles.
constexpr std::uint32_t kMinPoints = 16;
constexpr std::uint32_t kMaxPoints = 4096;
constexpr std::uint32_t kMeshPoints = 1U << 16U;

double Luminance(const float* rgb) {
    return 0.2126 * double(rgb[0]) + 0.7152 * double(rgb[1]) + 0.0722 * double(rgb[2]);
}

/// The weighed sum of the channels of a texture's mip; null when it cannot be read.
std::shared_ptr<const HeightImage> ReadImage(const MaterialTexture& texture,
                                             const EmissionInput& emission, CommitCache* cache) {
    const std::shared_ptr<const PreparedTexture> prepared =
        cache->textures->Prepare(SourceOf(texture.file), RequestOf(texture));
    if (!prepared->Ok()) {
        return nullptr;
    }
    const shared::HdsTexture& record = prepared->Record();
    auto image = std::make_shared<HeightImage>();
    std::uint32_t mip = 0;
    do {
        image->width = shared::texture_mipSize(record.width, mip);
        image->height = shared::texture_mipSize(record.height, mip);
    } while (std::uint64_t(image->width) * image->height > kMaxTexels && ++mip < record.numMips);
    const std::vector<float> rgba = prepared->DecodeMip(std::min(mip, record.numMips - 1));
    for (std::size_t i = 0; i < rgba.size(); i += 4) {
        float sum = emission.bias;
        for (std::size_t channel = 0; channel < 4; ++channel) {
            sum += emission.factors[channel] * rgba[i + channel];
        }
        image->values.push_back(std::max(sum, 0.0F));
    }
    return rgba.empty() ? nullptr : image;
}

/// The image of a look-up, read once.
std::shared_ptr<const HeightImage> FindImage(const EmissionInput& emission,
                                             const MaterialCommit& materials, CommitCache* cache) {
    std::string key = MaterialTextureKey(emission.lookup->texture);
    const auto texture =
        std::find_if(materials.textures.begin(), materials.textures.end(),
                     [&](const MaterialTexture& one) { return MaterialTextureKey(one) == key; });
    if (texture == materials.textures.end()) {
        return nullptr;
    }
    key += '\n' + std::to_string(cache->images.Epoch()) + '\n';
    key.append(reinterpret_cast<const char*>(emission.factors.data()), sizeof(emission.factors));
    key.append(reinterpret_cast<const char*>(&emission.bias), sizeof(emission.bias));
    auto known = cache->emissionImages.find(key);
    if (known == cache->emissionImages.end()) {
        EmissionImage read{ReadImage(*texture, emission, cache)};
        known = cache->emissionImages.emplace(key, std::move(read)).first;
    }
    known->second.isUsed = true;
    return known->second.image;
}

} // namespace

EmissionGuess::EmissionGuess(const EmissionInput& emission, const ChunkGeometry& chunk,
                             const MaterialCommit& materials, CommitCache* cache)
    : _chunk(chunk) {
    const auto found = std::find_if(
        chunk.attributes.begin(), chunk.attributes.end(),
        [&](const GeometryAttribute& attribute) { return attribute.name == emission.primvar; });
    const std::uint32_t numComponents = emission.lookup ? 2 : 3;
    if (emission.primvar.empty() || found == chunk.attributes.end() ||
        found->numComponents < numComponents || chunk.triangles.empty()) {
        return;
    }
    if (emission.lookup) {
        DisplacementLookup lookup = *emission.lookup;
        lookup.image = FindImage(emission, materials, cache);
        lookup.scale = 1.0F;
        lookup.bias = 0.0F;
        if (!lookup.image) {
            return;
        }
        _texture = MakeTextureAmount(emission.primvar, std::move(lookup));
        const auto share = static_cast<std::uint32_t>(kMeshPoints / chunk.triangles.size());
        _numPoints = std::clamp(share, kMinPoints, kMaxPoints);
    }
    _attribute = &*found;
}

const float* EmissionGuess::CornerValue(std::uint32_t triangle, int corner) const {
    std::size_t element = 0;
    switch (_attribute->interpolation) {
    case Interpolation::Uniform:
        element = _chunk.faces[triangle];
        break;
    case Interpolation::FaceVarying:
        element = _chunk.corners[triangle][corner];
        break;
    case Interpolation::Vertex:
    case Interpolation::Varying:
        element = _chunk.points[_chunk.triangles[triangle][corner]];
        break;
    default:
        break;
    }
    const std::size_t index = _attribute->indices.empty()
                                  ? element
                                  : static_cast<std::size_t>(_attribute->indices[element]);
    return _attribute->values.data() + index * _attribute->numComponents;
}

double EmissionGuess::Of(std::uint32_t triangle) const {
    if (_attribute == nullptr) {
        return 1.0;
    }
    const float* values[3];
    for (int corner = 0; corner < 3; ++corner) {
        values[corner] = CornerValue(triangle, corner);
    }
    if (!_texture) {
        return (Luminance(values[0]) + Luminance(values[1]) + Luminance(values[2])) / 3.0;
    }
    double sum = 0.0;
    AmountPoint point = MissingPoint(*_texture);
    for (std::uint32_t i = 0; i < _numPoints; ++i) {
        // Source: Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences": R2.
        double u = std::fmod(0.5 + 0.7548776662466927 * i, 1.0);
        double v = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
        if (u + v > 1.0) {
            u = 1.0 - u;
            v = 1.0 - v;
        }
        for (std::size_t k = 0; k < 2; ++k) {
            point.primvars[0][k] = (1.0 - u - v) * double(values[0][k]) + u * double(values[1][k]) +
                                   v * double(values[2][k]);
        }
        sum += _texture->At(point);
    }
    return sum / _numPoints;
}

} // namespace hds
