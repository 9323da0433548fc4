// SPDX-License-Identifier: Apache-2.0
// An array of a scene that can be read again where it came from, so that host memory need not keep
// it. Explained in docs/memory-budgets.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

namespace hds {

/// The bytes of an array and what keeps them.
struct ArrayBytes {
    std::shared_ptr<const void> owner;
    const void* data = nullptr;
    std::size_t bytes = 0;
};

/// What all sources of the process have together, at present and since it began.
struct ArrayCounts {
    std::uint64_t bytes = 0;     ///< of all arrays, whether they are in memory or not
    std::uint64_t keptBytes = 0; ///< of those that wait in memory to be used for the first time
    std::uint64_t readBytes = 0; ///< that were read again
};

/// Knows how an array is read again and that what is read is what was there before. Thread-safe.
class ArraySource {
public:
    /// Reads the array where it came from. Any thread; \throws Error without the array's name.
    using Reader = std::function<ArrayBytes()>;

    /// Arrays that wait for their first use take at most so many bytes in all sources together;
    /// others are read twice.
    static constexpr std::uint64_t kMostKeptBytes = std::uint64_t{1} << 30U;

    /// \param name starts the line of an error: prim path and attribute. \param first what was read
    /// when the scene was made. \param mostKeptBytes for tests.
    ArraySource(std::string name, ArrayBytes first, Reader readAgain,
                std::uint64_t mostKeptBytes = kMostKeptBytes);
    ~ArraySource();
    ArraySource(const ArraySource&) = delete;
    ArraySource& operator=(const ArraySource&) = delete;

    std::size_t Bytes() const { return _bytes; }
    /// The array: as it is in memory, for whomever, or else read again. Holds no lock while it
    /// reads. \throws Error with one line when it cannot be read or is not what it was.
    ArrayBytes Hold() const;
    /// Keeps the array no more than others do who hold it. The first time it is hashed.
    void Drop() const;

    static ArrayCounts Counts();

private:
    using Hash = std::array<std::uint64_t, 2>;

    std::string _name;
    std::size_t _bytes;
    Reader _readAgain;
    mutable std::mutex _mutex;
    mutable ArrayBytes _kept;                 ///< until it is dropped
    mutable std::weak_ptr<const void> _alive; ///< the owner of what was read last
    mutable const void* _data = nullptr;      ///< of `_alive`
    mutable Hash _hash{};                     ///< of the array once it has been dropped
};

} // namespace hds
