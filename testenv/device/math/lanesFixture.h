// SPDX-License-Identifier: Apache-2.0
// Formulas that are compiled twice (kernels/math/lanes.clh): the form of 8 paths against the form
// of one, word for word. A test gives one text, which is compiled in both forms, and numbers.
#pragma once

#include "hdStream/device/embeddedKernels.h"
#include "kernels/shared/frame.h"
#include "kernels/shared/light.h"
#include "testenv/support/deviceFixture.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>

namespace hds::test {

constexpr std::size_t kLanes = 8;

/// What functions under test share. Their signature in the text is
///     void name(const HdsTestContext* context, const Real* in, Real* out)
inline const char* const kLanesContext = R"(
#include "shared/frame.h"
#include "shared/light.h"
#include "math/vector.clh"
typedef struct {
    constant const HdsFrameParams* frame;
    global const float* table;
    global const HdsLight* lights;
    uint numLights;
} HdsTestContext;
)";

/// Part of the text that is compiled in both forms. HDS_TEST_STRUCT makes the members of a struct
/// of numbers, and numbers of the members; HDS_TEST_FIELDS_name lists them.
inline const char* const kLanesHelpers = R"(
Real3 take3(const Real* in) { return real_make3(in[0], in[1], in[2]); }
Real2 take2(const Real* in) { return real_make2(in[0], in[1]); }
Real* put1(Real* out, Real v) { out[0] = v; return out + 1; }
Real* put2(Real* out, Real2 v) { out[0] = v.x; out[1] = v.y; return out + 2; }
Real* put3(Real* out, Real3 v) { out[0] = v.x; out[1] = v.y; out[2] = v.z; return out + 3; }
Real* putBits(Real* out, Uint v) { out[0] = as_Real(v); return out + 1; }
Real* putFlag(Real* out, Bool v) {
    const Real one = 1.0f;
    out[0] = v ? one : -one;
    return out + 1;
}
Real3 only(Bool isValid, Real3 v) { return vec_select(isValid, v, vec_splat((Real)(0.0f))); }
Real only1(Bool isValid, Real v) { return isValid ? v : (Real)(0.0f); }
#define HDS_MAKE_1(member) s->member = *in; ++in;
#define HDS_MAKE_2(member) s->member = take2(in); in += 2;
#define HDS_MAKE_3(member) s->member = take3(in); in += 3;
#define HDS_MAKE_U(member) s->member = as_Uint(*in); ++in;
#define HDS_STORE_1(member) out = put1(out, s->member);
#define HDS_STORE_2(member) out = put2(out, s->member);
#define HDS_STORE_3(member) out = put3(out, s->member);
#define HDS_STORE_U(member) out = putBits(out, s->member);
#define HDS_TEST_STRUCT(T)                                                           \
    void T##_make(Hds##T* s, const Real* in) {                                       \
        HDS_TEST_FIELDS_##T(HDS_MAKE_1, HDS_MAKE_2, HDS_MAKE_3, HDS_MAKE_U)          \
    }                                                                                \
    void T##_store(const Hds##T* s, Real* out) {                                     \
        HDS_TEST_FIELDS_##T(HDS_STORE_1, HDS_STORE_2, HDS_STORE_3, HDS_STORE_U)      \
    }
)";

/// Kernels that run a function, or the copies to and from lanes, for groups of 8 cases.
inline const char* const kLanesKernels = R"(
#define HDS_TEST_ARGS                                                                       \
    global const float *in, global float *one, global float *wide, uint numGroups,          \
        constant const HdsFrameParams *frame, global const float *table,                    \
        global const HdsLight *lights, uint numLights
#define HDS_TEST_FORMS(name, numIn, numOut)                                                 \
    kernel void name##Forms(HDS_TEST_ARGS) {                                                \
        const uint group = (uint)get_global_id(0);                                          \
        if (group >= numGroups) return;                                                     \
        const HdsTestContext context = {frame, table, lights, numLights};                   \
        float8 wideIn[numIn];                                                               \
        float8 wideOut[numOut];                                                             \
        for (uint lane = 0u; lane < HDS_LANES; ++lane) {                                    \
            const uint i = group * HDS_LANES + lane;                                        \
            float oneIn[numIn];                                                             \
            float oneOut[numOut];                                                           \
            for (uint k = 0u; k < numIn; ++k) {                                             \
                oneIn[k] = in[i * numIn + k];                                               \
                ((float*)&wideIn[k])[lane] = oneIn[k];                                      \
            }                                                                               \
            for (uint k = 0u; k < numOut; ++k) {                                            \
                oneOut[k] = 0.0f;                                                           \
                wideOut[k] = 0.0f;                                                          \
            }                                                                               \
            name(&context, oneIn, oneOut);                                                  \
            for (uint k = 0u; k < numOut; ++k) one[i * numOut + k] = oneOut[k];             \
        }                                                                                   \
        name(&context, wideIn, wideOut);                                                    \
        for (uint lane = 0u; lane < HDS_LANES; ++lane) {                                    \
            const uint i = group * HDS_LANES + lane;                                        \
            for (uint k = 0u; k < numOut; ++k) {                                            \
                wide[i * numOut + k] = ((const float*)&wideOut[k])[lane];                   \
            }                                                                               \
        }                                                                                   \
    }
/* Members of a struct of one path, twice; the same put into a lane, and got from there again. */
#define HDS_TEST_LANES(T, count)                                                            \
    kernel void T##Lanes(HDS_TEST_ARGS) {                                                   \
        const uint group = (uint)get_global_id(0);                                          \
        if (group >= numGroups) return;                                                     \
        HdsWide##T all;                                                                     \
        float8 wideOut[count];                                                              \
        for (uint lane = 0u; lane < HDS_LANES; ++lane) {                                    \
            const uint i = group * HDS_LANES + lane;                                        \
            float numbers[count];                                                           \
            for (uint k = 0u; k < count; ++k) numbers[k] = in[i * count + k];               \
            HdsOne##T s;                                                                    \
            T##_make(&s, numbers);                                                          \
            HDS_LANES_PUT(&all, lane, &s);                                                  \
            for (uint k = 0u; k < count; ++k) {                                             \
                one[2u * i * count + k] = numbers[k];                                       \
                one[(2u * i + 1u) * count + k] = numbers[k];                                \
            }                                                                               \
        }                                                                                   \
        T##_store(&all, wideOut);                                                           \
        for (uint lane = 0u; lane < HDS_LANES; ++lane) {                                    \
            const uint i = group * HDS_LANES + lane;                                        \
            HdsOne##T s;                                                                    \
            float numbers[count];                                                           \
            HDS_LANES_GET(&s, &all, lane);                                                  \
            T##_store(&s, numbers);                                                         \
            for (uint k = 0u; k < count; ++k) {                                             \
                wide[2u * i * count + k] = ((const float*)&wideOut[k])[lane];               \
                wide[(2u * i + 1u) * count + k] = numbers[k];                               \
            }                                                                               \
        }                                                                                   \
    }
)";

/// Numbers of cases. In every other group of 8 all lanes are of the same kind, so that code that
/// some lanes need alone is skipped as well.
class LaneRandom {
public:
    explicit LaneRandom(unsigned seed) : _values(seed), _kinds(seed + 1) {}

    void Begin(std::size_t index) {
        if (index % kLanes == 0) {
            _ofGroup = _kinds;
        } else if (index / kLanes % 2 == 0) {
            _kinds = _ofGroup;
        }
    }
    unsigned Kind(unsigned count) { return unsigned(_kinds() % count); }
    bool Is(unsigned oneIn) { return Kind(oneIn) == 0; }
    std::uint32_t Bits() { return std::uint32_t(_values()); }
    /// [0, 1 - 2^-24], at times the ends and the middle.
    float Unit() {
        const float special[] = {0.0F, 0.5F, 0x1.fffffep-1F, 0x1p-24F};
        return _values() % 16 == 0 ? special[_values() % 4] : float(_values() >> 8U) * 0x1p-24F;
    }
    float Between(float low, float high) { return low + (high - low) * Unit(); }
    /// Of any size from 10^low to 10^high.
    float Sized(float low, float high) { return std::pow(10.0F, Between(low, high)); }
    float Signed(float value) { return _values() % 2 == 0 ? value : -value; }
    /// Whatever a float may be.
    float Any() {
        const float special[] = {0.0F,      -0.0F, 1.0F,     -1.0F,      1e-45F, 1e-38F,
                                 3.402e38F, 1e30F, INFINITY, float(NAN), 1e-30F, 0.5F};
        return _values() % 3 == 0 ? Signed(special[_values() % 12]) : Signed(Sized(-38.0F, 38.0F));
    }

private:
    std::mt19937 _values;
    std::mt19937 _kinds;
    std::mt19937 _ofGroup;
};

inline float OfBits(std::uint32_t bits) {
    return shared::FloatOfBits(bits);
}

/// The numbers of a case, appended one by one.
class LaneCase : public std::vector<float> {
public:
    void Add(std::initializer_list<float> values) { insert(end(), values); }
    void AddColor(LaneRandom& r, float scale = 1.0F) {
        Add({scale * r.Unit(), scale * r.Unit(), scale * r.Unit()});
    }
    void AddDirection(LaneRandom& r, float minZ) {
        const float z = r.Between(minZ, 1.0F);
        const float s = std::sqrt(std::max(0.0F, 1.0F - z * z));
        const float phi = 6.2831853F * r.Unit();
        Add({s * std::cos(phi), s * std::sin(phi), z});
    }
};

class LanesFixture : public CpuDeviceFixture {
protected:
    /// \param root the program whose wide block is compiled before the text. \param header with the
    /// same headers for one path. \param text in both forms. \param kernels HDS_TEST_* lines.
    std::unique_ptr<Program> BuildForms(const std::string& root, const std::string& header,
                                        const std::string& text, const std::string& kernels,
                                        ProgramDefines defines = {}) {
        defines["HDS_ITEMS_PER_WORK_ITEM"] = "32";
        return Build(kLanesContext + ("#include \"" + header + "\"\n") + kLanesHelpers + text +
                         "#include \"math/wideBegin.clh\"\n" + WideBlock(root) + kLanesHelpers +
                         text + "#include \"math/wideEnd.clh\"\n" + kLanesKernels + kernels,
                     defines);
    }

    struct Arguments {
        shared::HdsFrameParams frame{};
        std::vector<float> table{0.0F};
        std::vector<shared::HdsLight> lights{1};
    };

    /// Runs a kernel for `count` cases. \return what the form of one path gives.
    std::vector<std::uint32_t>
    ExpectSameBits(Program& program, const std::string& kernel, std::size_t count,
                   std::size_t numOut, const std::function<void(LaneRandom&, LaneCase&)>& make,
                   const Arguments& arguments, unsigned seed = 1) {
        LaneRandom random(seed);
        std::vector<float> values;
        for (std::size_t i = 0; i < count; ++i) {
            LaneCase one;
            random.Begin(i);
            make(random, one);
            values.insert(values.end(), one.begin(), one.end());
        }
        const Buffer in = Upload(values);
        const Buffer frame = Upload(std::vector<shared::HdsFrameParams>{arguments.frame});
        const Buffer table = Upload(arguments.table);
        const Buffer lights = Upload(arguments.lights);
        const Buffer one = Allocate(count * numOut * sizeof(float));
        const Buffer wide = Allocate(count * numOut * sizeof(float));
        program.GetKernel(kernel).Launch(count / kLanes, in, one, wide,
                                         std::uint32_t(count / kLanes), frame, table, lights,
                                         std::uint32_t(arguments.lights.size()));
        const std::vector<std::uint32_t> expected = Download<std::uint32_t>(one, count * numOut);
        const std::vector<std::uint32_t> actual = Download<std::uint32_t>(wide, count * numOut);
        std::size_t numDifferent = 0;
        for (std::size_t i = 0; i < count * numOut && numDifferent < 5; ++i) {
            if (expected[i] != actual[i] && !(IsNan(expected[i]) && IsNan(actual[i]))) {
                ++numDifferent;
                ADD_FAILURE() << kernel << ": case " << i / numOut << ", number " << i % numOut
                              << ": one path has " << OfBits(expected[i]) << " (" << std::hex
                              << expected[i] << "), eight have " << OfBits(actual[i]) << " ("
                              << actual[i] << ")";
            }
        }
        return expected;
    }

    /// Copies of a struct of `count` numbers to and from lanes (HDS_TEST_LANES), whatever bits it
    /// has.
    void ExpectLanes(Program& program, const std::string& name, std::size_t count) {
        ExpectSameBits(
            program, name + "Lanes", 4000, 2 * count,
            [&](LaneRandom& r, LaneCase& one) {
                for (std::size_t k = 0; k < count; ++k) {
                    one.push_back(OfBits(r.Bits()));
                }
            },
            Arguments{});
    }

    /// Numbers of the results that are the same in all cases: a text that computes nothing would
    /// have the same bits as well.
    static std::size_t CountConstant(const std::vector<std::uint32_t>& results,
                                     std::size_t numOut) {
        std::size_t numConstant = 0;
        for (std::size_t k = 0; k < numOut; ++k) {
            bool isConstant = true;
            for (std::size_t i = k; i < results.size(); i += numOut) {
                isConstant = isConstant && results[i] == results[k];
            }
            numConstant += isConstant ? 1 : 0;
        }
        return numConstant;
    }

private:
    /// The NaN that operations make, of either sign: which operand gives it the sign is free, and
    /// compilers swap operands. No image holds any: samples that are not finite count as black.
    static bool IsNan(std::uint32_t bits) { return (bits & 0x7fffffffU) == 0x7fc00000U; }

    /// The includes of a program between wideBegin.clh and wideEnd.clh.
    static std::string WideBlock(const std::string& root) {
        for (std::size_t i = 0; i < NumEmbeddedKernels(); ++i) {
            const EmbeddedKernel& file = EmbeddedKernels()[i];
            if (root == file.path) {
                const std::string text(reinterpret_cast<const char*>(file.bytes), file.size);
                const std::string beginLine = "#include \"math/wideBegin.clh\"\n";
                const std::size_t begin = text.find(beginLine) + beginLine.size();
                return text.substr(begin, text.find("#include \"math/wideEnd.clh\"") - begin);
            }
        }
        return "#error no wide block\n";
    }
};

} // namespace hds::test
