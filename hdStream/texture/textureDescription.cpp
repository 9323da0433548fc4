// SPDX-License-Identifier: Apache-2.0
// A texture's description, and the header of an image, as pages.
#include "hdStream/texture/textureBuild.h"

#include "hdStream/persist/pageBytes.h"

namespace hds {

namespace {

/// The key of what is kept of a texture besides its lines.
PageKey KeyFrom(const char* kind, const PageKey& texture) {
    Hasher hasher;
    hasher.Append(kind);
    hasher.Append(texture.words[0]);
    hasher.Append(texture.words[1]);
    return MakePageKey(hasher);
}

PageKey DescriptionKey(const PageKey& key) {
    return KeyFrom("description", key);
}

void AddInfo(PageWriter* page, const ImageInfo& info) {
    page->Add(std::uint64_t{info.width});
    page->Add(std::uint64_t{info.height});
    page->Add(std::uint64_t{info.channels});
    page->Add(info.fileFormat);
    page->Add(info.channelType);
    page->Add(info.autoColorSpace);
    page->Add(info.bytesDecoded);
}

void GetInfo(PageReader* page, ImageInfo* info) {
    info->width = static_cast<std::uint32_t>(page->Number());
    info->height = static_cast<std::uint32_t>(page->Number());
    info->channels = static_cast<std::uint32_t>(page->Number());
    info->fileFormat = page->Text();
    info->channelType = page->Text();
    info->autoColorSpace = page->Text();
    info->bytesDecoded = page->Number();
}

void SaveInfo(PageStore* store, const PageKey& key, const ImageInfo& info) {
    PageWriter page;
    AddInfo(&page, info);
    page.Add(std::uint64_t{info.hasAlpha});
    page.Add(info.wrapS);
    page.Add(info.wrapT);
    store->Save(key, page.Bytes().data(), page.Bytes().size());
}

/// \return empty when it is not there.
std::optional<ImageInfo> LoadInfo(PageStore* store, const PageKey& key) {
    std::vector<std::uint8_t> bytes;
    if (!store->Load(key, &bytes)) {
        return std::nullopt;
    }
    PageReader page(bytes);
    ImageInfo info;
    GetInfo(&page, &info);
    info.hasAlpha = page.Number() != 0;
    info.wrapS = page.Text();
    info.wrapT = page.Text();
    return page.IsGood() && page.IsAtEnd() ? std::make_optional(info) : std::nullopt;
}

} // namespace

ImageInfo ProbeImage(const ImageSource& source, PageStore* store) {
    const std::optional<PageKey> file =
        store != nullptr ? TextureKey(source, TextureRequest()) : std::nullopt;
    if (!file) {
        return ProbeImage(source);
    }
    const PageKey key = KeyFrom("header", *file);
    if (std::optional<ImageInfo> known = LoadInfo(store, key)) {
        return *known;
    }
    ImageInfo info = ProbeImage(source);
    // What is read of a file that changes meanwhile must not be kept under its old key.
    if (info.Ok() && TextureKey(source, TextureRequest()) == file) {
        SaveInfo(store, key, info);
    }
    return info;
}

void SaveDescription(PageStore* store, const PageKey& key, const TextureDescription& description) {
    PageWriter page;
    page.Add(&description.record, sizeof(description.record));
    page.Add(description.warning);
    AddInfo(&page, description.info);
    page.Add(description.numNonFinite);
    page.Add(description.numClamped);
    store->Save(DescriptionKey(key), page.Bytes().data(), page.Bytes().size());
}

std::optional<TextureDescription> LoadDescription(PageStore* store, const PageKey& key) {
    std::vector<std::uint8_t> bytes;
    if (!store->Load(DescriptionKey(key), &bytes)) {
        return std::nullopt;
    }
    PageReader page(bytes);
    TextureDescription description;
    page.Get(&description.record, sizeof(description.record));
    description.warning = page.Text();
    GetInfo(&page, &description.info);
    description.numNonFinite = page.Number();
    description.numClamped = page.Number();
    if (!page.IsGood() || !page.IsAtEnd()) {
        return std::nullopt;
    }
    return description;
}

} // namespace hds
