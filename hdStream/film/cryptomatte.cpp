// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/cryptomatte.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <map>
#include <tuple>
#include <utility>

namespace hds {

namespace {

const std::array<std::pair<const char*, MatteKind>, 3> kKinds = {
    {{"crypto_object", MatteKind::Object},
     {"crypto_material", MatteKind::Material},
     {"crypto_instance", MatteKind::Instance}}};

std::uint32_t RotateLeft(std::uint32_t value, int bits) {
    return value << bits | value >> (32 - bits);
}

std::uint32_t MixBlock(std::uint32_t block) {
    return RotateLeft(block * 0xcc9e2d51U, 15) * 0x1b873593U;
}

std::uint32_t MurmurHash3(const std::string& text) {
    const std::size_t numBlocks = text.size() / 4;
    std::uint32_t hash = 0;
    for (std::size_t i = 0; i < numBlocks; ++i) {
        std::uint32_t block = 0;
        std::memcpy(&block, text.data() + 4 * i, sizeof(block));
        hash = RotateLeft(hash ^ MixBlock(block), 13) * 5U + 0xe6546b64U;
    }
    std::uint32_t tail = 0;
    for (std::size_t i = text.size(); i > 4 * numBlocks; --i) {
        tail = tail << 8U | static_cast<unsigned char>(text[i - 1]);
    }
    if (text.size() > 4 * numBlocks) {
        hash ^= MixBlock(tail);
    }
    hash ^= static_cast<std::uint32_t>(text.size());
    hash = (hash ^ hash >> 16U) * 0x85ebca6bU;
    hash = (hash ^ hash >> 13U) * 0xc2b2ae35U;
    return hash ^ hash >> 16U;
}

std::string Hex(std::uint32_t value) {
    char text[9];
    std::snprintf(text, sizeof(text), "%08x", value);
    return text;
}

std::string JsonText(const std::string& text) {
    std::string json = "\"";
    for (const char c : text) {
        const auto code = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            json += '\\';
        }
        if (code < 0x20U) {
            char escaped[7];
            std::snprintf(escaped, sizeof(escaped), "\\u%04x", code);
            json += escaped;
        } else {
            json += c;
        }
    }
    return json + "\"";
}

/// Entries of a file's header that make readers find a Cryptomatte and its names.
std::map<std::string, std::string> MakeHeader(const std::string& cryptomatte,
                                              const std::map<std::string, std::uint32_t>& names) {
    std::string manifest = "{";
    for (const auto& [name, id] : names) {
        manifest += (manifest.size() > 1 ? "," : "") + JsonText(name) + ":\"" + Hex(id) + "\"";
    }
    const std::string key = "cryptomatte/" + Hex(MurmurHash3(cryptomatte)).substr(0, 7) + "/";
    return {{key + "name", cryptomatte},
            {key + "hash", "MurmurHash3_32"},
            {key + "conversion", "uint32_to_float32"},
            {key + "manifest", manifest + "}"}};
}

/// An id and how many samples have it.
struct Rank {
    std::uint32_t id = 0;
    std::uint32_t count = 0;
};

void AddToRanks(std::uint32_t id, std::uint32_t count, std::vector<Rank>* ranks) {
    for (Rank& rank : *ranks) {
        if (rank.id == id) {
            rank.count += count;
            return;
        }
    }
    ranks->push_back({id, count});
}

} // namespace

std::optional<MatteAov> ParseMatteAov(const std::string& name) {
    for (const auto& [cryptomatte, kind] : kKinds) {
        const std::size_t length = std::strlen(cryptomatte);
        if (name.compare(0, length, cryptomatte) != 0) {
            continue;
        }
        if (name.size() == length) {
            return MatteAov{kind, cryptomatte, std::nullopt};
        }
        for (std::uint32_t layer = 0; layer < kMaxMatteLayers; ++layer) {
            if (name == MatteLayerName(cryptomatte, layer)) {
                return MatteAov{kind, cryptomatte, layer};
            }
        }
    }
    return std::nullopt;
}

std::string MatteLayerName(const std::string& cryptomatte, std::uint32_t layer) {
    return cryptomatte + (layer < 10 ? "0" : "") + std::to_string(layer);
}

std::uint32_t MatteId(const std::string& name) {
    const std::uint32_t hash = MurmurHash3(name);
    const std::uint32_t exponent = hash >> 23U & 0xffU;
    return exponent == 0 || exponent == 0xffU ? hash ^ 1U << 23U : hash;
}

std::size_t MatteSums::SurfaceHash::operator()(const MatteSurface& surface) const noexcept {
    std::uint64_t hash = surface.prim * 0x9e3779b97f4a7c15ULL;
    hash = (hash ^ hash >> 32U ^ surface.entry) * 0xbf58476d1ce4e5b9ULL;
    hash =
        (hash ^ hash >> 29U ^ static_cast<std::uint32_t>(surface.instance)) * 0x94d049bb133111ebULL;
    return static_cast<std::size_t>(hash ^ hash >> 31U);
}

void MatteSums::Reset(std::uint32_t width, std::uint32_t height) {
    const std::size_t numPixels = std::size_t{width} * height;
    _width = width;
    _height = height;
    _numSamples.assign(numPixels, 0);
    _first.assign(numPixels, {});
    _others.clear();
    _surfaces.clear();
    _indices.clear();
}

void MatteSums::Add(std::uint32_t pixel, const MatteSurface& surface, std::uint32_t count) {
    const auto [found, isNew] =
        _indices.emplace(surface, static_cast<std::uint32_t>(_surfaces.size()));
    if (isNew) {
        _surfaces.push_back(surface);
    }
    const std::uint32_t index = found->second;
    Share& first = _first[pixel];
    if (first.count == 0) {
        first = {index, count};
        return;
    }
    if (first.surface == index) {
        first.count += count;
        return;
    }
    std::vector<Share>& others = _others[pixel];
    for (Share& share : others) {
        if (share.surface == index) {
            share.count += count;
            return;
        }
    }
    others.push_back({index, count});
}

std::vector<MatteSums::Share> MatteSums::SharesOf(std::uint32_t pixel) const {
    std::vector<Share> shares;
    if (_first[pixel].count > 0) {
        shares.push_back(_first[pixel]);
        const auto others = _others.find(pixel);
        if (others != _others.end()) {
            shares.insert(shares.end(), others->second.begin(), others->second.end());
        }
    }
    return shares;
}

std::vector<MatteCount> MatteSums::Counts() const {
    std::vector<MatteCount> counts;
    for (std::uint32_t pixel = 0; pixel < _first.size(); ++pixel) {
        const std::size_t begin = counts.size();
        for (const Share& share : SharesOf(pixel)) {
            counts.push_back({pixel, _surfaces[share.surface], share.count});
        }
        std::sort(counts.begin() + static_cast<std::ptrdiff_t>(begin), counts.end(),
                  [](const MatteCount& a, const MatteCount& b) {
                      return std::tie(a.surface.prim, a.surface.entry, a.surface.instance) <
                             std::tie(b.surface.prim, b.surface.entry, b.surface.instance);
                  });
    }
    return counts;
}

std::vector<ImageLayer> MatteSums::MakeLayers(MatteKind kind, const std::string& cryptomatte,
                                              std::uint32_t numLayers,
                                              const MatteNamer& nameOf) const {
    std::map<std::string, std::uint32_t> names;
    std::vector<std::uint32_t> ids;
    for (const MatteSurface& surface : _surfaces) {
        const std::string name = nameOf(kind, surface);
        ids.push_back(MatteId(name));
        names.emplace(name, ids.back());
    }
    const std::map<std::string, std::string> header = MakeHeader(cryptomatte, names);
    std::vector<ImageLayer> layers(numLayers);
    for (std::uint32_t layer = 0; layer < numLayers; ++layer) {
        layers[layer].name = MatteLayerName(cryptomatte, layer);
        layers[layer].channels = {"R", "G", "B", "A"};
        layers[layer].width = _width;
        layers[layer].height = _height;
        layers[layer].values.assign(4 * _first.size(), 0.0F);
        layers[layer].header = header;
    }
    std::vector<Rank> ranks;
    for (std::uint32_t pixel = 0; pixel < _first.size(); ++pixel) {
        ranks.clear();
        for (const Share& share : SharesOf(pixel)) {
            AddToRanks(ids[share.surface], share.count, &ranks);
        }
        std::sort(ranks.begin(), ranks.end(), [](const Rank& a, const Rank& b) {
            return a.count != b.count ? a.count > b.count : a.id < b.id;
        });
        const auto numSamples = static_cast<float>(std::max(_numSamples[pixel], 1U));
        for (std::size_t i = 0; i < ranks.size() && i < std::size_t{2} * numLayers; ++i) {
            float* value = &layers[i / 2].values[4 * std::size_t{pixel} + 2 * (i % 2)];
            std::memcpy(&value[0], &ranks[i].id, sizeof(float));
            value[1] = static_cast<float>(ranks[i].count) / numSamples;
        }
    }
    return layers;
}

} // namespace hds
