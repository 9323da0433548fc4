// SPDX-License-Identifier: Apache-2.0
// A committed scene in device memory, and its place in the kernels' signatures.
#pragma once

#include "hdStream/device/program.h"
#include "hdStream/integrator/flatGeometry.h"
#include "hdStream/integrator/kernelFeatures.h"
#include "hdStream/integrator/renderOptions.h"
#include "hdStream/integrator/residencyPlan.h"
#include "hdStream/integrator/sceneTextures.h"
#include "hdStream/scene/commit.h"
#include "hdStream/scene/placeTables.h"
#include "hdStream/stream/streamingPool.h"

#include <array>
#include <memory>

namespace hds {

/// Buffers of all scene tables, kept from one version of the scene to the next. Externally
/// synchronised.
class SceneBuffers {
public:
    /// \param store keeps compiled kernels, may be null.
    SceneBuffers(std::shared_ptr<Device> device, Store* store);

    /// Uploads what is new in `scene`, which must live until the next call: CPU devices read its
    /// large tables in place. Blocks. \return false
    /// when the pages of edited scenes have scattered the pool: start again with new SceneBuffers.
    /// \throws Error when the scene does not fit the device.
    bool Update(const CommittedScene& scene, const ResidencyOptions& residency);

    /// Uploads what is mended of the scene of the last Update. Blocks. Where no pages are others
    /// kernels stay bound. \return false, and \throws, as Update.
    bool TakePlaces(const CommittedScene& scene, const PlaceChanges& changes,
                    const ResidencyOptions& residency);

    /// Sets the arguments of HDS_GEOMETRY_ARGS from `first` on; returns the next free index.
    /// \param features of the kernel: at least what the scene needs.
    unsigned BindGeometry(Kernel* kernel, unsigned first, const KernelFeatures& features) const;

    /// Sets the arguments of HDS_SCENE_ARGS (geometry, materials, lights, and what only some
    /// kernels know) from `first` on.
    unsigned BindScene(Kernel* kernel, unsigned first, const KernelFeatures& features) const;

    /// Whether kernels that are bound from here on see nothing but catchers, and lights.
    void ShowCatchersAlone(bool isAlone) { _showsCatchersAlone = isAlone; }

    /// Whether some material has a program, and whether some program or light looks textures up.
    bool HasPrograms() const { return _hasPrograms; }
    bool HasTextures() const { return _hasTextures; }
    /// Whether some primvar has a value an instance.
    bool HasInstancePrimvars() const { return _hasInstancePrimvars; }
    /// \return true when it has changed: kernels have to be bound again.
    bool SetMipBias(float bias);
    SceneTextures& Textures() { return _textures; }
    const SceneTextures& Textures() const { return _textures; }

    /// Where Update puts the geometry of a scene, be it at first only.
    ResidencyPlan Plan(const CommittedScene& scene, const ResidencyOptions& residency) const;
    /// Whether pages of geometry may be missing.
    bool IsStreaming() const { return _streaming != nullptr && !_isFullyResident; }
    bool IsMapped() const { return _pool != nullptr && _poolKind == PoolKind::Mapped; }
    /// Whether it lies in a pool made for streaming.
    bool HasStreamingPool() const { return _streaming != nullptr; }
    /// \pre HasStreamingPool.
    StreamingPool& Streaming() { return *_streaming; }
    const StreamingPool& Streaming() const { return *_streaming; }

    /// Whether geometry that streams may become resident where it is: all of it fits the pool, and
    /// the design of the report, which knows nothing of this, was not asked for.
    bool MayBecomeResident() const;
    /// Loads some of the pages that are missing, which nobody has asked for. With the last one
    /// geometry is resident; when there is no room for one it never MayBecomeResident. Blocks.
    void LoadMissing();

    /// Builds the flat hierarchy of the scene of the last Update, unless it is there. Blocks.
    /// \pre geometry is resident, nothing moves. \return whether it is new: kernels have to be
    /// bound again.
    bool Flatten(const CommittedScene& scene, const FlatLimits& limits);
    const FlatGeometry& Flat() const { return _flat; }

    /// Gives the domes that may have one a guide (BuildDomeGuide), or takes it away: no cells.
    /// \return whether tables are others: kernels have to be bound again.
    bool SetDomeGuide(const std::array<float, 3>& camera, const std::vector<std::uint32_t>& cells);

    /// Statistics of geometry and textures count from 0 again.
    void BeginStatistics();
    /// Of geometry since then; what resident geometry has done in the words of streaming.
    StreamingStatistics PoolStatistics() const;
    /// Adds to them what only the device knows; at the end of a render. Blocks.
    void CountUsed();
    std::uint32_t NumPoolBuffers() const { return _pool ? _pool->NumBuffers() : 0; }
    /// Of geometry; 0 before the first Update.
    std::uint64_t PoolBytes() const { return _pool ? _pool->Bytes() : 0; }
    std::uint64_t PinnedBytes() const { return _pool ? _pool->PinnedBytes() : 0; }
    /// The most bytes of its pages that were resident at a time since BeginStatistics.
    std::uint64_t PeakUsedBytes() const { return _pool ? _pool->PeakUsedBytes() : 0; }
    std::uint64_t TableBytes() const;
    /// Of them those that are not of textures.
    std::uint64_t GeometryTableBytes() const;

private:
    /// The tables in device memory, in the order of the constructor's labels.
    enum Table {
        TopNodes,
        Instances,
        InstancesByPath,
        Objects,
        Prims,
        PrimMaterials,
        Materials,
        LightByEntry,
        Lights,
        LightNodes,
        LightTriangles,
        LightCdf,
        Programs,
        MotionKeys,
        Volumes,
        Grids,
        GridTiles,
        GridCells,
        BrickBounds,
        VolumeTerms,
        FirstInstanceSlots,
        InstanceSlots,
        InstanceValues,
        CatchersAlone,
        MeshMedia,
        NumTables
    };

    void MakePool(PoolKind kind, const ResidencyOptions& residency);
    bool UpdatePages(const CommittedScene& scene, const ResidencyOptions& residency);
    bool ServesPages(const CommittedScene& scene, const ResidencyPlan& plan,
                     const ResidencyOptions& residency) const;
    template <typename T>
    void Upload(Table table, const std::vector<T>& values);
    /// Of tables that grow with the scene: CPU devices read large ones where they are.
    template <typename T>
    void Upload(Table table, const HugeVector<T>& values);
    void Upload(Table table, const void* values, std::uint64_t bytes);
    /// Elements of a table that has as many as before.
    void UploadLights(const CommittedScene& scene);
    template <typename Values>
    void UploadParts(Table table, const Values& values, const std::vector<std::uint32_t>& parts);
    void UploadBrickBounds(const CommittedVolumes& volumes);

    std::shared_ptr<Device> _device;
    std::unique_ptr<PagePool> _pool; ///< of geometry, from the first Update on
    PoolKind _poolKind = PoolKind::Resident;
    StreamingPool* _streaming = nullptr;         ///< _pool, if that is made for streaming
    ResidencyOptions _residency;                 ///< what _pool was made with
    std::shared_ptr<const GeometryPages> _pages; ///< that _pool serves
    std::uint64_t _budgetBytes = 0;              ///< with so many bytes
    bool _isFullyResident = false;               ///< _streaming holds all pages for good
    bool _isScattered = false;                   ///< it has no room for all, until the next Update
    std::array<Buffer, NumTables> _tables;
    std::array<bool, NumTables> _isInPlace{};  ///< in the memory of the scene
    std::shared_ptr<const LightTable> _lights; ///< what the light tables hold
    std::uint32_t _numLights = 0;
    bool _hasDomeGuide = false;
    PreparedGrids _boundedGrids; ///< whose bounds are in BrickBounds
    std::uint32_t _numVolumes = 0;
    FlatGeometry _flat;
    SceneTextures _textures;
    bool _hasPrograms = false;
    bool _hasTextures = false;
    bool _hasInstancePrimvars = false;
    bool _showsCatchersAlone = false;
};

} // namespace hds
