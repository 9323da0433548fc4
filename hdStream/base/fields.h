// SPDX-License-Identifier: Apache-2.0
// The one list of a struct's members: `static constexpr auto Fields()` returns a FieldList of them.
// Equality, cache keys (fieldHash.h), the dump and the Python bindings go through it, so that a
// member is named once. A list that lacks a member does not compile where it is first used.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

namespace hds {

/// One member of a struct. The functions say what does not go without saying.
template <typename OwnerType, typename MemberType>
struct Field {
    using Owner = OwnerType;
    using Member = MemberType;

    const char* name;
    Member Owner::*member;
    std::size_t rowLength = 1;         ///< of an array: numbers that belong together
    std::uint32_t cases = ~0U;         ///< bits 1 << enumerator of what the member is for
    const char* notInKey = nullptr;    ///< why cache keys leave it out; null: they have it
    const char* notInDump = nullptr;   ///< why the dump leaves it out
    const char* notInPython = nullptr; ///< why the bindings leave it to hand

    constexpr Field Rows(std::size_t length) const {
        Field field = *this;
        field.rowLength = length;
        return field;
    }
    /// Only objects of these kinds have it: those that a sibling's enumerators name.
    template <typename... Enumerators>
    constexpr Field For(Enumerators... enumerators) const {
        Field field = *this;
        field.cases = ((1U << static_cast<std::uint32_t>(enumerators)) | ...);
        return field;
    }
    constexpr Field NotInKey(const char* reason) const {
        Field field = *this;
        field.notInKey = reason;
        return field;
    }
    constexpr Field NotInDump(const char* reason) const {
        Field field = *this;
        field.notInDump = reason;
        return field;
    }
    constexpr Field NotInPython(const char* reason) const {
        Field field = *this;
        field.notInPython = reason;
        return field;
    }

    template <typename Enumerator>
    constexpr bool IsFor(Enumerator enumerator) const {
        return (cases & 1U << static_cast<std::uint32_t>(enumerator)) != 0;
    }
    template <typename Other>
    constexpr bool Is(Other Owner::*other) const {
        if constexpr (std::is_same_v<Other, Member>) {
            return member == other;
        } else {
            return false;
        }
    }
};

/// A member by its name, which is thus written once.
#define HDS_FIELD(Owner, member)                   \
    ::hds::Field<Owner, decltype(Owner::member)> { \
#member, &Owner::member                    \
    }

/// What Fields() returns.
template <typename... FieldTypes>
constexpr std::tuple<FieldTypes...> FieldList(FieldTypes... fields) {
    return {fields...};
}

template <typename T, typename = void>
struct HasFieldsTrait : std::false_type {};
template <typename T>
struct HasFieldsTrait<T, std::void_t<decltype(T::Fields())>> : std::true_type {};

/// Whether a type lists its members.
template <typename T>
constexpr bool kHasFields = HasFieldsTrait<T>::value;

/// Compiles only where T has as many members as its list: the language counts them here, and a
/// struct with another number cannot be taken apart like this.
template <typename T>
auto CountMembers(const T& object) {
    constexpr std::size_t kCount = std::tuple_size_v<decltype(T::Fields())>;
    static_assert(kCount >= 1 && kCount <= 23, "more members: add their number below");
#define HDS_TAKE_APART(count, ...)                           \
    if constexpr (kCount == (count)) {                       \
        [[maybe_unused]] const auto& [__VA_ARGS__] = object; \
    }
    HDS_TAKE_APART(1, a)
    HDS_TAKE_APART(2, a, b)
    HDS_TAKE_APART(3, a, b, c)
    HDS_TAKE_APART(4, a, b, c, d)
    HDS_TAKE_APART(5, a, b, c, d, e)
    HDS_TAKE_APART(6, a, b, c, d, e, f)
    HDS_TAKE_APART(7, a, b, c, d, e, f, g)
    HDS_TAKE_APART(8, a, b, c, d, e, f, g, h)
    HDS_TAKE_APART(9, a, b, c, d, e, f, g, h, i)
    HDS_TAKE_APART(10, a, b, c, d, e, f, g, h, i, j)
    HDS_TAKE_APART(11, a, b, c, d, e, f, g, h, i, j, k)
    HDS_TAKE_APART(12, a, b, c, d, e, f, g, h, i, j, k, l)
    HDS_TAKE_APART(13, a, b, c, d, e, f, g, h, i, j, k, l, m)
    HDS_TAKE_APART(14, a, b, c, d, e, f, g, h, i, j, k, l, m, n)
    HDS_TAKE_APART(15, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o)
    HDS_TAKE_APART(16, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p)
    HDS_TAKE_APART(17, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q)
    HDS_TAKE_APART(18, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r)
    HDS_TAKE_APART(19, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s)
    HDS_TAKE_APART(20, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t)
    HDS_TAKE_APART(21, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u)
    HDS_TAKE_APART(22, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v)
    HDS_TAKE_APART(23, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v, w)
#undef HDS_TAKE_APART
    return std::integral_constant<std::size_t, kCount>();
}

/// Whether no two fields of a list are the same member.
template <typename... FieldTypes>
constexpr bool AreDistinct(const std::tuple<FieldTypes...>& fields) {
    const auto countOf = [&](const auto& wanted) {
        return std::apply(
            [&](const auto&... field) { return (0 + ... + int{wanted.Is(field.member)}); }, fields);
    };
    return std::apply([&](const auto&... field) { return ((countOf(field) == 1) && ...); }, fields);
}

/// Calls `function` with each Field of T, in the order of the list.
template <typename T, typename Function>
constexpr void ForEachField(Function&& function) {
    using Count = decltype(CountMembers(std::declval<const T&>()));
    static_assert(Count::value > 0);
    static_assert(AreDistinct(T::Fields()), "a member is listed twice");
    std::apply([&](const auto&... field) { (function(field), ...); }, T::Fields());
}

/// Whether all members are equal.
template <typename T, typename = std::enable_if_t<kHasFields<T>>>
bool operator==(const T& a, const T& b) {
    bool areEqual = true;
    ForEachField<T>([&](const auto& field) {
        using Member = typename std::decay_t<decltype(field)>::Member;
        if constexpr (std::is_array_v<Member>) {
            areEqual =
                areEqual && std::equal(std::begin(a.*field.member), std::end(a.*field.member),
                                       std::begin(b.*field.member));
        } else {
            areEqual = areEqual && a.*field.member == b.*field.member;
        }
    });
    return areEqual;
}

template <typename T, typename = std::enable_if_t<kHasFields<T>>>
bool operator!=(const T& a, const T& b) {
    return !(a == b);
}

} // namespace hds
