// SPDX-License-Identifier: Apache-2.0
// The names of an enum's values, written once: `NamesOf(Enum)` returns its table, which the dump
// and the Python bindings use, and through these whoever reads a name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace hds {

template <typename Enum>
struct EnumName {
    Enum value;
    const char* name; ///< of the enumerator, also in Python
    const char* text; ///< as USD, and the dump, write it
};

/// The names of all values, in their order from 0.
template <typename Enum, std::size_t N>
using EnumTable = std::array<EnumName<Enum>, N>;

/// Whether the table has a row for each value from 0, in order: text can be looked up by index.
template <typename Enum, std::size_t N>
constexpr bool IsInOrder(const EnumTable<Enum, N>& table) {
    for (std::size_t i = 0; i < N; ++i) {
        if (static_cast<std::size_t>(table[i].value) != i) {
            return false;
        }
    }
    return true;
}

/// The text of a value.
template <typename Enum>
const char* TextOf(Enum value) {
    static_assert(IsInOrder(NamesOf(Enum{})));
    return NamesOf(value)[static_cast<std::size_t>(value)].text;
}

} // namespace hds
