// SPDX-License-Identifier: Apache-2.0
// What the kernels of a render are specialised by: the rows of kernels/shared/features.def.
// Features change which code is compiled, never the bits of the image.
#pragma once

#include "hdStream/device/program.h"

#include "kernels/shared/lightPaths.h"
#include "kernels/shared/material.h"
#include "kernels/shared/pathConditions.h"
#include "kernels/shared/residency.h"

#include <cstdint>
#include <string>

namespace hds {

/// A member for each row, off at first.
struct KernelFeatures {
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) type member = off;
#define HDS_VARIANT(member, macro, needs, doc) bool member = false;
#define HDS_PROGRAM_FEATURE(member, doc) bool member = false;
#include "kernels/shared/features.def"

    /// Rays that wait keep lists of the chunks they wait for.
    bool HasLists() const {
        const bool HDS_FEATURE_STREAMING = streaming;
        const bool HDS_REQUEST_FIRST = requestsFirst;
        return HDS_KEEPS_WAIT_LISTS;
    }

    bool operator==(const KernelFeatures& other) const {
        bool isEqual = true;
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) \
    isEqual = isEqual && member == other.member;
#define HDS_VARIANT(member, macro, needs, doc) isEqual = isEqual && member == other.member;
#define HDS_PROGRAM_FEATURE(member, doc) isEqual = isEqual && member == other.member;
#include "kernels/shared/features.def"
        return isEqual;
    }

    /// With what its features need on too.
    KernelFeatures WithNeeds() const {
        KernelFeatures f = *this;
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) \
    if (member != off) {                                      \
        needs;                                                \
    }
#define HDS_VARIANT(member, macro, needs, doc) \
    if (member) {                              \
        needs;                                 \
    }
#include "kernels/shared/features.def"
        return f;
    }

    /// What programs are built with.
    ProgramDefines Defines() const {
        ProgramDefines defines;
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) \
    defines[#macro] = std::to_string(static_cast<std::uint32_t>(member));
#define HDS_VARIANT(member, macro, needs, doc) defines[#macro] = member ? "1" : "0";
#include "kernels/shared/features.def"
        return defines;
    }
};

} // namespace hds
