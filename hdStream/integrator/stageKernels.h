// SPDX-License-Identifier: Apache-2.0
// The programs of the wavefront, specialised by the scene's features.
#pragma once

#include "hdStream/integrator/kernelFeatures.h"
#include "hdStream/integrator/sceneBuffers.h"

#include <memory>
#include <vector>

namespace hds {

/// All kernels of a render. Externally synchronised.
class StageKernels {
public:
    /// \throws Error with the compiler's log when a kernel does not build.
    StageKernels(const std::shared_ptr<Device>& device, Store* store,
                 const KernelFeatures& features);

    /// Such kernels if all of their programs are in the store, else null: nothing is compiled, but
    /// what the driver rejects. \throws Error as the constructor.
    static std::unique_ptr<StageKernels> FromStore(const std::shared_ptr<Device>& device,
                                                   Store* store, const KernelFeatures& features);

    /// Whether all programs of such kernels are in the store.
    static bool AreInStore(const Device& device, const Store& store,
                           const KernelFeatures& features);

    /// Begins to compile what of them is not in the store, where processes compile; never blocks.
    /// \return all their programs.
    static std::vector<ProgramSource> Announce(const Device& device, const Store* store,
                                               const KernelFeatures& features);

    /// Binds a scene to all kernels that read it; again after each SceneBuffers::Update.
    void Bind(const SceneBuffers& scene);

    /// Saves what was built from source and is not saved yet; may take a second. Once.
    void SaveBinaries(Store* store);

    Kernel generateSample;
    Kernel generateCentre;
    Kernel intersect;
    Kernel shade;
    Kernel shadowCast;
    Kernel shadowPass;      ///< only with cut-outs
    Kernel aov;             ///< only with first-hit AOVs
    Kernel intersectResume; ///< only while geometry streams
    Kernel shadowResume;    ///< only while geometry streams
    Kernel resolve;
    Kernel keepSums; ///< only while rays keep lists
    Kernel develop;
    Kernel relativeVariance;
    Kernel relativeError;
    Kernel addBlock;
    Kernel addLightPaths;     ///< with light path expressions alone, as are the next two
    Kernel addLightPathBlock; ///< with catchers and ambient occlusion too
    Kernel developLightPath;
    Kernel keepSamples; ///< with catchers or ambient occlusion alone
    Kernel addCatchers; ///< with catchers alone, as are the next
    Kernel developCatchers;
    Kernel addCaughtVariance;
    Kernel occlusion; ///< with ambient occlusion alone, as are the next two
    Kernel addOcclusion;
    Kernel developOcclusion;

    /// Bytes of path state a path needs with these features.
    std::uint64_t PathStateBytes() const { return PathStateBytes(_features); }
    /// \overload of any features.
    static std::uint64_t PathStateBytes(const KernelFeatures& features);
    /// Where in a path state of one slot a field begins; of n slots it is n times that.
    static std::uint64_t FieldOffset(const KernelFeatures& features, const std::string& field);
    double BuildSeconds() const { return _buildSeconds; }
    const KernelFeatures& Features() const { return _features; }

private:
    /// \param sources of all programs.
    StageKernels(const std::shared_ptr<Device>& device, Store* store,
                 const KernelFeatures& features, const std::vector<ProgramSource>& sources);

    KernelFeatures _features;
    std::vector<std::unique_ptr<Program>> _unsaved; ///< programs whose binaries are
    double _buildSeconds = 0.0;
};

} // namespace hds
