// SPDX-License-Identifier: Apache-2.0
// A value that most objects of a scene do not have: it lies apart, so that those without it, of
// which there may be millions, do not have its size.
#pragma once

#include <atomic>
#include <type_traits>
#include <utility>

namespace hds {

/// A value of T that takes the memory of a pointer while it is that of T(). Copies and compares as
/// T does. What is only read may be read by any thread, also while another one calls Edit.
template <typename T>
class Apart {
public:
    Apart() = default;
    Apart(const T& value) // NOLINT(google-explicit-constructor): a conversion by design
        : _value(value == T() ? nullptr : new T(value)) {}
    Apart(const Apart& other) : _value(other.IsApart() ? new T(*other) : nullptr) {}
    Apart(Apart&& other) noexcept : _value(other._value.exchange(nullptr)) {}
    ~Apart() { delete _value.load(); }
    Apart& operator=(const Apart& other) {
        Apart copy(other);
        return *this = std::move(copy);
    }
    Apart& operator=(Apart&& other) noexcept {
        delete _value.exchange(other._value.exchange(nullptr));
        return *this;
    }

    const T& operator*() const {
        static const T kDefault{};
        const T* value = _value.load();
        return value != nullptr ? *value : kDefault;
    }
    const T* operator->() const { return &**this; }
    /// Whether it may be another than T().
    bool IsApart() const { return _value.load() != nullptr; }
    /// The value, to be changed. One thread at a time.
    T& Edit() {
        if (!IsApart()) {
            _value.store(new T());
        }
        return *_value.load();
    }

    bool operator==(const Apart& other) const { return **this == *other; }
    bool operator!=(const Apart& other) const { return !(*this == other); }

private:
    std::atomic<T*> _value{nullptr};
};

template <typename T>
struct IsApartTrait : std::false_type {};
template <typename T>
struct IsApartTrait<Apart<T>> : std::true_type {};

} // namespace hds
