// SPDX-License-Identifier: Apache-2.0
// Parts of a page one after the other: numbers of 64 bits and records as they are in memory, texts
// as their length and bytes. The page store has verified what is read here; still nothing is
// believed that could lead out of bounds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace hds {

/// Appends parts of a page.
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

/// Reads them back. What is not there reads as zeros, and the page is not good then.
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

} // namespace hds
