// SPDX-License-Identifier: Apache-2.0
// Four floats with exactly the operations the builder needs; SSE where there is SSE, plain C++
// elsewhere, with the same results bit for bit.
// Private to the layer. Explained in docs/accel.md.
#pragma once

#include <cstdint>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace hds {

/// Four lanes; lane 3 is kept at zero by LoadBox, so that item numbers stored next to a box never
/// enter arithmetic as denormals.
#if defined(__SSE2__)
struct Float4 {
    __m128 lanes;
};

inline Float4 Splat(float x) {
    return {_mm_set1_ps(x)};
}
inline Float4 LoadBox(const float* xyz) {
    const __m128 mask = _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1));
    return {_mm_and_ps(_mm_load_ps(xyz), mask)};
}
/// Of a position anywhere; four floats are there to read.
inline Float4 LoadPosition(const float* xyz) {
    const __m128 mask = _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1));
    return {_mm_and_ps(_mm_loadu_ps(xyz), mask)};
}
inline void Store(float* xyzw, Float4 a) {
    _mm_store_ps(xyzw, a.lanes);
}
inline Float4 Min(Float4 a, Float4 b) {
    return {_mm_min_ps(a.lanes, b.lanes)};
}
inline Float4 Max(Float4 a, Float4 b) {
    return {_mm_max_ps(a.lanes, b.lanes)};
}
inline Float4 operator+(Float4 a, Float4 b) {
    return {_mm_add_ps(a.lanes, b.lanes)};
}
inline Float4 operator-(Float4 a, Float4 b) {
    return {_mm_sub_ps(a.lanes, b.lanes)};
}
inline Float4 operator*(Float4 a, Float4 b) {
    return {_mm_mul_ps(a.lanes, b.lanes)};
}
/// Truncates towards zero. \pre the values fit an int32.
inline void StoreInts(std::int32_t* xyzw, Float4 a) {
    _mm_store_si128(reinterpret_cast<__m128i*>(xyzw), _mm_cvttps_epi32(a.lanes));
}
#else
struct Float4 {
    float lanes[4];
};

template <typename Operation>
Float4 MapLanes(Float4 a, Float4 b, Operation operation) {
    Float4 r;
    for (int i = 0; i < 4; ++i) {
        r.lanes[i] = operation(a.lanes[i], b.lanes[i]);
    }
    return r;
}
inline Float4 Splat(float x) {
    return {{x, x, x, x}};
}
inline Float4 LoadBox(const float* xyz) {
    return {{xyz[0], xyz[1], xyz[2], 0.0F}};
}
inline Float4 LoadPosition(const float* xyz) {
    return LoadBox(xyz);
}
inline void Store(float* xyzw, Float4 a) {
    for (int i = 0; i < 4; ++i) {
        xyzw[i] = a.lanes[i];
    }
}
inline Float4 Min(Float4 a, Float4 b) {
    return MapLanes(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline Float4 Max(Float4 a, Float4 b) {
    return MapLanes(a, b, [](float x, float y) { return x > y ? x : y; });
}
inline Float4 operator+(Float4 a, Float4 b) {
    return MapLanes(a, b, [](float x, float y) { return x + y; });
}
inline Float4 operator-(Float4 a, Float4 b) {
    return MapLanes(a, b, [](float x, float y) { return x - y; });
}
inline Float4 operator*(Float4 a, Float4 b) {
    return MapLanes(a, b, [](float x, float y) { return x * y; });
}
/// Truncates towards zero. \pre the values fit an int32.
inline void StoreInts(std::int32_t* xyzw, Float4 a) {
    for (int i = 0; i < 4; ++i) {
        xyzw[i] = static_cast<std::int32_t>(a.lanes[i]);
    }
}
#endif

} // namespace hds
