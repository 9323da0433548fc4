// SPDX-License-Identifier: Apache-2.0
// The sets of kernels that renders of one scene have met, those used last: a driver may hold tens
// of megabytes for each, and a long session of edits meets many.
#pragma once

#include "hdStream/integrator/makeResident.h"
#include "hdStream/integrator/renderOptions.h"
#include "hdStream/integrator/stageKernels.h"

#include <cstdint>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hds {

/// Externally synchronised.
class KernelSets {
public:
    static constexpr std::size_t kMostSets = 16;

    /// \param mostSets kept; others are made again, from the store in a tenth of a second.
    KernelSets(std::shared_ptr<Device> device, Store* store, std::size_t mostSets = kMostSets);

    /// The set with these features, bound to `scene`; valid until the next call. \param sceneNumber
    /// another one whenever what `scene` binds has changed. \param buildSeconds what building it
    /// took is added. \throws Error as StageKernels.
    StageKernels& Get(const KernelFeatures& features, const SceneBuffers& scene,
                      std::uint64_t sceneNumber, double* buildSeconds);

    /// Whether such kernels are there.
    bool Has(const KernelFeatures& features) const;
    /// Whether Get would read them from the store.
    bool AreInStore(const KernelFeatures& features) const;
    KernelPlace PlaceOf(const KernelFeatures& features) const;

    /// The features of the set that a render of `features` begins with: general ones where its own
    /// are not there and renders have not paid for them, else `features`. \param mayWait nobody
    /// looks on, so that kernels may be compiled before it begins.
    KernelFeatures Choose(const KernelFeatures& features, KernelChoice choice, bool mayWait);
    /// Between two waves of a render by general kernels. Begins to compile those of `features` when
    /// it pays. \param secondsLeft of the render. \return whether they have come.
    bool HaveOwnCome(const KernelFeatures& features, double secondsLeft);
    /// A whole render of `features` has spent so long in general kernels; kept in the store.
    void AddGeneralSeconds(const KernelFeatures& features, double seconds);

    /// Keeps in the store which features a render has asked for, for Warm of later processes.
    void Remember(const KernelFeatures& features);
    /// Begins to make those kernels that were asked for last on this device, if the store has them,
    /// on a thread of its own: nothing is compiled. Until EndWarm nothing else may be called.
    void Warm();
    /// Waits for what Warm has begun, if anything.
    void EndWarm();

    /// As StageKernels::SaveBinaries, of all.
    void SaveBinaries();

private:
    /// What was asked for last on this device; none where the store does not tell.
    std::optional<KernelFeatures> LoadRemembered() const;
    StageKernels& Add(std::unique_ptr<StageKernels> kernels);
    /// What is known of kernels that were not in the store when they were looked for: to look again
    /// for each edit and each wave takes longer than an edit.
    struct Lack {
        double generalSeconds = 0.0; ///< that renders have spent without them
        std::vector<ProgramSource>
            awaited; ///< their programs, once they are compiled beside a render
    };

    Lack* FindLack(const KernelFeatures& features);

    struct Set {
        std::unique_ptr<StageKernels> kernels;
        std::uint64_t boundScene = 0; ///< 0: none
    };

    std::shared_ptr<Device> _device;
    Store* _store;
    std::size_t _mostSets;
    std::vector<Set> _sets;                             ///< used last comes last
    std::optional<KernelFeatures> _remembered;          ///< what the store has
    std::map<std::string, Lack> _lacking;               ///< by key of features
    std::future<std::unique_ptr<StageKernels>> _warmed; ///< last: the thread uses all the rest
};

} // namespace hds
