// SPDX-License-Identifier: Apache-2.0
// A texture's description as a page: numbers of 64 bits and the record as they are in memory, texts
// as their length and bytes. The page store has verified what is read here; still nothing is
// believed that could lead out of bounds.
#include "hdStream/texture/textureBuild.h"

#include <cstring>

namespace hds {

namespace {

class PageWriter {
public:
    void Add(std::uint64_t value) { Add(&value, sizeof(value)); }
    void Add(const std::string& text) {
        Add(std::uint64_t{text.size()});
        Add(text.data(), text.size());
    }
    void Add(const void* data, std::size_t bytes) {
        const auto* begin = static_cast<const std::uint8_t*>(data);
        _bytes.insert(_bytes.end(), begin, begin + bytes);
    }
    const std::vector<std::uint8_t>& Bytes() const { return _bytes; }

private:
    std::vector<std::uint8_t> _bytes;
};

class PageReader {
public:
    explicit PageReader(const std::vector<std::uint8_t>& bytes) : _bytes(bytes) {}

    std::uint64_t Number() {
        std::uint64_t value = 0;
        Get(&value, sizeof(value));
        return value;
    }
    std::string Text() {
        const std::uint64_t size = Number();
        std::string text(size <= _bytes.size() - _at ? size : 0, '\0');
        _isGood = _isGood && text.size() == size;
        Get(text.data(), text.size());
        return text;
    }
    void Get(void* data, std::size_t bytes) {
        _isGood = _isGood && bytes <= _bytes.size() - _at;
        if (_isGood && bytes > 0) {
            std::memcpy(data, &_bytes[_at], bytes);
            _at += bytes;
        }
    }
    bool IsGood() const { return _isGood; }
    bool IsAtEnd() const { return _at == _bytes.size(); }

private:
    const std::vector<std::uint8_t>& _bytes;
    std::size_t _at = 0;
    bool _isGood = true;
};

PageKey DescriptionKey(const PageKey& key) {
    Hasher hasher;
    hasher.Append("description");
    hasher.Append(key.words[0]);
    hasher.Append(key.words[1]);
    return MakePageKey(hasher);
}

} // namespace

void SaveDescription(PageStore* store, const PageKey& key, const TextureDescription& description) {
    PageWriter page;
    page.Add(&description.record, sizeof(description.record));
    page.Add(description.warning);
    page.Add(std::uint64_t{description.info.width});
    page.Add(std::uint64_t{description.info.height});
    page.Add(std::uint64_t{description.info.channels});
    page.Add(description.info.fileFormat);
    page.Add(description.info.channelType);
    page.Add(description.info.autoColorSpace);
    page.Add(description.info.bytesDecoded);
    page.Add(description.numNonFinite);
    page.Add(description.numClamped);
    page.Add(std::uint64_t{description.repeats.size()});
    for (const auto& [line, first] : description.repeats) {
        page.Add((std::uint64_t{line} << 32) | first);
    }
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
    description.info.width = static_cast<std::uint32_t>(page.Number());
    description.info.height = static_cast<std::uint32_t>(page.Number());
    description.info.channels = static_cast<std::uint32_t>(page.Number());
    description.info.fileFormat = page.Text();
    description.info.channelType = page.Text();
    description.info.autoColorSpace = page.Text();
    description.info.bytesDecoded = page.Number();
    description.numNonFinite = page.Number();
    description.numClamped = page.Number();
    const std::uint64_t numRepeats = page.Number();
    for (std::uint64_t i = 0; i < numRepeats && page.IsGood(); ++i) {
        const std::uint64_t pair = page.Number();
        description.repeats.emplace_hint(description.repeats.end(),
                                         static_cast<std::uint32_t>(pair >> 32),
                                         static_cast<std::uint32_t>(pair));
    }
    if (!page.IsGood() || !page.IsAtEnd()) {
        return std::nullopt;
    }
    return description;
}

} // namespace hds
