// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/generalKernels.h"

#include "hdStream/integrator/makeResident.h"

#include <algorithm>
#include <iterator>

namespace hds {

namespace {

/// Part of a render's time that kernels of its own save. Measured: docs/decisions/0016.
constexpr double kSavedPart = 0.15;

/// Of a switch, a mask, or a count that has one value beside that for all.
bool HasAllOf(std::uint32_t general, std::uint32_t features) {
    return (features & ~general) == 0;
}

/// The form of rays and the programs are those of `features`. Not here: what few scenes have and
/// others would pay for, and what is unknown to the form of shading for eight paths
/// (HDS_SHADE_WIDE).
KernelFeatures MakeGeneral(const KernelFeatures& features, bool isLayered) {
    KernelFeatures general;
    general.simd8 = features.simd8;
    general.flat = features.flat;
    general.flatInstances = features.flat;
    general.flatCopies = features.flat;
    general.streaming = features.streaming;
    general.firstHits = features.firstHits;
    general.textures = true;
    general.textureStreaming = features.textureStreaming || !features.textures;
    general.cutouts = true;
    general.programs = true;
    general.patterns = true;
    general.lightShaping = true;
    general.lightPortals = true;
    general.domeGuide = true;
    general.lightTree = true;
    general.meshLights = true;
    general.groups = true;
    if (isLayered) {
        // Coats with frames are sampled before what lies below them, and others after that: where
        // none has one, kernels that know frames have other bits.
        general.lobes = HDS_LOBES_ALL & ~(HDS_LOBES_ALONE | HDS_LOBE_RETRO | HDS_LOBE_COVERED |
                                          (~features.lobes & HDS_LOBE_COAT_FRAME));
        general.media = true;
        general.closures = true;
        general.texturedEmission = true;
        general.instancePrimvars = true;
    }
    return general;
}

} // namespace

bool Covers(const KernelFeatures& general, const KernelFeatures& features) {
    bool isCovered = true;
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) \
    isCovered = isCovered && HasAllOf(general.member, features.member);
#define HDS_VARIANT(member, macro, needs, doc) \
    isCovered = isCovered && HasAllOf(general.member, features.member);
#define HDS_PROGRAM_FEATURE(member, doc) \
    isCovered = isCovered && HasAllOf(general.member, features.member);
#include "kernels/shared/features.def"
    return isCovered;
}

std::vector<KernelFeatures> GeneralFeatures(const KernelFeatures& features) {
    std::vector<KernelFeatures> sets = {MakeGeneral(features, false), MakeGeneral(features, true)};
    sets.erase(std::remove_if(sets.begin(), sets.end(),
                              [&](const KernelFeatures& set) { return !Covers(set, features); }),
               sets.end());
    return sets;
}

std::vector<KernelFeatures> AllGeneralFeatures() {
    KernelFeatures resident;
    resident.simd8 = true;
    resident.firstHits = true;
    KernelFeatures flat = resident;
    flat.flat = true;
    KernelFeatures streaming = resident;
    streaming.streaming = true;
    std::vector<KernelFeatures> all;
    for (const KernelFeatures& form : {flat, streaming, resident}) {
        const std::vector<KernelFeatures> sets = GeneralFeatures(form);
        std::copy(sets.begin(), sets.end(), std::back_inserter(all));
    }
    return all;
}

bool PayForOwnKernels(double seconds) {
    return kSavedPart * seconds >= SecondsToGet(KernelPlace::Nowhere);
}

bool EndsBeforeOwnKernels(double secondsLeft) {
    return secondsLeft < SecondsToGet(KernelPlace::Nowhere);
}

} // namespace hds
