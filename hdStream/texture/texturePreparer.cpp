// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/texturePreparer.h"

#include "hdStream/texture/textureBuild.h"

namespace hds {

namespace {

/// Times that a file which is written to while it is read is read again.
constexpr int kMaxTries = 3;

/// Lines of a texture whose description is known, read from its file again; empty when that is not
/// the same file any more.
std::shared_ptr<const LineStore> RestoreLines(const ImageSource& source,
                                              const TextureRequest& request,
                                              const std::shared_ptr<PageStore>& store,
                                              const PageKey& key, Warnings* warnings) {
    if (TextureKey(source, request) == key) {
        BuiltTexture built = BuildTexture(source, request, store, key);
        if (built.description.error.empty() && TextureKey(source, request) == key) {
            return built.lines;
        }
    }
    if (warnings != nullptr) {
        const std::string& name = source.name.empty() ? source.file : source.name;
        warnings->Add(name,
                      "the prepared texture is damaged, and the file is not the same any more");
    }
    return nullptr;
}

} // namespace

TexturePreparer::TexturePreparer(std::shared_ptr<PageStore> store, Warnings* warnings)
    : _store(std::move(store)), _warnings(warnings) {}

void TexturePreparer::Report(const TextureDescription& description) const {
    for (const std::string* line : {&description.error, &description.warning}) {
        if (_warnings != nullptr && !line->empty()) {
            _warnings->Add("", *line);
        }
    }
}

std::shared_ptr<const PreparedTexture> TexturePreparer::Prepare(const ImageSource& source,
                                                                const TextureRequest& request) {
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
            result = BuildTexture(source, request, before ? _store : nullptr,
                                  before.value_or(PageKey()));
            isStable = TextureKey(source, request) == before;
            key = before;
        }
        _numBuilt.fetch_add(1, std::memory_order_relaxed);
        // Only beside lines that are all in the store: else the next process would find no lines.
        if (key && _store && isStable && result.description.error.empty() &&
            result.lines->HostBytes() == 0) {
            SaveDescription(_store.get(), *key, result.description);
        }
    }
    Report(result.description);
    PreparedTexture::Restore restore;
    if (key && result.description.error.empty()) {
        restore = [source, request, store = _store, textureKey = *key, warnings = _warnings] {
            return RestoreLines(source, request, store, textureKey, warnings);
        };
    }
    auto texture = std::make_shared<const PreparedTexture>(
        std::move(result.description), std::move(result.lines), std::move(restore));
    slot->texture = texture;
    return texture;
}

std::optional<shared::HdsTexture> TexturePreparer::Estimate(const ImageSource& source,
                                                            const TextureRequest& request) {
    std::string ignored;
    const std::unique_ptr<ImageFile> file = ImageFile::Open(source, &ignored);
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
