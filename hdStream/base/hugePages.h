// SPDX-License-Identifier: Apache-2.0
// Host memory in the machine's large pages, for what CPU devices read: traversal reads all over it,
// and misses of the address translation would cost more than those of the caches.
// Explained in docs/device.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <utility>
#include <vector>

namespace hds {

/// From so many bytes on large pages are worth it, where the system may have any.
#if defined(__linux__)
constexpr std::uint64_t kMinHugePageBytes = 4U << 20U;
#else
constexpr std::uint64_t kMinHugePageBytes = ~std::uint64_t{0};
#endif

/// Memory of zeros for which large pages were asked, aligned to them; null when memory has run out.
/// Thread-safe.
void* AllocateHugePages(std::uint64_t bytes);
/// \param bytes as given to AllocateHugePages.
void FreeHugePages(void* memory, std::uint64_t bytes);

/// Puts long vectors into large pages. Elements that a vector adds without a value are left as they
/// are: whoever resizes it writes them.
template <typename T>
struct HugePageAllocator {
    using value_type = T;

    HugePageAllocator() = default;
    template <typename Other>
    HugePageAllocator(const HugePageAllocator<Other>&) {} // NOLINT: converts

    T* allocate(std::size_t count) {
        const std::uint64_t bytes = std::uint64_t{count} * sizeof(T);
        if (bytes < kMinHugePageBytes) {
            return static_cast<T*>(::operator new(count * sizeof(T)));
        }
        void* memory = AllocateHugePages(bytes);
        if (memory == nullptr) {
            throw std::bad_alloc();
        }
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, std::size_t count) {
        const std::uint64_t bytes = std::uint64_t{count} * sizeof(T);
        if (bytes < kMinHugePageBytes) {
            ::operator delete(memory);
        } else {
            FreeHugePages(memory, bytes);
        }
    }
    template <typename U>
    void construct(U* place) {
        ::new (static_cast<void*>(place)) U;
    }
    template <typename U, typename... Values>
    void construct(U* place, Values&&... values) {
        ::new (static_cast<void*>(place)) U(std::forward<Values>(values)...);
    }
    friend bool operator==(const HugePageAllocator&, const HugePageAllocator&) { return true; }
    friend bool operator!=(const HugePageAllocator&, const HugePageAllocator&) { return false; }
};

/// A table that a CPU device may read in place.
template <typename T>
using HugeVector = std::vector<T, HugePageAllocator<T>>;

} // namespace hds
