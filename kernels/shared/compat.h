/* SPDX-License-Identifier: Apache-2.0
 * Types and macros that let one header be read by C++17 and by OpenCL C 1.2.
 * Invariant: shared structs hold only u32, i32, u64, f32, float4 and fixed arrays of them, in rows
 * of 16 bytes, so that every compiler gives them the same layout
 * (testenv/device/device/testLayout.cpp). Functions that both run (HDS_FUNCTION) use nothing but
 * these types, and give the same bits on both. Explained in docs/device.md. */
#ifndef HDS_SHARED_COMPAT_H
#define HDS_SHARED_COMPAT_H

#ifdef __OPENCL_VERSION__
typedef uchar u8;
typedef uint u32;
typedef int i32;
typedef ulong u64;
typedef float f32;
#define HDS_SHARED_BEGIN
#define HDS_SHARED_END
#define HDS_FUNCTION
#define HDS_GLOBAL global
#define HDS_TABLE constant
#define HDS_FLOAT4(x, y, z, w) ((float4)((x), (y), (z), (w)))
#define HDS_AS_FLOAT(bits) as_float(bits)
#define HDS_ASSERT_SIZE(T, n) typedef char hdsSize_##T[(sizeof(T) == (n)) ? 1 : -1]
#else
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#define HDS_SHARED_BEGIN namespace hds::shared {
#define HDS_SHARED_END }
#define HDS_FUNCTION inline
#define HDS_GLOBAL
#define HDS_TABLE constexpr
#define HDS_FLOAT4(x, y, z, w) (::hds::shared::float4{(x), (y), (z), (w)})
#define HDS_AS_FLOAT(bits) ::hds::shared::FloatOfBits(bits)
#define HDS_ASSERT_SIZE(T, n) \
    static_assert(            \
        sizeof(T) == (n) && std::is_standard_layout_v<T> && std::is_trivially_copyable_v<T>, #T)
namespace hds::shared {
using u8 = std::uint8_t;
using u32 = std::uint32_t;
using i32 = std::int32_t;
using u64 = std::uint64_t;
using f32 = float;
struct alignas(16) float4 {
    float x, y, z, w;
};
inline float FloatOfBits(u32 bits) {
    float value;
    std::memcpy(&value, &bits, sizeof(value));
    return value;
}
} // namespace hds::shared
#endif

/* "No such index": ids, offsets and addresses alike. */
#define HDS_NONE 0xffffffffu

#endif
