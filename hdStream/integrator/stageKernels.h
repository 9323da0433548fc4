// SPDX-License-Identifier: Apache-2.0
// The programs of the wavefront, specialised by the scene's features.
// Features change which code is compiled, never the bits of the image.
#pragma once

#include "hdStream/integrator/sceneBuffers.h"

#include <memory>
#include <vector>

namespace hds {

/// What the kernels are specialised by.
struct KernelFeatures {
    bool cutouts = false;          ///< some material may let rays pass
    bool programs = false;         ///< some material has a program
    bool patterns = false;         ///< some program computes
    std::uint32_t lobes = 0;       ///< HDS_LOBE_* of layered surfaces
    bool textures = false;         ///< some program or some light looks textures up
    bool lightShaping = false;     ///< some light is shaped
    bool lightControls = false;    ///< some light is linked or has controls that are not physical
    bool lightPortals = false;     ///< some dome has portals
    bool meshLights = false;       ///< some light is a mesh
    bool lightGlow = false;        ///< some light is a mesh whose material varies what it emits
    bool lightTree = false;        ///< there are more lights than are weighed one by one
    bool manyTexturePools = false; ///< texels lie in more than one buffer
    bool textureStreaming = false; ///< lines of textures may be missing
    bool plainTextures = false;    ///< textures without lines
    bool groups = false;           ///< instances below instances
    bool curves = false;           ///< curves or points
    bool motion = false;           ///< something moves while the shutter is open
    bool wide = false;             ///< 8-wide traversal inside a work-item
    bool firstHits = false;        ///< first-hit AOVs are asked for: `aov` is built
    bool manyPools = false;        ///< the scene's pages lie in more than one pool buffer
    bool streaming = false;        ///< pages may be missing
    bool requestsFirst = false;    ///< as ResidencyOptions::requestsFirst

    /// Rays that wait keep lists of the chunks they wait for.
    bool HasLists() const { return streaming && !requestsFirst; }

    bool operator==(const KernelFeatures& other) const {
        return cutouts == other.cutouts && programs == other.programs &&
               patterns == other.patterns && lobes == other.lobes && textures == other.textures &&
               lightShaping == other.lightShaping && lightControls == other.lightControls &&
               lightPortals == other.lightPortals && meshLights == other.meshLights &&
               lightGlow == other.lightGlow && lightTree == other.lightTree &&
               manyTexturePools == other.manyTexturePools &&
               textureStreaming == other.textureStreaming && plainTextures == other.plainTextures &&
               groups == other.groups && curves == other.curves && motion == other.motion &&
               wide == other.wide && firstHits == other.firstHits && manyPools == other.manyPools &&
               streaming == other.streaming && requestsFirst == other.requestsFirst;
    }
};

/// All kernels of a render. Externally synchronised.
class StageKernels {
public:
    /// \throws Error with the compiler's log when a kernel does not build.
    StageKernels(const std::shared_ptr<Device>& device, Store* store,
                 const KernelFeatures& features);

    /// Whether all programs of such kernels are in the store.
    static bool AreInStore(const Device& device, const Store& store,
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
    Kernel develop;
    Kernel relativeError;
    Kernel addBlock;

    /// Bytes of path state a path needs with these features.
    std::uint64_t PathStateBytes() const { return PathStateBytes(_features); }
    /// \overload of any features.
    static std::uint64_t PathStateBytes(const KernelFeatures& features);
    double BuildSeconds() const { return _buildSeconds; }
    const KernelFeatures& Features() const { return _features; }

private:
    KernelFeatures _features;
    std::vector<std::unique_ptr<Program>> _unsaved; ///< programs whose binaries are
    double _buildSeconds = 0.0;
};

} // namespace hds
