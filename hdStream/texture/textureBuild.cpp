// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/textureBuild.h"

#include "hdStream/base/fieldHash.h"
#include "hdStream/persist/fileIdentity.h"
#include "hdStream/texture/blockEncoder.h"
#include "hdStream/texture/colorConversion.h"
#include "hdStream/texture/mipChain.h"
#include "hdStream/texture/textureLayout.h"
#include "hdStream/texture/textureRows.h"

#include <algorithm>
#include <cstring>
#include <new>

namespace hds {

namespace {

/// Bump when preparation gives other bytes for the same file.
constexpr std::uint64_t kTextureVersion = 5;

bool IsNamedSpace(const std::string& space) {
    return !space.empty() && space != "raw" && space != "sRGB" && space != "auto";
}

/// Passes rows on to a mip chain from the first one on that is not of one colour: an image of one
/// colour never makes a chain.
class ConstantFilter {
public:
    ConstantFilter(const shared::HdsTexture& record, LineStore* lines)
        : _record(record), _lines(lines), _texelBytes(TexelBytes(record.format)),
          _rowValues(std::size_t{record.width} << (record.format & HDS_TEXEL_CHANNELS_LOG2_MASK)) {}

    void AddRow(const std::uint8_t* stored, const float* linear) {
        if (_first.empty()) {
            _first.assign(stored, stored + _texelBytes);
            _firstLinear.assign(linear, linear + _rowValues / _record.width);
        }
        if (!_chain && IsFirstEverywhere(stored)) {
            ++_numConstantRows;
            return;
        }
        if (!_chain) {
            StartChain();
        }
        _chain->AddRow(stored, linear);
    }

    const MipChain* Chain() const { return _chain.get(); }
    bool ReadsStored() const { return !_chain || _chain->ReadsStored(); }
    void Finish() { _chain->Finish(); }
    /// The texel that all are.
    const std::vector<std::uint8_t>& First() const { return _first; }

private:
    bool IsFirstEverywhere(const std::uint8_t* stored) const {
        return std::equal(_first.begin(), _first.end(), stored) &&
               std::memcmp(stored, stored + _texelBytes, (_record.width - 1) * _texelBytes) == 0;
    }

    void StartChain() {
        _chain = std::make_unique<MipChain>(_record, _lines);
        std::vector<std::uint8_t> stored;
        std::vector<float> linear;
        for (std::uint32_t x = 0; x < _record.width; ++x) {
            stored.insert(stored.end(), _first.begin(), _first.end());
            linear.insert(linear.end(), _firstLinear.begin(), _firstLinear.end());
        }
        for (std::uint64_t row = 0; row < _numConstantRows; ++row) {
            _chain->AddRow(stored.data(), linear.data());
        }
    }

    shared::HdsTexture _record;
    LineStore* _lines;
    std::size_t _texelBytes;
    std::size_t _rowValues;
    std::vector<std::uint8_t> _first;
    std::vector<float> _firstLinear;
    std::uint64_t _numConstantRows = 0;
    std::unique_ptr<MipChain> _chain;
};

std::shared_ptr<LineStore> MakeConstantLines(std::uint32_t format,
                                             const std::vector<std::uint8_t>& texel,
                                             const std::shared_ptr<PageStore>& store,
                                             const PageKey& key) {
    auto lines = std::make_shared<LineStore>(store, key, 1);
    std::vector<std::uint8_t> texels;
    for (int i = 0; i < 16; ++i) {
        texels.insert(texels.end(), texel.begin(), texel.end());
    }
    EncodeBlock(format, texels.data(), lines->Open(0)->data());
    lines->Complete(0, 1);
    return lines;
}

/// One line that names the file.
std::string ErrorOf(const ImageSource& source, const std::exception& failure) {
    const std::string reason = dynamic_cast<const std::bad_alloc*>(&failure) != nullptr
                                   ? "there is not enough memory to prepare it"
                                   : failure.what();
    return (source.name.empty() ? source.file : source.name) + ": " + reason;
}

std::string Named(const ImageFile& file, const std::string& warning) {
    return warning.empty() ? warning : file.Name() + ": " + warning;
}

/// The finest mip of at most so many texels, or the coarsest.
std::uint32_t MipOfTexels(const shared::HdsTexture& record, std::uint64_t maxTexels) {
    std::uint32_t mip = 0;
    while (mip + 1 < record.numMips && std::uint64_t{shared::texture_mipSize(record.width, mip)} *
                                               shared::texture_mipSize(record.height, mip) >
                                           maxTexels) {
        ++mip;
    }
    return mip;
}

BuiltTexture Build(const ImageSource& source, const TextureRequest& request,
                   const std::shared_ptr<PageStore>& store, const PageKey& key,
                   const BuildExtent& extent) {
    std::string error;
    const std::unique_ptr<ImageFile> file = ImageFile::Open(source, &error);
    if (!file) {
        return MakeMissingTexture(error);
    }
    BuiltTexture built;
    TextureDescription& description = built.description;
    const ColorDecoder decoder(request.colorSpace, file->Spec(), &description.warning);
    TextureForm form = ChooseTextureForm(*file, decoder, request);
    error = ChooseForm(file.get(), decoder, &form);
    const auto record = error.empty() ? RecordOf(*file, form, &error) : std::nullopt;
    if (!record) {
        return MakeMissingTexture(error);
    }
    description.record = *record;
    description.info = DescribeImage(*file);
    built.lines = std::make_shared<LineStore>(store, key, record->numLines);
    const std::uint32_t finest = MipOfTexels(*record, extent.maxTexels);
    built.lines->BeginFilling(FirstLineOf(*record, finest));
    ConstantFilter rows(*record, built.lines.get());
    TexelRepairs repairs;
    TextureRows reader(file.get(), &decoder, form);
    built.image = finest > 0 ? reader.Keep(extent.maxKeptBytes) : nullptr;
    error = reader.Read(
        [&](const std::uint8_t* stored, const float* linear) {
            rows.AddRow(stored, linear);
            if (!rows.ReadsStored()) {
                reader.LeaveOutStored();
            }
        },
        &repairs);
    if (!error.empty()) {
        return MakeMissingTexture(error);
    }
    if (rows.Chain() != nullptr) {
        rows.Finish();
    } else {
        MakeConstant(&description.record);
        built.image.reset();
        built.lines = MakeConstantLines(record->format, rows.First(), store, key);
    }
    description.numNonFinite = repairs.numNonFinite;
    description.numClamped = repairs.numClamped;
    if (description.warning.empty()) {
        description.warning = WarningOf(repairs);
    }
    description.warning = Named(*file, description.warning);
    return built;
}

} // namespace

std::optional<PageKey> TextureKey(const ImageSource& source, const TextureRequest& request) {
    Hasher hasher;
    hasher.Append("texture");
    hasher.Append(kTextureVersion);
    if (!AppendFileIdentity(&hasher, source.file, source.offset, source.size)) {
        return std::nullopt;
    }
    // The extension chooses the reader where the content does not, and it is the name's.
    hasher.Append(source.name);
    TextureRequest asked = request;
    asked.colorSpace = request.colorSpace.empty() ? "auto" : request.colorSpace;
    FieldHasher(&hasher).Add(asked);
    if (IsNamedSpace(request.colorSpace)) {
        try {
            hasher.Append(ColorConfigIdentity());
        } catch (const std::exception&) {
            return std::nullopt;
        }
    }
    return MakePageKey(hasher);
}

std::optional<shared::HdsTexture> RecordOf(const ImageFile& file, const TextureForm& form,
                                           std::string* error) {
    if (std::max(file.Width(), file.Height()) > HDS_TEXTURE_MAX_SIZE) {
        *error = file.Name() + ": " + std::to_string(file.Width()) + "x" +
                 std::to_string(file.Height()) + " is too large for a texture (" +
                 std::to_string(HDS_TEXTURE_MAX_SIZE) + " texels a side)";
        return std::nullopt;
    }
    shared::HdsTexture record = MakeTextureLayout(file.Width(), file.Height(), form.format);
    record.swizzle = form.swizzle;
    return record;
}

BuiltTexture MakeMissingTexture(const std::string& error) {
    constexpr std::uint32_t kFormat = HDS_TEXEL_U8 | 2u;
    BuiltTexture built;
    built.description.error = error;
    built.description.info.error = error;
    built.description.record = MakeTextureLayout(1, 1, kFormat);
    MakeConstant(&built.description.record);
    built.description.record.flags |= HDS_TEXTURE_MISSING;
    built.lines = MakeConstantLines(kFormat, {0, 0, 0, 255}, nullptr, {});
    return built;
}

BuiltTexture BuildTexture(const ImageSource& source, const TextureRequest& request,
                          const std::shared_ptr<PageStore>& store, const PageKey& key,
                          const BuildExtent& extent) {
    try {
        return Build(source, request, store, key, extent);
    } catch (const std::exception& failure) {
        return MakeMissingTexture(ErrorOf(source, failure));
    }
}

std::string BuildLines(const ImageSource& source, const TextureRequest& request,
                       const shared::HdsTexture& record, std::uint32_t line, LineStore* lines) {
    try {
        std::string error;
        const std::unique_ptr<ImageFile> file = ImageFile::Open(source, &error);
        if (!file) {
            return error;
        }
        const ColorDecoder decoder(request.colorSpace, file->Spec(), &error);
        TextureForm form = ChooseTextureForm(*file, decoder, request);
        form.format = record.format;
        form.dependsOnRange = false;
        lines->BeginFilling(FirstLineOf(record, MipOfLine(record, line)));
        MipChain chain(record, lines);
        TexelRepairs ignored;
        TextureRows reader(file.get(), &decoder, form);
        if (!chain.ReadsStored()) {
            reader.LeaveOutStored();
        }
        error = reader.Read(
            [&](const std::uint8_t* stored, const float* linear) { chain.AddRow(stored, linear); },
            &ignored);
        if (error.empty()) {
            chain.Finish();
        }
        return error;
    } catch (const std::exception& failure) {
        return ErrorOf(source, failure);
    }
}

} // namespace hds
