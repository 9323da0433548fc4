// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/filmBuffers.h"

#include "hdStream/device/resizeBuffer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <utility>

namespace hds {

namespace {

std::uint32_t OffsetOf(const AovLayout& layout, const char* name) {
    const AovSlot* slot = layout.Find(name);
    return slot != nullptr ? slot->offset : HDS_NONE;
}

/// A sample as resolve_addSamples counts it (kernels/integrator/resolve.cl).
std::array<float, 4> SampleThatCounts(const std::array<float, 4>& value) {
    std::array<float, 4> counted = value;
    const bool isFinite =
        std::all_of(value.begin(), value.begin() + 3, [](float v) { return std::isfinite(v); });
    if (value[3] < 0.0F) { // a shadow catcher's
        return {};
    }
    for (std::size_t c = 0; c < 3; ++c) {
        counted[c] = isFinite ? std::min(value[c], HDS_MAX_SAMPLE) : 0.0F;
    }
    counted[3] = std::isfinite(value[3]) ? value[3] : 0.0F;
    return counted;
}

} // namespace

std::string MatteName(const CommittedScene& scene, MatteKind kind, const MatteSurface& surface) {
    if (kind == MatteKind::Material) {
        const std::string& path = scene.entryMaterials[surface.entry];
        return path.empty() ? "none" : path;
    }
    const std::string& path = scene.primPaths[surface.prim];
    return kind == MatteKind::Instance && surface.instance >= 0
               ? path + "[" + std::to_string(surface.instance) + "]"
               : path;
}

bool NeedsFirstHits(const AovLayout& layout) {
    return std::any_of(layout.slots.begin(), layout.slots.end(),
                       [](const AovSlot& slot) { return slot.info->filter == AovFilter::First; });
}

void FilmBuffers::Reset(const AovLayout& layout, const std::optional<DeepLimits>& deep,
                        std::uint32_t width, std::uint32_t height) {
    _layout = layout;
    _width = width;
    _height = height;
    _hasFirstHits = false;
    const std::uint64_t numPixels = std::uint64_t{width} * height;
    ResizeBuffer(_device, "film", numPixels * sizeof(shared::HdsFilmPixel), &_film);
    ResizeBuffer(_device, "AOV floats", numPixels * layout.floatsPerPixel * sizeof(float),
                 &_floats);
    if (layout.hasMattes) {
        _mattes.Reset(width, height);
    }
    _deep.reset();
    if (deep) {
        _deep.emplace().Reset(width, height, *deep);
    }
    ResizeBuffer(_device, "light path sums",
                 numPixels * NumSums() * sizeof(shared::HdsLightPathPixel), &_lightPaths);
    ResizeBuffer(_device, "AOV ids", numPixels * layout.intsPerPixel * sizeof(std::int32_t),
                 &_ints);
}

void FilmBuffers::Load(StageKernels* kernels, const std::vector<FilmSums>& start) {
    const std::uint32_t numPixels = _width * _height;
    if (!start.empty()) {
        _lightPaths.Fill(0, _lightPaths.Bytes()); // the film is written
    }
    for (std::size_t i = 0; i < start.size(); ++i) {
        const FilmSums& sums = start[i];
        if (sums.pixels.empty()) {
            shared::HdsFilmPixel black{};
            black.numSamples = sums.endSample;
            const std::vector<shared::HdsFilmPixel> pixels(numPixels, black);
            _film.Write(pixels.data(), _film.Bytes());
        } else if (i == 0) {
            _film.Write(sums.pixels.data(), _film.Bytes());
            if (NumSums() > 0) {
                _lightPaths.Write(sums.lightPathPixels.data(), _lightPaths.Bytes());
            }
        } else {
            const Buffer block = UploadVector(_device, "block sums", sums.pixels);
            AddLightPathBlock(kernels, sums, block);
            kernels->addBlock.Launch(numPixels, _film, block, numPixels);
            _device->Finish();
        }
        for (std::uint32_t pixel = 0; _layout.hasMattes && pixel < numPixels; ++pixel) {
            _mattes.SetSamples(pixel, sums.pixels.empty() ? sums.endSample
                                                          : sums.pixels[pixel].numSamples);
        }
        for (const MatteCount& matte : sums.mattes) {
            if (_layout.hasMattes) {
                _mattes.Add(matte.pixel, matte.surface, matte.count);
            }
        }
    }
}

void FilmBuffers::ClearRest(const std::vector<std::uint32_t>& pixels, std::size_t first) {
    if (first == pixels.size()) {
        return;
    }
    const std::uint32_t numPixels = NumPixels();
    std::vector<shared::HdsFilmPixel> film(numPixels);
    std::vector<shared::HdsLightPathPixel> sums(std::size_t{numPixels} * NumSums());
    _device->Finish();
    _film.Read(film.data(), film.size() * sizeof(film[0]));
    _lightPaths.Read(sums.data(), sums.size() * sizeof(sums[0]));
    for (std::size_t i = first; i < pixels.size(); ++i) {
        film[pixels[i]] = {};
        for (std::uint32_t sum = 0; sum < NumSums(); ++sum) {
            sums[std::size_t{sum} * numPixels + pixels[i]] = {};
        }
    }
    _film.Write(film.data(), film.size() * sizeof(film[0]));
    _lightPaths.Write(sums.data(), sums.size() * sizeof(sums[0]));
}

/// Adds the sums of the block that follows. \param block its film.
void FilmBuffers::AddLightPathBlock(StageKernels* kernels, const FilmSums& sums,
                                    const Buffer& block) {
    if (NumSums() > 0) {
        const Buffer added = UploadVector(_device, "block light path sums", sums.lightPathPixels);
        kernels->addLightPathBlock.Launch(std::size_t{NumPixels()} * NumSums(), block, NumPixels(),
                                          NumSums(), NumLightPaths(), _lightPaths, added);
        _device->Finish();
    }
}

std::vector<float> FilmBuffers::RelativeErrors(StageKernels* kernels, const Buffer& pixels,
                                               std::uint32_t count) const {
    const std::uint32_t numPixels = _width * _height;
    const Buffer variances(_device, "pixel variances", std::uint64_t{numPixels} * sizeof(float));
    const Buffer errors(_device, "pixel errors", std::uint64_t{count} * sizeof(float));
    kernels->relativeVariance.Launch(numPixels, _film, numPixels, variances);
    if (kernels->Features().catchers) {
        kernels->addCaughtVariance.Launch(numPixels, _film, _lightPaths,
                                          NumLightPaths() * numPixels, numPixels, variances);
    }
    kernels->relativeError.Launch(count, _film, variances, static_cast<std::int32_t>(_width),
                                  static_cast<std::int32_t>(_height), pixels, count, errors);
    std::vector<float> values(count);
    errors.Read(values.data(), values.size() * sizeof(float));
    return values;
}

double FilmBuffers::MeanRelativeError(StageKernels* kernels, const Buffer& pixels,
                                      std::uint32_t count) const {
    double sum = 0.0;
    for (const float error : RelativeErrors(kernels, pixels, count)) {
        sum += std::isfinite(error) ? error : 0.0;
    }
    return count > 0 ? sum / count : 0.0;
}

FilmSums FilmBuffers::Read(std::uint32_t firstSample, std::uint32_t endSample) const {
    FilmSums sums;
    sums.width = _width;
    sums.height = _height;
    sums.firstSample = firstSample;
    sums.endSample = endSample;
    sums.hasMattes = _layout.hasMattes;
    if (_layout.hasMattes) {
        sums.mattes = _mattes.Counts();
    }
    sums.pixels.resize(std::size_t{_width} * _height);
    _device->Finish();
    _film.Read(sums.pixels.data(), _film.Bytes());
    sums.lightPaths = _layout.SumNames();
    sums.lightPathPixels.resize(sums.pixels.size() * sums.lightPaths.size());
    if (!sums.lightPathPixels.empty()) {
        _lightPaths.Read(sums.lightPathPixels.data(), _lightPaths.Bytes());
    }
    return sums;
}

bool FilmBuffers::NeedsFirstHits() const {
    return hds::NeedsFirstHits(_layout);
}

shared::HdsAovOffsets FilmBuffers::FirstHitOffsets(const glm::dvec3& centre,
                                                   double shutterFrames) const {
    shared::HdsAovOffsets offsets{};
    offsets.floatStride = _layout.floatsPerPixel;
    offsets.intStride = _layout.intsPerPixel;
#define HDS_AOV_OFFSET(member, name) offsets.member = OffsetOf(_layout, name);
    HDS_FIRST_HIT_AOVS(HDS_AOV_OFFSET)
#undef HDS_AOV_OFFSET
    offsets.shutterFrames = static_cast<float>(shutterFrames);
    offsets.primvars = _layout.primvarOffset;
    offsets.numPrimvars = static_cast<std::uint32_t>(_layout.primvars.size());
    for (int i = 0; i < 3; ++i) {
        offsets.centre[i] = static_cast<float>(centre[i]);
    }
    return offsets;
}

void FilmBuffers::AddMattes(const CommittedScene& scene, const std::uint32_t* pixels,
                            std::uint32_t numSamples,
                            const std::vector<std::array<std::uint32_t, 4>>& surfaces) {
    for (std::size_t slot = 0; slot < surfaces.size(); ++slot) {
        const std::uint32_t pixel = pixels[slot / numSamples];
        const auto& [prim, entry, instance, unused] = surfaces[slot];
        _mattes.AddSample(pixel);
        if (prim != HDS_NONE) {
            _mattes.Add(pixel,
                        {scene.AuthoredPrim(prim), scene.AuthoredEntry(entry),
                         static_cast<std::int32_t>(instance)},
                        1);
        }
    }
}

void FilmBuffers::AddDeep(const std::uint32_t* pixels, std::uint32_t numSamples,
                          const std::vector<std::array<std::uint32_t, 4>>& surfaces,
                          const std::vector<std::array<float, 4>>& radiances) {
    for (std::size_t slot = 0; slot < surfaces.size(); ++slot) {
        const auto& [prim, kind, instance, depthBits] = surfaces[slot];
        DeepHit hit;
        hit.surface = {prim, prim == HDS_NONE ? kind : instance};
        std::memcpy(&hit.depth, &depthBits, sizeof(hit.depth));
        hit.radiance = SampleThatCounts(radiances[slot]);
        const std::uint32_t pixel = pixels[slot / numSamples];
        const bool isSeen = std::any_of(hit.radiance.begin(), hit.radiance.end(),
                                        [](float value) { return value != 0.0F; });
        if (isSeen) {
            _deep->Add(pixel, hit);
        } else {
            _deep->AddNothing(pixel);
        }
    }
}

/// Puts the layers of Cryptomattes into their places.
void FilmBuffers::DevelopMattes(const MatteNamer& nameOf, std::vector<ImageLayer>* layers) const {
    std::map<std::string, std::pair<MatteKind, std::uint32_t>> asked; // and the number of layers
    for (const ImageLayer& layer : *layers) {
        if (const std::optional<MatteAov> aov = ParseMatteAov(layer.name)) {
            auto& [kind, numLayers] = asked[aov->cryptomatte];
            kind = aov->kind;
            numLayers = std::max(numLayers, *aov->layer + 1);
        }
    }
    for (const auto& [cryptomatte, about] : asked) {
        for (ImageLayer& made :
             _mattes.MakeLayers(about.first, cryptomatte, about.second, nameOf)) {
            const auto place =
                std::find_if(layers->begin(), layers->end(),
                             [&](const ImageLayer& layer) { return layer.name == made.name; });
            if (place != layers->end()) {
                *place = std::move(made);
            }
        }
    }
}

std::vector<ImageLayer> FilmBuffers::Develop(StageKernels* kernels, std::uint32_t previewStride,
                                             const MatteNamer& nameOf) {
    std::vector<ImageLayer> layers;
    if (previewStride == 0) {
        for (const AovSlot& slot : _layout.slots) {
            layers.push_back(MakeClearLayer(*slot.info, _width, _height));
        }
        return layers;
    }
    // Of a preview only those pixels that it has: the next one waits for this one.
    const std::uint32_t width = (_width + previewStride - 1) / previewStride;
    const std::uint32_t height = (_height + previewStride - 1) / previewStride;
    const std::uint32_t numPixels = width * height;
    kernels->develop.Launch(numPixels, _film, numPixels, _width, width, previewStride, _floats,
                            _layout.floatsPerPixel, _ints, _layout.intsPerPixel,
                            OffsetOf(_layout, "color"), OffsetOf(_layout, "alpha"),
                            OffsetOf(_layout, "variance"), OffsetOf(_layout, "sampleCount"),
                            OffsetOf(_layout, "noisy"));
    if (kernels->Features().catchers) {
        kernels->developCatchers.Launch(
            numPixels, _film, _lightPaths, NumLightPaths() * NumPixels(), NumPixels(), numPixels,
            _width, width, previewStride, _floats, _layout.floatsPerPixel,
            OffsetOf(_layout, "color"), OffsetOf(_layout, "alpha"), OffsetOf(_layout, "noisy"));
    }
    if (kernels->Features().occlusion) {
        kernels->developOcclusion.Launch(
            numPixels, _film, _lightPaths, OcclusionSum() * NumPixels(), numPixels, _width, width,
            previewStride, _floats, _layout.floatsPerPixel, OffsetOf(_layout, kOcclusionAov));
    }
    for (const AovSlot& slot : _layout.slots) {
        if (!slot.info->lightPaths.empty()) {
            kernels->developLightPath.Launch(
                numPixels, _film, _lightPaths, slot.lightPath * NumPixels(), numPixels, _width,
                width, previewStride, _floats, _layout.floatsPerPixel, slot.offset,
                std::uint32_t{slot.info->filter == AovFilter::Counter ? 1U : 0U});
        }
    }
    std::vector<float> floats(std::size_t{numPixels} * _layout.floatsPerPixel);
    std::vector<std::int32_t> ints(std::size_t{numPixels} * _layout.intsPerPixel);
    _device->Finish();
    _floats.Read(floats.data(), floats.size() * sizeof(float));
    _ints.Read(ints.data(), ints.size() * sizeof(std::int32_t));
    layers = MakeLayers(_layout, width, height, floats.data(), ints.data());
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const AovInfo& info = *_layout.slots[i].info;
        if (info.filter == AovFilter::First && !_hasFirstHits) {
            layers[i] = MakeClearLayer(info, _width, _height);
        } else if (previewStride > 1 && info.filter != AovFilter::Matte) {
            layers[i] = EnlargePreview(info, layers[i], _width, _height, previewStride,
                                       info.filter == AovFilter::Weighted ? PreviewFill::Squares
                                                                          : PreviewFill::Clear);
        }
    }
    if (_layout.hasMattes) {
        DevelopMattes(nameOf, &layers);
    }
    return layers;
}

} // namespace hds
