// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/plainTexture.h"

#include "hdStream/texture/halvingFilter.h"
#include "hdStream/texture/textureBuild.h"
#include "hdStream/texture/textureLayout.h"
#include "hdStream/texture/textureRows.h"

#include <algorithm>
#include <exception>
#include <functional>
#include <memory>
#include <new>

namespace hds {

namespace {

constexpr std::uint64_t kUnitBytes = 16;

/// Mips that fill as rows arrive; each level hands its rows on to the next level's filter.
class PlainChain {
public:
    explicit PlainChain(PlainTexture* texture)
        : _record(texture->record), _texels(texture->texels), _converter(_record.format),
          _texelBytes(TexelBytes(_record.format)) {
        const std::uint32_t channels = 1U << (_record.format & HDS_TEXEL_CHANNELS_LOG2_MASK);
        std::uint64_t units = 0;
        for (std::uint32_t mip = 0; mip < _record.numMips; ++mip) {
            const std::uint32_t width = shared::texture_mipSize(_record.width, mip);
            const std::uint32_t height = shared::texture_mipSize(_record.height, mip);
            texture->record.mipBlock[mip] = static_cast<std::uint32_t>(units);
            _levels.push_back(
                {width, units * kUnitBytes, 0, HalvingFilter(width, height, channels)});
            const std::uint64_t bytes = std::uint64_t{width} * height * _texelBytes;
            units += (bytes + kUnitBytes - 1) / kUnitBytes;
        }
        _texels.resize(units * kUnitBytes);
    }

    /// Takes the next row of a mip. \param stored null: `linear` has to be converted
    void AddRow(std::size_t mip, const std::uint8_t* stored, const float* linear) {
        Level& level = _levels[mip];
        const std::uint64_t rowBytes = std::uint64_t{level.width} * _texelBytes;
        std::uint8_t* to = &_texels[level.offset + level.nextRow++ * rowBytes];
        if (stored != nullptr) {
            std::copy_n(stored, rowBytes, to);
        } else {
            _converter.Convert(linear, level.width, to);
        }
        if (mip + 1 < _levels.size()) {
            if (const float* next = level.toNext.AddRow(linear)) {
                AddRow(mip + 1, nullptr, next);
            }
        }
    }

private:
    struct Level {
        std::uint32_t width;
        std::uint64_t offset; ///< bytes
        std::uint64_t nextRow;
        HalvingFilter toNext;
    };

    const shared::HdsTexture& _record;
    std::vector<std::uint8_t>& _texels;
    TexelConverter _converter;
    std::uint32_t _texelBytes;
    std::vector<Level> _levels;
};

/// What is read of a file, and a consumer of its rows.
using BeginRows = std::function<TextureRows::RowsCallback(const ImageFile&, const TextureForm&)>;

/// Reads an image as rows. \return an error or empty
std::string ReadRows(const ImageSource& source, const TextureRequest& request, std::string* warning,
                     const BeginRows& begin) {
    std::string error;
    const std::unique_ptr<ImageFile> file = ImageFile::Open(source, &error);
    if (!file) {
        return error;
    }
    try {
        const ColorDecoder decoder(request.colorSpace, file->Spec(), warning);
        TextureForm form = ChooseTextureForm(*file, decoder, request);
        error = ChooseForm(file.get(), decoder, &form);
        if (error.empty()) {
            TexelRepairs repairs;
            error = TextureRows(file.get(), &decoder, form).Read(begin(*file, form), &repairs);
            *warning = warning->empty() ? WarningOf(repairs) : *warning;
        }
    } catch (const std::bad_alloc&) {
        error = file->Name() + ": there is not enough memory to load it";
    } catch (const std::exception& failure) {
        error = file->Name() + ": " + failure.what();
    }
    if (!warning->empty()) {
        *warning = file->Name() + ": " + *warning;
    }
    return error;
}

} // namespace

PlainTexture LoadPlainTexture(const ImageSource& source, const TextureRequest& request) {
    PlainTexture texture;
    std::unique_ptr<PlainChain> chain;
    std::string tooLarge;
    texture.error = ReadRows(
        source, request, &texture.warning, [&](const ImageFile& file, const TextureForm& form) {
            if (const auto record = RecordOf(file, form, &tooLarge)) {
                texture.record = *record;
                chain = std::make_unique<PlainChain>(&texture);
            }
            return [&](std::uint32_t numRows, const std::uint8_t* stored, const float* linear) {
                if (!chain) {
                    return;
                }
                const std::size_t width = texture.record.width;
                const std::size_t texelBytes = TexelBytes(texture.record.format);
                const std::uint32_t channelsLog2 =
                    texture.record.format & HDS_TEXEL_CHANNELS_LOG2_MASK;
                for (std::size_t row = 0; row < numRows; ++row) {
                    chain->AddRow(0, stored + row * width * texelBytes,
                                  linear + (row * width << channelsLog2));
                }
            };
        });
    texture.error = texture.error.empty() ? tooLarge : texture.error;
    if (!texture.error.empty()) {
        texture.record = MakeTextureLayout(1, 1, HDS_TEXEL_U8);
        texture.record.flags = HDS_TEXTURE_MISSING;
        texture.texels.clear();
    }
    return texture;
}

PlainChannel LoadPlainChannel(const ImageSource& source, const std::string& colorSpace,
                              std::uint32_t channel) {
    PlainChannel result;
    TextureRequest request;
    request.colorSpace = colorSpace;
    result.error = ReadRows(
        source, request, &result.warning, [&](const ImageFile& file, const TextureForm& form) {
            result.width = file.Width();
            result.height = file.Height();
            result.values.reserve(std::size_t{result.width} * result.height);
            // The component of a decoded texel that the output is; what is not stored is 0, 0,
            // 0, 1.
            const std::uint32_t component = form.swizzle >> (2 * channel) & 3U;
            const std::uint32_t stored = 1U << (form.format & HDS_TEXEL_CHANNELS_LOG2_MASK);
            return [&result, component, stored](std::uint32_t numRows, const std::uint8_t*,
                                                const float* linear) {
                const std::size_t count = std::size_t{numRows} * result.width;
                for (std::size_t i = 0; i < count; ++i) {
                    const float missing = component == 3 ? 1.0F : 0.0F;
                    result.values.push_back(component < stored ? linear[i * stored + component]
                                                               : missing);
                }
            };
        });
    if (!result.error.empty()) {
        result.values.clear();
    }
    return result;
}

} // namespace hds
