// SPDX-License-Identifier: Apache-2.0
// Structs that list their members (base/fields.h), and enums that list their names, as Python sees
// them: an attribute for each member, arrays without a copy.
#pragma once

#include "hdStream/python/bufferSpan.h"

#include <glm/gtc/type_ptr.hpp>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/set.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace hds::python {

/// A matrix from 16 doubles in Gf's memory order, which is glm's too (see sceneDescription.h).
inline glm::dmat4 MatrixFromBuffer(nanobind::handle object, const char* what) {
    const HeldBuffer buffer(object, 'd', sizeof(double), what);
    if (buffer.numItems() != 16) {
        throw nanobind::value_error("a matrix has 16 items");
    }
    glm::dmat4 matrix(1.0);
    std::copy_n(static_cast<const double*>(buffer.data()), 16, glm::value_ptr(matrix));
    return matrix;
}

/// A numpy array [4][4] with a copy of the matrix, in Gf's memory order.
inline nanobind::object ArrayFromMatrix(const glm::dmat4& matrix) {
    const double* items = glm::value_ptr(matrix);
    return ArrayFromSpan(SharedSpan<double>(std::vector<double>(items, items + 16)), 4);
}

/// How Python sees a member; as nanobind sees its type, unless there is a specialisation.
template <typename T>
struct Attribute {
    static constexpr bool kIsOwn = false;
};

template <typename T>
struct Attribute<SharedSpan<T>> {
    static constexpr bool kIsOwn = true;
    static nanobind::object Get(const SharedSpan<T>& span, std::size_t rowLength) {
        return ArrayFromSpan(span, rowLength);
    }
    using Input = nanobind::handle;
    static SharedSpan<T> Set(nanobind::handle object, const char* name, std::size_t rowLength) {
        SharedSpan<T> span = SpanFromBuffer<T>(object, name).first;
        if (span.size() % rowLength != 0) {
            throw nanobind::value_error("the array does not consist of whole rows");
        }
        return span;
    }
};

template <>
struct Attribute<glm::dmat4> {
    static constexpr bool kIsOwn = true;
    static nanobind::object Get(const glm::dmat4& matrix, std::size_t /*rowLength*/) {
        return ArrayFromMatrix(matrix);
    }
    using Input = nanobind::handle;
    static glm::dmat4 Set(nanobind::handle object, const char* name, std::size_t /*rowLength*/) {
        return MatrixFromBuffer(object, name);
    }
};

/// Matrices [count][16]; set as these or as a tuple of parts: translations [count][3], rotations
/// [count][4] (i, j, k, real; float32 or float16) and scales [count][3], None where there are none.
template <>
struct Attribute<InstanceTransforms> {
    static constexpr bool kIsOwn = true;
    using Matrices = Attribute<SharedSpan<double>>;
    static nanobind::object Get(const InstanceTransforms& transforms, std::size_t /*rowLength*/) {
        return Matrices::Get(transforms.Matrices(), 16);
    }
    using Input = nanobind::handle;
    static InstanceTransforms Set(nanobind::handle object, const char* name,
                                  std::size_t /*rowLength*/) {
        if (!nanobind::isinstance<nanobind::tuple>(object)) {
            return Matrices::Set(object, name, 16);
        }
        const auto parts = nanobind::borrow<nanobind::tuple>(object);
        if (parts.size() != 3) {
            throw nanobind::value_error("instances have translations, rotations and scales");
        }
        InstanceTransforms transforms;
        SetPart(parts[0], name, 3, &transforms.translations);
        if (HasFormat(parts[1], "float16")) {
            SetPart(parts[1], name, 4, &transforms.halfRotations);
        } else {
            SetPart(parts[1], name, 4, &transforms.rotations);
        }
        SetPart(parts[2], name, 3, &transforms.scales);
        return transforms;
    }

private:
    template <typename T>
    static void SetPart(nanobind::handle part, const char* name, std::size_t rowLength,
                        SharedSpan<T>* span) {
        if (!part.is_none()) {
            *span = Attribute<SharedSpan<T>>::Set(part, name, rowLength);
        }
    }
    static bool HasFormat(nanobind::handle array, const char* dtype) {
        const nanobind::object type = nanobind::getattr(array, "dtype", nanobind::none());
        return std::string(nanobind::str(type).c_str()) == dtype;
    }
};

/// A sample, or an interval: a struct of two members is a pair.
template <typename T>
struct PairAttribute {
    static constexpr bool kIsOwn = true;
    static constexpr auto kFirst = std::get<0>(T::Fields());
    static constexpr auto kSecond = std::get<1>(T::Fields());
    using SecondMember = typename std::decay_t<decltype(kSecond)>::Member;
    static constexpr bool kIsSample = Attribute<SecondMember>::kIsOwn;
    using Input = std::pair<double, std::conditional_t<kIsSample, nanobind::object, SecondMember>>;

    static Input Get(const T& pair, std::size_t /*rowLength*/) {
        const SecondMember& second = pair.*kSecond.member;
        if constexpr (kIsSample) {
            return {pair.*kFirst.member, Attribute<SecondMember>::Get(second, kSecond.rowLength)};
        } else {
            return {pair.*kFirst.member, second};
        }
    }
    static T Set(const Input& pair, const char* name, std::size_t /*rowLength*/) {
        if constexpr (kIsSample) {
            return {pair.first, Attribute<SecondMember>::Set(pair.second, name, kSecond.rowLength)};
        } else {
            return {pair.first, pair.second};
        }
    }
};

/// A list of them.
template <typename T>
struct PairsAttribute {
    static constexpr bool kIsOwn = true;
    using One = PairAttribute<T>;
    using Input = std::vector<typename One::Input>;

    static Input Get(const std::vector<T>& values, std::size_t rowLength) {
        Input pairs;
        for (const T& value : values) {
            pairs.push_back(One::Get(value, rowLength));
        }
        return pairs;
    }
    static std::vector<T> Set(const Input& pairs, const char* name, std::size_t rowLength) {
        std::vector<T> values;
        for (const auto& pair : pairs) {
            values.push_back(One::Set(pair, name, rowLength));
        }
        return values;
    }
};

template <>
struct Attribute<Shutter> : PairAttribute<Shutter> {};
template <>
struct Attribute<std::vector<PointSample>> : PairsAttribute<PointSample> {};
template <>
struct Attribute<std::vector<FloatSample>> : PairsAttribute<FloatSample> {};
template <>
struct Attribute<std::vector<TransformSample>> : PairsAttribute<TransformSample> {};
template <>
struct Attribute<std::vector<InstanceSample>> : PairsAttribute<InstanceSample> {};

template <>
struct Attribute<std::vector<glm::dvec4>> {
    static constexpr bool kIsOwn = true;
    using Input = std::vector<std::array<double, 4>>;

    static Input Get(const std::vector<glm::dvec4>& vectors, std::size_t /*rowLength*/) {
        Input rows;
        for (const glm::dvec4& v : vectors) {
            rows.push_back({v.x, v.y, v.z, v.w});
        }
        return rows;
    }
    static std::vector<glm::dvec4> Set(const Input& rows, const char* /*name*/,
                                       std::size_t /*rowLength*/) {
        std::vector<glm::dvec4> vectors;
        for (const auto& row : rows) {
            vectors.emplace_back(row[0], row[1], row[2], row[3]);
        }
        return vectors;
    }
};

/// ReadOnly: of what is made whole by its constructor.
enum class FieldAccess { ReadWrite, ReadOnly };

/// An attribute for each member.
template <FieldAccess access = FieldAccess::ReadWrite, typename T>
void BindFields(nanobind::class_<T>& binding) {
    ForEachField<T>([&](const auto& field) {
        using Member = typename std::decay_t<decltype(field)>::Member;
        using Own = Attribute<Member>;
        if (field.notInPython) {
            return;
        }
        const auto member = field.member;
        const char* const name = field.name;
        const std::size_t rowLength = field.rowLength;
        if constexpr (Own::kIsOwn) {
            const auto get = [member, rowLength](const T& self) {
                return Own::Get(self.*member, rowLength);
            };
            if constexpr (access == FieldAccess::ReadOnly) {
                binding.def_prop_ro(name, get);
            } else {
                binding.def_prop_rw(
                    name, get,
                    [member, name, rowLength](T& self, const typename Own::Input& value) {
                        self.*member = Own::Set(value, name, rowLength);
                    });
            }
        } else if constexpr (IsApartTrait<Member>::value) {
            using Value = std::decay_t<decltype(*std::declval<Member>())>;
            binding.def_prop_rw(
                name, [member](T& self) -> Value& { return (self.*member).Edit(); },
                [member](T& self, const Value& value) { self.*member = value; });
        } else if constexpr (access == FieldAccess::ReadOnly) {
            binding.def_ro(name, member);
        } else {
            binding.def_rw(name, member);
        }
    });
}

/// A struct that is made empty and then filled in.
template <typename T>
void BindStruct(nanobind::module_& module, const char* name, const char* documentation) {
    nanobind::class_<T> binding(module, name, documentation);
    binding.def(nanobind::init<>());
    BindFields(binding);
}

/// An enum, and its values by what USD calls them as the module's `<name>ByText`.
template <typename Enum>
void BindEnum(nanobind::module_& module, const char* name, const char* documentation) {
    nanobind::enum_<Enum> binding(module, name, documentation);
    for (const auto& row : NamesOf(Enum{})) {
        binding.value(row.name, row.value);
    }
    nanobind::dict byText;
    for (const auto& row : NamesOf(Enum{})) {
        byText[row.text] = nanobind::cast(row.value);
    }
    module.attr((std::string(name) + "ByText").c_str()) = byText;
}

} // namespace hds::python
