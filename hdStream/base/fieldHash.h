// SPDX-License-Identifier: Apache-2.0
// Cache keys of structs that list their members (fields.h): whatever a struct gains is in the key.
#pragma once

#include "hdStream/base/apart.h"
#include "hdStream/base/fields.h"
#include "hdStream/base/hash.h"
#include "hdStream/base/sharedSpan.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace hds {

/// Hashes values by their content. Lengths and alternatives are hashed too, so that no two
/// different values give the same bytes.
class FieldHasher {
public:
    explicit FieldHasher(Hasher* hasher) : _hasher(*hasher) {}

    template <typename T>
    void Add(const T& value) {
        if constexpr (std::is_integral_v<T> || std::is_enum_v<T>) {
            _hasher.Append(static_cast<std::uint64_t>(value));
        } else if constexpr (std::is_floating_point_v<T>) {
            std::uint64_t bits = 0;
            std::memcpy(&bits, &value, sizeof(value));
            _hasher.Append(bits);
        } else if constexpr (kHasFields<T>) {
            ForEachField<T>([&](const auto& field) {
                if (!field.notInKey) {
                    Add(value.*field.member);
                }
            });
        } else {
            AddWhole(value);
        }
    }

private:
    /// Below it, arrays are hashed on the spot.
    static constexpr std::size_t kParallelBytes = 1U << 20U;

    template <typename T>
    void AddNumbers(const T* values, std::size_t count) {
        const std::size_t bytes = count * sizeof(T);
        _hasher.Append(std::uint64_t{count});
        if (bytes >= kParallelBytes) {
            AppendParallel(&_hasher, values, bytes);
        } else if (bytes > 0) {
            _hasher.Append(values, bytes);
        }
    }
    template <typename Range>
    void AddEach(const Range& values) {
        for (const auto& value : values) {
            Add(value);
        }
    }

    void AddWhole(const std::string& text) { _hasher.Append(std::string_view(text)); }
    template <typename T>
    void AddWhole(const SharedSpan<T>& values) {
        const SharedSpan<T> held = values.Held();
        AddNumbers(held.data(), held.size());
    }
    template <typename T>
    void AddWhole(const std::vector<T>& values) {
        if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
            AddNumbers(values.data(), values.size());
        } else {
            Add(values.size());
            AddEach(values);
        }
    }
    void AddWhole(const std::vector<bool>& values) {
        Add(values.size());
        for (const bool value : values) {
            Add(value);
        }
    }
    template <typename T>
    void AddWhole(const std::set<T>& values) {
        Add(values.size());
        AddEach(values);
    }
    template <typename Key, typename T>
    void AddWhole(const std::map<Key, T>& values) {
        Add(values.size());
        for (const auto& [key, value] : values) {
            Add(key);
            Add(value);
        }
    }
    template <typename T, std::size_t N>
    void AddWhole(const std::array<T, N>& values) {
        AddEach(values);
    }
    template <typename T, std::size_t N>
    void AddWhole(const T (&values)[N]) {
        AddEach(values);
    }
    template <glm::length_t N, typename T, glm::qualifier Q>
    void AddWhole(const glm::vec<N, T, Q>& v) {
        for (glm::length_t i = 0; i < N; ++i) {
            Add(v[i]);
        }
    }
    template <glm::length_t C, glm::length_t R, typename T, glm::qualifier Q>
    void AddWhole(const glm::mat<C, R, T, Q>& m) {
        for (glm::length_t i = 0; i < C; ++i) {
            Add(m[i]);
        }
    }
    template <typename T>
    void AddWhole(const std::optional<T>& value) {
        Add(value.has_value());
        if (value) {
            Add(*value);
        }
    }
    template <typename T>
    void AddWhole(const Apart<T>& value) {
        Add(*value);
    }
    /// What it points to, not where that lies.
    template <typename T>
    void AddWhole(const std::shared_ptr<T>& pointer) {
        Add(pointer != nullptr);
        if (pointer) {
            Add(*pointer);
        }
    }
    template <typename... Types>
    void AddWhole(const std::variant<Types...>& value) {
        Add(value.index());
        std::visit([&](const auto& held) { Add(held); }, value);
    }

    Hasher& _hasher;
};

} // namespace hds
