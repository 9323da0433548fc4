// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/texturePreparer.h"

#include "hdStream/texture/keptImage.h"
#include "hdStream/texture/textureBuild.h"

#include <algorithm>

namespace hds {

namespace {

/// Times that a file which is written to while it is read is read again.
constexpr int kMaxTries = 3;

/// What lines of a texture are made of later.
struct Origin {
    ImageSource source;
    TextureRequest request;
    PageKey key;
    shared::HdsTexture record;
    std::shared_ptr<PageStore> store;
    std::shared_ptr<LineStore> lines;
    std::shared_ptr<KeptImages> images;
};

/// Makes missing lines; null when they are not kept and the file is not the same any more.
std::shared_ptr<const LineStore> MakeLines(const Origin& origin,
                                           const std::vector<std::uint32_t>& missing) {
    if (const std::shared_ptr<const KeptImage> image = origin.images->Find(origin.key)) {
        origin.lines->BeginFilling(missing);
        image->FillLines(origin.record, origin.lines.get());
        return origin.lines;
    }
    if (TextureKey(origin.source, origin.request) != origin.key) {
        return nullptr;
    }
    std::shared_ptr<const LineStore> made = origin.lines;
    std::string error;
    if ((origin.record.flags & HDS_TEXTURE_CONSTANT) != 0) {
        BuiltTexture built =
            BuildTexture(origin.source, origin.request, origin.store, origin.key, {});
        made = built.lines;
        error = built.description.error;
    } else {
        error = BuildLines(origin.source, origin.request, origin.record,
                           *std::min_element(missing.begin(), missing.end()), origin.lines.get());
    }
    const bool isSame = TextureKey(origin.source, origin.request) == origin.key;
    return error.empty() && isSame ? made : nullptr;
}

} // namespace

TexturePreparer::TexturePreparer(std::shared_ptr<PageStore> store, Warnings* warnings,
                                 std::uint64_t keptBytes)
    : _store(std::move(store)), _warnings(warnings), _keptBytes(keptBytes),
      _kept(std::make_shared<KeptImages>(keptBytes)) {}

void TexturePreparer::Report(const TextureDescription& description) const {
    for (const std::string* line : {&description.error, &description.warning}) {
        if (_warnings != nullptr && !line->empty()) {
            _warnings->Add("", *line);
        }
    }
}

std::shared_ptr<const PreparedTexture> TexturePreparer::Prepare(const ImageSource& source,
                                                                const TextureRequest& request,
                                                                std::uint64_t texelsAtOnce) {
    std::optional<PageKey> key = TextureKey(source, request);
    std::shared_ptr<Slot> slot = std::make_shared<Slot>();
    if (key) {
        const std::lock_guard<std::mutex> lock(_mutex);
        slot = _slots.emplace(*key, slot).first->second;
    }
    const std::lock_guard<std::mutex> lock(slot->mutex);
    if (std::shared_ptr<const PreparedTexture> known = slot->texture.lock()) {
        return known;
    }
    BuiltTexture result;
    std::optional<TextureDescription> kept;
    if (key && _store) {
        kept = LoadDescription(_store.get(), *key);
    }
    if (kept) {
        result.lines = std::make_shared<LineStore>(_store, *key, kept->record.numLines);
        result.description = std::move(*kept);
    } else {
        bool isStable = false;
        for (int i = 0; i < kMaxTries && !isStable; ++i) {
            // What is read of a file that changes meanwhile must not be kept under its old key.
            const std::optional<PageKey> before = TextureKey(source, request);
            // Nor can any more be made of it later.
            const bool isLast = i + 1 == kMaxTries;
            const bool isAll = !before || isLast;
            result = BuildTexture(source, request, before && !isLast ? _store : nullptr,
                                  before.value_or(PageKey()),
                                  isAll ? BuildExtent() : BuildExtent{texelsAtOnce, _keptBytes});
            isStable = TextureKey(source, request) == before;
            if (!isStable && result.lines) {
                result.lines->ForgetSaved();
            }
            key = before;
        }
        if (isStable && result.image) {
            _kept->Add(*key, result.image);
        }
        _numBuilt.fetch_add(1, std::memory_order_relaxed);
        // Only beside lines that are all in the store: else the next process would find no lines.
        if (key && _store && isStable && result.description.error.empty() &&
            result.lines->HostBytes() == 0) {
            SaveDescription(_store.get(), *key, result.description);
        }
    }
    Report(result.description);
    PreparedTexture::Make make;
    if (key && result.description.error.empty()) {
        Origin origin{source, request,      *key, result.description.record,
                      _store, result.lines, _kept};
        make = [origin = std::move(origin),
                warnings = _warnings](const std::vector<std::uint32_t>& missing) {
            auto made = MakeLines(origin, missing);
            if (!made && warnings != nullptr) {
                const std::string& name = origin.source.name;
                warnings->Add(name.empty() ? origin.source.file : name,
                              "finer mips cannot be made: the file is not the same any more");
            }
            return made;
        };
    }
    auto texture = std::make_shared<const PreparedTexture>(
        std::move(result.description), std::move(result.lines), std::move(make));
    slot->texture = texture;
    return texture;
}

std::optional<shared::HdsTexture> TexturePreparer::Estimate(const ImageSource& source,
                                                            const TextureRequest& request) {
    std::string ignored;
    const std::unique_ptr<ImageFile> file = ImageFile::OpenHeader(source, &ignored);
    if (!file) {
        return std::nullopt;
    }
    const ColorDecoder decoder(request.colorSpace, file->Spec(), &ignored);
    TextureForm form = ChooseTextureForm(*file, decoder, request);
    if (form.dependsOnRange) {
        form.format = (form.format & ~HDS_TEXEL_TYPE_MASK) | HDS_TEXEL_HALF;
    }
    return RecordOf(*file, form, &ignored);
}

} // namespace hds
