// SPDX-License-Identifier: Apache-2.0
// What programs that were written have in them.
#include "hdStream/shading/programWriter.h"
#include "kernels/shared/material.h"
#include "kernels/shared/programMath.h"

#include <cstring>

namespace hds {

namespace {

struct Operation {
    std::uint32_t numOperands;
    bool isPattern;
};

/// By HDS_OP_*.
constexpr Operation kOperations[HDS_NUM_OPERATIONS] = {
#define HDS_OPERATION(NAME, operands, isPattern) {operands, isPattern},
#include "kernels/shared/programOperations.def"
};

std::uint32_t OperationAt(const std::vector<std::uint32_t>& programs, std::size_t at) {
    return programs[at] & 0xffU;
}

/// Operands of an instruction at `at` behind its first word.
std::size_t NumOperands(const std::vector<std::uint32_t>& programs, std::size_t at) {
    const std::uint32_t operation = OperationAt(programs, at);
    std::size_t count = kOperations[operation].numOperands;
    if (operation == HDS_OP_TEXTURE) {
        const std::uint32_t argument = programs[at] >> 8U;
        count += programs[at + 1] + ((argument & HDS_LOOKUP_POPS) != 0 ? 0 : 12);
    }
    return count;
}

bool HasOperation(const std::vector<std::uint32_t>& programs, std::uint32_t operation) {
    for (std::size_t at = 0; at < programs.size(); at += 1 + NumOperands(programs, at)) {
        if (OperationAt(programs, at) == operation) {
            return true;
        }
    }
    return false;
}

} // namespace

std::uint32_t CountLookups(const std::vector<std::uint32_t>& program) {
    std::uint32_t count = 0;
    for (std::size_t at = 0; at < program.size(); at += 1 + NumOperands(program, at)) {
        count += OperationAt(program, at) == HDS_OP_TEXTURE ? 1 : 0;
    }
    return count;
}

bool HasPatterns(const std::vector<std::uint32_t>& programs) {
    for (std::size_t at = 0; at < programs.size(); at += 1 + NumOperands(programs, at)) {
        if (kOperations[OperationAt(programs, at)].isPattern) {
            return true;
        }
    }
    return false;
}

bool HasClosures(const std::vector<std::uint32_t>& programs) {
    for (std::size_t at = 0; at < programs.size(); at += 1 + NumOperands(programs, at)) {
        const std::uint32_t operation = OperationAt(programs, at);
        if (operation == HDS_OP_CHANCE || operation == HDS_OP_INSIDE ||
            (operation == HDS_OP_STORE && (programs[at] >> 8 & 0xffU) == HDS_INPUT_WEIGHT)) {
            return true;
        }
    }
    return false;
}

bool HasTransforms(const std::vector<std::uint32_t>& programs) {
    return HasOperation(programs, HDS_OP_TO_SPACE);
}

bool HasAutobump(const std::vector<std::uint32_t>& programs) {
    return HasOperation(programs, HDS_OP_AUTOBUMP);
}

bool HasInside(const std::vector<std::uint32_t>& programs) {
    return HasOperation(programs, HDS_OP_INSIDE);
}

bool NeedsFilteredTexels(const std::vector<std::uint32_t>& program) {
    for (std::size_t at = 0; at < program.size(); at += 1 + NumOperands(program, at)) {
        const std::uint32_t operation = OperationAt(program, at);
        if (operation == HDS_OP_SHIFT || operation == HDS_OP_CHANCE) {
            return true;
        }
        if (operation == HDS_OP_RESOLVED) { // displacement asks for the filter itself
            at += program[at] >> 8U;
            continue;
        }
        if (operation != HDS_OP_MATH) {
            continue;
        }
        switch ((program[at] >> 8) & 0xffU) {
        case HDS_MATH_ADD:
        case HDS_MATH_SUBTRACT:
        case HDS_MATH_MULTIPLY:
        case HDS_MATH_MIX:
        case HDS_MATH_DOT:
        case HDS_MATH_COMBINE:
            break;
        default:
            return true;
        }
    }
    return false;
}

void OffsetPositions(std::vector<std::uint32_t>* programs, std::uint32_t space,
                     const std::array<float, 3>& offset) {
    for (std::size_t at = 0; at < programs->size(); at += 1 + NumOperands(*programs, at)) {
        std::size_t first = at + 1;
        if (OperationAt(*programs, at) == HDS_OP_TO_SPACE) {
            first += std::size_t{3} * space;
        } else if ((*programs)[at] != HDS_OP(HDS_OP_POSITION, space)) {
            continue;
        }
        for (std::size_t k = 0; k < 3; ++k) {
            float value = 0.0F;
            std::memcpy(&value, &(*programs)[first + k], sizeof(value));
            value += offset[k];
            std::memcpy(&(*programs)[first + k], &value, sizeof(value));
        }
    }
}

} // namespace hds
