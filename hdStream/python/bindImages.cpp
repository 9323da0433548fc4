// SPDX-License-Identifier: Apache-2.0
#include "hdStream/python/bindings.h"
#include "hdStream/session/imageMetadata.h"
#include "hdStream/session/session.h"
#include "hdStream/session/settingsCheck.h"

#include <cstring>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

namespace nb = nanobind;
using namespace nb::literals;

namespace hds::python {

namespace {

using ReleaseGil = nb::call_guard<nb::gil_scoped_release>;

/// The layer's pixels as a numpy array that keeps the layer alive.
nb::object PixelsOf(nb::handle self) {
    const auto& layer = nb::cast<const ImageLayer&>(self);
    if (layer.isInteger) {
        const std::size_t shape[2] = {layer.height, layer.width};
        return nb::cast(
            nb::ndarray<nb::numpy, const std::int32_t>(layer.ids.data(), 2, shape, self));
    }
    const std::size_t shape[3] = {layer.height, layer.width, layer.channels.size()};
    return nb::cast(nb::ndarray<nb::numpy, const float>(layer.values.data(), 3, shape, self));
}

/// A copy of an array [height][width] of ids as a layer.
ImageLayer LayerFromIds(const std::string& name, const std::vector<std::string>& channels,
                        const nb::ndarray<const std::int32_t, nb::ndim<2>, nb::c_contig>& ids) {
    ImageLayer layer;
    layer.name = name;
    layer.channels = channels;
    layer.isInteger = true;
    layer.height = static_cast<std::uint32_t>(ids.shape(0));
    layer.width = static_cast<std::uint32_t>(ids.shape(1));
    layer.ids.assign(ids.data(), ids.data() + ids.size());
    return layer;
}

/// A copy of an array [height][width][channels] as a layer of floats.
ImageLayer LayerFromPixels(const std::string& name, const std::vector<std::string>& channels,
                           const nb::ndarray<const float, nb::ndim<3>, nb::c_contig>& pixels) {
    if (pixels.shape(2) != channels.size()) {
        throw nb::value_error("the array's last dimension is not the number of channels");
    }
    ImageLayer layer;
    layer.name = name;
    layer.channels = channels;
    layer.height = static_cast<std::uint32_t>(pixels.shape(0));
    layer.width = static_cast<std::uint32_t>(pixels.shape(1));
    layer.values.assign(pixels.data(), pixels.data() + pixels.size());
    return layer;
}

void BindWriting(nb::module_& module) {
    nb::class_<ImageLayer>(module, "ImageLayer", "One finished AOV.")
        .def(
            "__init__",
            [](ImageLayer* self, const std::string& name, const std::vector<std::string>& channels,
               const nb::ndarray<const float, nb::ndim<3>, nb::c_contig>& pixels) {
                new (self) ImageLayer(LayerFromPixels(name, channels, pixels));
            },
            "name"_a, "channels"_a, "pixels"_a)
        .def(
            "__init__",
            [](ImageLayer* self, const std::string& name, const std::vector<std::string>& channels,
               const nb::ndarray<const std::int32_t, nb::ndim<2>, nb::c_contig>& ids) {
                new (self) ImageLayer(LayerFromIds(name, channels, ids));
            },
            "name"_a, "channels"_a, "ids"_a)
        .def(nb::init<const ImageLayer&>(), "layer"_a, "A copy.")
        .def_rw("name", &ImageLayer::name)
        .def_rw("isHalf", &ImageLayer::isHalf)
        .def_ro("channels", &ImageLayer::channels)
        .def_ro("isInteger", &ImageLayer::isInteger)
        .def_ro("width", &ImageLayer::width)
        .def_ro("height", &ImageLayer::height)
        .def_rw("header", &ImageLayer::header)
        .def_prop_ro("pixels", &PixelsOf, "[height][width][channels], or [height][width] of ids.");

    nb::class_<ImageMetadata>(module, "ImageMetadata", "What a file says about the render.")
        .def(nb::init<>())
        .def_rw("software", &ImageMetadata::software)
        .def_rw("samples", &ImageMetadata::samples)
        .def_rw("camera", &ImageMetadata::camera)
        .def_rw("pixelAspectRatio", &ImageMetadata::pixelAspectRatio)
        .def_rw("worldToCamera", &ImageMetadata::worldToCamera)
        .def_rw("worldToNdc", &ImageMetadata::worldToNdc)
        .def_rw("texts", &ImageMetadata::texts)
        .def_rw("dataWindowMin", &ImageMetadata::dataWindowMin)
        .def_rw("displayWindowSize", &ImageMetadata::displayWindowSize)
        .def_rw("framesPerSecond", &ImageMetadata::framesPerSecond)
        .def_rw("frameNumber", &ImageMetadata::frameNumber)
        .def_rw("workingSpace", &ImageMetadata::workingSpace)
        .def_rw("tileSize", &ImageMetadata::tileSize);

    module.def("MakeImageMetadata", &MakeImageMetadata, "settings"_a, "camera"_a,
               "Samples, camera, matrices and windows of a render.");
    module.def("CheckImageFile", &CheckImageFile, "file"_a, "aovs"_a = std::vector<std::string>(),
               "Raises Error unless an image, of those AOVs, can be written to the file.");
    module.def(
        "WriteImage",
        [](const std::string& file, const std::vector<ImageLayer>& layers,
           const std::string& colorCorrection, const ImageMetadata& metadata,
           const std::map<std::string, std::string>& aovs) {
            ImageWriteOptions options;
            options.colorCorrection = ParseColorCorrection(colorCorrection);
            options.metadata = metadata;
            options.aovs = aovs;
            return WriteImage(file, layers, options);
        },
        ReleaseGil(), "file"_a, "layers"_a, "colorCorrection"_a = "",
        "metadata"_a = ImageMetadata(), "aovs"_a = std::map<std::string, std::string>(),
        "Writes layers; returns those that the format cannot hold. aovs: AOVs of layers that the "
        "file has under other names, by these.");

    module.def("IsWorkingSpace", &IsWorkingSpace, "name"_a,
               "Whether the setting workingSpace takes a name.");
    module.def(
        "FindColorConfigSources",
        [] {
            ColorConfigSources sources = FindColorConfigSources();
            return std::make_pair(std::move(sources.files), std::move(sources.words));
        },
        "(files, words) that the colour configuration in force is made of: its own file and those "
        "of its tables; $OCIO where it is no file, and what its transforms name. Raises Error "
        "where $OCIO cannot be read.");
    module.def("RefreshColorConfig", &RefreshColorConfig, ReleaseGil(),
               "Has the colour configuration loaded again where a file of it has changed.");
    module.def("AddDenoiserLibrary", &AddDenoiserLibrary, "file"_a,
               "A file of Open Image Denoise that is tried before the system's.");
    module.def("CheckDenoiser", &CheckDenoiser, ReleaseGil(),
               "Raises Error unless pictures can be denoised.");

    nb::class_<AovInfo>(module, "AovInfo", "An AOV that a render can write.")
        .def_ro("name", &AovInfo::name)
        .def_ro("channels", &AovInfo::channels)
        .def_ro("description", &AovInfo::description);
    module.def("AovTable", &AovTable, "All AOVs.");
    module.def("LayersOf", &LayersOf, "name"_a,
               "Names of the layers that an AOV's name stands for.");
    module.def("AovOfSource", &AovOfSource, "sourceName"_a,
               "The AOV that the source name of a render var (raw, intrinsic) means; empty: none.");
    module.def("HasAov", &HasAov, "name"_a, "Whether a render can write an AOV of that name.");
    module.def(
        "ChannelsOf",
        [](const std::string& name) { return MakeAovLayout({name}).slots.front().info->channels; },
        "name"_a, "Channels of an AOV or of its layers.");
    module.def("IsSummed", &IsSummed, "name"_a,
               "Whether samples of that AOV add up in the sums of a film, beside those of colour.");
    module.def("CheckAovs", &CheckAovs, "names"_a,
               "Raises UsageError for a list of AOVs that no render can have.");
}

constexpr std::size_t kMatteWords = sizeof(MatteCount) / sizeof(std::uint32_t);
static_assert(kMatteWords == 5);

using MatteWords = nb::ndarray<const std::uint32_t, nb::ndim<2>, nb::c_contig>;

constexpr std::size_t kFilmWords = sizeof(shared::HdsFilmPixel) / sizeof(std::uint32_t);

/// A copy of an array [height][width][kFilmWords]; one of no pixels: a film without samples.
FilmSums FilmSumsFromWords(std::uint32_t width, std::uint32_t height, std::uint32_t firstSample,
                           std::uint32_t endSample,
                           const nb::ndarray<const std::uint32_t, nb::ndim<3>, nb::c_contig>& words,
                           const std::optional<MatteWords>& mattes) {
    FilmSums sums;
    sums.width = width;
    sums.height = height;
    sums.firstSample = firstSample;
    sums.endSample = endSample;
    if (mattes) {
        if (mattes->shape(1) != kMatteWords) {
            throw nb::value_error("the array of mattes is not [counts][5]");
        }
        sums.hasMattes = true;
        sums.mattes.resize(mattes->shape(0));
        if (mattes->size() > 0) {
            std::memcpy(static_cast<void*>(sums.mattes.data()), mattes->data(),
                        mattes->size() * sizeof(std::uint32_t));
        }
    }
    if (words.size() > 0) {
        if (words.shape(0) != height || words.shape(1) != width || words.shape(2) != kFilmWords) {
            throw nb::value_error("the array is not [height][width] pixels of a film");
        }
        sums.pixels.resize(std::size_t{width} * height);
        std::memcpy(sums.pixels.data(), words.data(), words.size() * sizeof(std::uint32_t));
    }
    return sums;
}

constexpr std::size_t kLightPathWords = sizeof(shared::HdsLightPathPixel) / sizeof(std::uint32_t);

void SetLightPaths(FilmSums& sums, std::vector<std::string> expressions,
                   const nb::ndarray<const std::uint32_t, nb::ndim<4>, nb::c_contig>& words) {
    const std::size_t numPixels = sums.pixels.size() * expressions.size();
    if (words.size() != numPixels * kLightPathWords) {
        throw nb::value_error("the array is not [expressions][height][width] pixels");
    }
    sums.lightPaths = std::move(expressions);
    sums.lightPathPixels.resize(numPixels);
    if (numPixels > 0) {
        std::memcpy(static_cast<void*>(sums.lightPathPixels.data()), words.data(),
                    words.size() * sizeof(std::uint32_t));
    }
}

void BindFilmSums(nb::module_& module) {
    nb::class_<FilmSums>(module, "FilmSums", "Sums of a range of samples of all pixels.")
        .def(
            "__init__",
            [](FilmSums* self, std::uint32_t width, std::uint32_t height, std::uint32_t firstSample,
               std::uint32_t endSample,
               const nb::ndarray<const std::uint32_t, nb::ndim<3>, nb::c_contig>& words,
               const std::optional<MatteWords>& mattes) {
                new (self) FilmSums(
                    FilmSumsFromWords(width, height, firstSample, endSample, words, mattes));
            },
            "width"_a, "height"_a, "firstSample"_a, "endSample"_a, "words"_a,
            "mattes"_a = nb::none())
        .def_ro("width", &FilmSums::width)
        .def_ro("height", &FilmSums::height)
        .def_ro("firstSample", &FilmSums::firstSample)
        .def_ro("endSample", &FilmSums::endSample)
        .def_ro("lightPaths", &FilmSums::lightPaths)
        .def("SetLightPaths", &SetLightPaths, "expressions"_a, "words"_a,
             "Sums of light path expressions, as lightPathWords has them.")
        .def_prop_ro(
            "lightPathWords",
            [](nb::handle self) {
                const auto& sums = nb::cast<const FilmSums&>(self);
                const bool isBlack = sums.pixels.empty();
                const std::size_t shape[4] = {sums.lightPaths.size(), isBlack ? 0 : sums.height,
                                              sums.width, kLightPathWords};
                return nb::cast(nb::ndarray<nb::numpy, const std::uint32_t>(
                    reinterpret_cast<const std::uint32_t*>(sums.lightPathPixels.data()), 4, shape,
                    self));
            },
            "Sums of light path expressions, uint32 [expressions][height][width][words].")
        .def("MostSamples", &FilmSums::MostSamples)
        .def_prop_ro(
            "words",
            [](nb::handle self) {
                const auto& sums = nb::cast<const FilmSums&>(self);
                const bool isBlack = sums.pixels.empty();
                const std::size_t shape[3] = {isBlack ? 0 : sums.height, sums.width, kFilmWords};
                return nb::cast(nb::ndarray<nb::numpy, const std::uint32_t>(
                    reinterpret_cast<const std::uint32_t*>(sums.pixels.data()), 3, shape, self));
            },
            "The film's memory, uint32 [height][width][words]; no rows without samples.")
        .def_prop_ro(
            "mattes",
            [](nb::handle self) -> nb::object {
                const auto& sums = nb::cast<const FilmSums&>(self);
                if (!sums.hasMattes) {
                    return nb::none();
                }
                const std::size_t shape[2] = {sums.mattes.size(), kMatteWords};
                return nb::cast(nb::ndarray<nb::numpy, const std::uint32_t>(
                    reinterpret_cast<const std::uint32_t*>(sums.mattes.data()), 2, shape, self));
            },
            "Counts for a Cryptomatte, uint32 [counts][5]: pixel, prim, material entry, instance, "
            "samples; None: they were not asked for.");
    module.attr("SAMPLE_BLOCK") = HDS_SAMPLE_BLOCK;
}

void BindDeepImages(nb::module_& module) {
    nb::class_<DeepImage>(module, "DeepImage", "A deep picture.")
        .def_ro("width", &DeepImage::width)
        .def_ro("height", &DeepImage::height)
        .def_prop_ro(
            "counts",
            [](nb::handle self) {
                const auto& image = nb::cast<const DeepImage&>(self);
                const std::size_t shape[2] = {image.height, image.width};
                return nb::cast(nb::ndarray<nb::numpy, const std::uint32_t>(image.counts.data(), 2,
                                                                            shape, self));
            },
            "Samples by pixel, uint32 [height][width].")
        .def_prop_ro(
            "samples",
            [](nb::handle self) {
                const auto& image = nb::cast<const DeepImage&>(self);
                constexpr std::size_t kFloats = sizeof(DeepSample) / sizeof(float);
                static_assert(kFloats == 6);
                const std::size_t shape[2] = {image.samples.size(), kFloats};
                return nb::cast(nb::ndarray<nb::numpy, const float>(
                    reinterpret_cast<const float*>(image.samples.data()), 2, shape, self));
            },
            "All samples, pixel by pixel, from front to back: float32 [samples][6], Z, ZBack, R, "
            "G, B, A.");
    module.def("WriteDeepImage", &WriteDeepImage, ReleaseGil(), "file"_a, "image"_a, "isHalf"_a,
               "metadata"_a, "Writes a deep EXR.");
}

void BindComparing(nb::module_& module) {
    nb::class_<LayerDifference>(module, "LayerDifference", "Difference of one layer.")
        .def_ro("name", &LayerDifference::name)
        .def_ro("maxAbs", &LayerDifference::maxAbs)
        .def_ro("rmse", &LayerDifference::rmse)
        .def_ro("relMse", &LayerDifference::relMse)
        .def_ro("psnr", &LayerDifference::psnr)
        .def_ro("numPixels", &LayerDifference::numPixels)
        .def_ro("numDifferingPixels", &LayerDifference::numDifferingPixels)
        .def_ro("numNonFinite", &LayerDifference::numNonFinite);
    nb::class_<ImageComparison>(module, "ImageComparison", "Difference of two image files.")
        .def_ro("error", &ImageComparison::error)
        .def_ro("width", &ImageComparison::width)
        .def_ro("height", &ImageComparison::height)
        .def_ro("layers", &ImageComparison::layers)
        .def("IsAbove", &ImageComparison::IsAbove, "threshold"_a);
    module.def("CompareImages", &CompareImages, ReleaseGil(), "file"_a, "referenceFile"_a);
}

} // namespace

void BindImages(nb::module_& module) {
    BindWriting(module);
    BindFilmSums(module);
    BindDeepImages(module);
    BindComparing(module);
}

} // namespace hds::python
