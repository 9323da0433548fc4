// SPDX-License-Identifier: Apache-2.0
// Commit: the described scene becomes the host images of all device tables. Knows no device.
// Explained in docs/architecture.md.
#pragma once

#include "hdStream/accel/geometryPages.h"
#include "hdStream/base/hugePages.h"
#include "hdStream/base/log.h"
#include "hdStream/persist/pageKey.h"
#include "hdStream/scene/dicingViews.h"
#include "hdStream/scene/geometryStore.h"
#include "hdStream/scene/imageLibrary.h"
#include "hdStream/scene/instancePrimvars.h"
#include "hdStream/scene/materialCommit.h"
#include "hdStream/scene/mediaBounds.h"
#include "hdStream/scene/sceneColors.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/scene/sceneLines.h"
#include "hdStream/scene/transforms.h"
#include "hdStream/scene/volumeCommit.h"
#include "hdStream/shading/lightTable.h"
#include "hdStream/texture/textureLines.h"
#include "kernels/shared/geometry.h"
#include "kernels/shared/material.h"

#include <glm/vec3.hpp>

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace hds {

class PrimCommit;

/// How subdivision surfaces are drawn (docs/geometry.md).
enum class Subdivision {
    Adaptive,   ///< the limit surface, as fine as its size on the dicing camera's image asks for
    Complexity, ///< one level for all meshes; 0: as Cage
    Cage,       ///< as authored, not subdivided
};

/// What decides which prims are drawn and how they are cut.
struct CommitOptions {
    std::vector<std::string> purposes;        ///< drawn
    std::vector<std::string> drawnPaths;      ///< at and below which prims are; empty: all are
    std::vector<std::string> hiddenPaths;     ///< at and below which none is
    CullStyle cullStyle = CullStyle::Nothing; ///< of prims that say DontCare
    bool domeVisible = true;                  ///< domes are seen by camera rays
    bool lightsVisible = true;                ///< and so are other lights that are no meshes
    std::uint64_t chunkBytes = 1U << 17U;     ///< about what the pages of a chunk take at most
    /// Instances of instancers, of a group or of the TLAS, from so many on, lie in chunks; 0: they
    /// never do.
    std::uint32_t instanceChunks = 0;
    Subdivision subdivision = Subdivision::Adaptive;
    std::uint32_t refineLevel = 0;          ///< for Subdivision::Complexity
    std::vector<std::string> shownPrimvars; ///< kept for AOVs, whether materials read them or not
    bool keepsNames = false;                ///< of prims and materials
    std::string workingSpace;  ///< of all colours; empty: the configuration's scene_linear role
    bool glassShadows = false; ///< shadow rays pass smooth refracting surfaces straight
    bool autobump = true;      ///< shading adds what dicing leaves of displacement
    /// For Subdivision::Adaptive; nothing: no surface is on screen.
    std::optional<DicingCamera> dicingCamera;
    Shutter shutter; ///< closed: no motion blur

    static constexpr auto Fields() {
        return FieldList(
            HDS_FIELD(CommitOptions, purposes), HDS_FIELD(CommitOptions, drawnPaths),
            HDS_FIELD(CommitOptions, hiddenPaths), HDS_FIELD(CommitOptions, cullStyle),
            HDS_FIELD(CommitOptions, domeVisible), HDS_FIELD(CommitOptions, lightsVisible),
            HDS_FIELD(CommitOptions, chunkBytes), HDS_FIELD(CommitOptions, instanceChunks),
            HDS_FIELD(CommitOptions, subdivision), HDS_FIELD(CommitOptions, refineLevel),
            HDS_FIELD(CommitOptions, shownPrimvars), HDS_FIELD(CommitOptions, keepsNames),
            HDS_FIELD(CommitOptions, workingSpace), HDS_FIELD(CommitOptions, glassShadows),
            HDS_FIELD(CommitOptions, autobump), HDS_FIELD(CommitOptions, dicingCamera),
            HDS_FIELD(CommitOptions, shutter));
    }
};

/// What an emission is looked up in.
struct EmissionImage {
    std::shared_ptr<const HeightImage> image; ///< null: it cannot be read
    bool isUsed = false;                      ///< in the present commit
};

/// What commits of one scene share: whatever did not change is not made again. Results do not
/// depend on what is in it. Externally synchronised.
struct CommitCache {
    explicit CommitCache(Warnings& warnings)
        : images(warnings), textures(std::make_shared<TexturePreparer>(nullptr, &warnings)),
          grids(std::make_shared<GridPreparer>(nullptr, &warnings)) {}
    SceneColors colors;
    GeometryStore geometry;
    ClosedMeshes closedMeshes; ///< of meshes that a medium fills
    PreparedPages pages;
    ImageLibrary images;
    MaterialCache materials;
    std::shared_ptr<TexturePreparer> textures; ///< never null
    /// What EmissionGuess has read for the scene as it is, by texture and factors.
    std::map<std::string, EmissionImage> emissionImages;
    std::shared_ptr<GridPreparer> grids; ///< never null
    PageKey lightKey;                    ///< all that `lights` is made of
    std::shared_ptr<const LightTable> lights;
    /// Counts edits of the scene that do not leave prims as they are (scene/primEdits.h); 0: who
    /// commits does not count them, and nothing of prims is kept.
    std::uint64_t contentVersion = 0;
    std::shared_ptr<PrimCommit> prims; ///< of the last commit that made any, where they may stay
    std::uint64_t primsVersion = 0;    ///< contentVersion of then
    /// Prims of which edits since then have left all but the shape; who counts edits adds them.
    std::set<std::string> reshaped;
};

/// Counts for the statistics and `hdstream info`.
struct SceneCounts {
    std::uint64_t meshes = 0;
    std::uint64_t instances = 0; ///< leaf instances
    std::uint64_t triangles = 0; ///< unique; an upper bound where surfaces are subdivided
    std::uint64_t curves = 0;    ///< as authored
    std::uint64_t points = 0;    ///< that are spheres
    std::uint64_t splats = 0;    ///< Gaussian
    std::uint64_t chunks = 0;
    std::uint64_t alwaysResidentBytes = 0; ///< nodes above the chunks, records, tables
    std::uint64_t textures = 0;
    std::uint64_t textureSourceBytes = 0; ///< decoded base levels
    std::uint64_t lights = 0;
    std::uint64_t emissiveTriangles = 0;
    std::uint64_t volumes = 0; ///< that are drawn
    std::uint64_t grids = 0;
    std::uint64_t bricks = 0;
    std::uint64_t volumeTableBytes = 0;
};

/// The host images that do not depend on where prims are.
struct CommittedPrims {
    HugeVector<shared::HdsBvhNode> topNodes; ///< of a scene those of its groups come behind
    std::vector<shared::HdsObject> objects;  ///< 0: the TLAS
    std::vector<shared::HdsPrim> prims;
    /// User primvars of each prim, in the order of their slots; owned by the cache, valid until the
    /// next commit.
    std::vector<const std::vector<AttributeName>*> primAttributes;
    InstancePrimvars instancePrimvars;
    /// With CommitOptions::keepsNames, by what AuthoredPrim and AuthoredEntry give: films that go
    /// on in scenes with other tables have counted by these numbers.
    std::vector<std::string> primPaths;
    std::vector<std::string> entryMaterials; ///< paths of materials
    /// Of each prim, and of each entry of `primMaterials`, its number by the order of prims, where
    /// instance chunks have given them others (scene/pagedTables.h); empty: these are the same.
    std::vector<std::uint32_t> authoredPrims;
    std::vector<std::uint32_t> authoredEntries;
    std::uint32_t AuthoredPrim(std::uint32_t prim) const {
        return authoredPrims.empty() ? prim : authoredPrims[prim];
    }
    std::uint32_t AuthoredEntry(std::uint32_t entry) const {
        return authoredEntries.empty() ? entry : authoredEntries[entry];
    }
    /// Prepared when they are needed; in the cache's memory. Scenes whose prims differ in their
    /// places alone may share them.
    std::shared_ptr<GeometryPages> pages;
};

/// Host images of the device tables. Immutable but for pages that are prepared. The cache must
/// outlive it.
struct CommittedScene : CommittedPrims {
    glm::dvec3 centre{0.0}; ///< world position of the device's origin
    HugeVector<shared::HdsInstance> instances;
    HugeVector<shared::HdsInstance> catchersAlone; ///< `instances` with all others unseen
    HugeVector<std::uint32_t> instancesByPath;
    std::vector<AffineRows> motionKeys; ///< of instances
    std::vector<std::uint32_t> primMaterials;
    std::vector<shared::HdsMaterial> materials;
    std::vector<std::uint32_t> programs;        ///< of the materials (kernels/shared/program.h)
    std::vector<MaterialTexture> textureTable;  ///< of lights, then what programs look up
    std::uint32_t maxLookups = 0;               ///< of textures to shade a point, at most
    std::unique_ptr<TextureLines> textureLines; ///< of textureTable; opened when they are needed
    CommittedVolumes volumes;
    std::vector<shared::HdsMeshMedium> meshMedia; ///< that fill meshes
    MediaBounds mediaBounds;                      ///< of these meshes
    std::unique_ptr<SceneLines> lines;            ///< of textures, then of the grids of volumes
    ImageLibrary* images = nullptr;               ///< the cache's
    std::shared_ptr<const LightTable> lights;
    std::vector<std::uint32_t> lightByEntry; ///< HDS_MESH_LIGHT of emissive material entries
    std::vector<TextureUse> textures;        ///< images of materials and lights
    bool hasCutouts = false;
    bool hasPatterns = false;   ///< some program computes (HDS_FEATURE_PATTERNS)
    bool hasClosures = false;   ///< some hit takes one of several (HDS_FEATURE_CLOSURES)
    bool hasTransforms = false; ///< some program changes spaces (HDS_FEATURE_TRANSFORMS)
    bool hasAutobump = false;   ///< some displaced surface is bumped (HDS_FEATURE_AUTOBUMP)
    std::uint32_t lobes = 0;    ///< HDS_LOBE_* of layered surfaces
    bool hasGroups = false;     ///< instances below instances
    bool hasInstanceChunks = false;
    float flatPart = 1.0F;  ///< Hierarchy::flatPart
    bool hasCurves = false; ///< or points, or splats
    bool hasSplats = false;
    bool hasHair = false;          ///< some material is hair
    bool hasWorkingSpace = false;  ///< black bodies are converted to another space than Rec.709
    bool hasMedia = false;         ///< some material scatters light below its surface
    bool hasGlassShadows = false;  ///< shadow rays pass some refracting surface
    bool hasRayVisibility = false; ///< some prim is not seen by all rays, or is held out
    bool hasCatchers = false;      ///< some prim shows only what others do to its light
    bool hasMotion = false;        ///< something moves while the shutter is open
    SceneCounts counts;
    double seconds = 0.0;
};

/// The slot of each primvar of each prim, HDS_NONE where it has none: [numPrims][names.size()].
std::vector<std::uint32_t> FindSlots(const CommittedScene& scene,
                                     const std::vector<std::string>& names);

/// Interprets the scene. Content problems warn and fall back; nothing throws for them.
/// \return null when `isCancelled` said so.
std::unique_ptr<CommittedScene> CommitScene(const SceneDescription& scene,
                                            const CommitOptions& options, CommitCache* cache,
                                            Warnings& warnings,
                                            const CancelCallback& isCancelled = {});

} // namespace hds
