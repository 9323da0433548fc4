// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/imageChannel.h"

#include "hdStream/texture/textureBuild.h"
#include "hdStream/texture/textureForm.h"
#include "hdStream/texture/textureRows.h"

#include <exception>
#include <memory>
#include <new>

namespace hds {

namespace {

/// Reads the rows of an open image. \return an error or empty
std::string ReadChannel(ImageFile* file, const std::string& colorSpace, std::uint32_t channel,
                        ImageChannel* result) {
    TextureRequest request;
    request.colorSpace = colorSpace;
    const ColorDecoder decoder(colorSpace, file->Spec(), &result->warning);
    TextureForm form = ChooseTextureForm(*file, decoder, request);
    std::string error = ChooseForm(file, decoder, &form);
    if (!error.empty()) {
        return error;
    }
    result->width = file->Width();
    result->height = file->Height();
    result->values.reserve(std::size_t{result->width} * result->height);
    // The component of a decoded texel that the output is; what is not stored is 0, 0, 0, 1.
    const std::uint32_t component = form.swizzle >> (2 * channel) & 3U;
    const std::uint32_t stored = 1U << (form.format & HDS_TEXEL_CHANNELS_LOG2_MASK);
    const float missing = component == 3 ? 1.0F : 0.0F;
    const auto addRow = [&](const std::uint8_t*, const float* linear) {
        for (std::size_t i = 0; i < result->width; ++i) {
            result->values.push_back(component < stored ? linear[i * stored + component] : missing);
        }
    };
    TexelRepairs repairs;
    error = TextureRows(file, &decoder, form).Read(addRow, &repairs);
    if (result->warning.empty()) {
        result->warning = WarningOf(repairs);
    }
    return error;
}

} // namespace

ImageChannel LoadImageChannel(const ImageSource& source, const std::string& colorSpace,
                              std::uint32_t channel) {
    ImageChannel result;
    const std::unique_ptr<ImageFile> file = ImageFile::Open(source, &result.error);
    if (!file) {
        return result;
    }
    try {
        result.error = ReadChannel(file.get(), colorSpace, channel, &result);
    } catch (const std::bad_alloc&) {
        result.error = file->Name() + ": there is not enough memory to load it";
    } catch (const std::exception& failure) {
        result.error = file->Name() + ": " + failure.what();
    }
    if (!result.warning.empty()) {
        result.warning = file->Name() + ": " + result.warning;
    }
    if (!result.error.empty()) {
        result.values.clear();
    }
    return result;
}

} // namespace hds
