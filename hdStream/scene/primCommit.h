// SPDX-License-Identifier: Apache-2.0
// The part of a commit that does not depend on where prims are: materials, planned geometry, the
// records of prims, the leaves of the hierarchy. Where edits only move, hide or show prims, the
// next commit keeps it; where they change the shape of some as well, all but theirs. Explained in
// docs/session.md.
#pragma once

#include "hdStream/scene/commit.h"
#include "hdStream/scene/hierarchy.h"
#include "hdStream/scene/lightCommit.h"
#include "hdStream/scene/lightLinks.h"
#include "hdStream/scene/materialCommit.h"
#include "hdStream/scene/placeTables.h"

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace hds {

/// Externally synchronised. The scene, the cache and the warnings must outlive it.
class PrimCommit {
public:
    PrimCommit(const SceneDescription& scene, CommitOptions options, CommitCache* cache,
               Warnings& warnings);

    /// Makes it all, once. \return false when `isCancelled` said so.
    bool Run(const CancelCallback& isCancelled);

    /// Whether edits of places leave it as it is. \pre Run has returned true.
    bool OutlivesPlaces() const;

    /// Whether Run would make the same of the scene as it is now, but for tables that nobody
    /// reads. \pre OutlivesPlaces; since Run only places have changed.
    bool IsStillTrue() const;

    enum class Reshaped { Done, Cancelled, Otherwise };

    /// Makes anew what depends on the shape of some prims.
    /// \pre IsStillTrue but for the shapes of the prims at `paths` (LeavesAllButShape).
    /// \return Cancelled: all is as before; Otherwise: Run would make other tables, and this is of
    /// no use any more.
    Reshaped Reshape(const std::set<std::string>& paths, const CancelCallback& isCancelled);

    /// Gives the materials `recoloured` the networks that they have now, where that changes nothing
    /// but numbers of records. \param scene that was made of it, if there is one. \return false:
    /// all has to be made anew.
    bool Recolour(CommittedScene* scene, PlaceChanges* changes);

    /// What has changed of a scene since a commit, beside CommitCache::reshaped and `recoloured`.
    struct Edits {
        std::set<std::string> prims; ///< that have moved, gone or come back, or have another shape
        bool areLights = false;      ///< some have other numbers (LeavesPrims)
    };

    /// Brings the tables of a scene to what prims, materials and lights are now. \pre Run would
    /// make the same; the last commit has made `scene` of it; since then nothing else has changed.
    /// \return Done; else: Cancelled: all is as before; Otherwise: the scene has to be committed.
    /// If prims are still what another commit would make of them, IsStillTrue says so.
    Reshaped Mend(const Edits& edits, CommittedScene* scene, PlaceChanges* changes,
                  const CancelCallback& isCancelled);
    /// Before another commit of it, whose tables are others.
    void ForgetTables();

    const CommitOptions& Options() const { return _options; }

    /// The leaves of the prims that are visible now, in the order of paths.
    std::vector<DrawnLeaf> VisibleLeaves() const;

    /// All leaves, moved out: nothing asks for them again.
    std::vector<DrawnLeaf> TakeLeaves() { return std::move(_leaves); }

    /// What the light table of a scene around `centre` is made of.
    LightCommitInput LightInput(const glm::dvec3& centre) const;

    /// Adds what the prims that are visible now say of the whole scene.
    void Describe(CommittedScene* scene) const;

    CommittedPrims prims;
    MaterialCommit materials;
    std::vector<PrimMaterialInfo> primInfos; ///< by the index of the prim
    LightLinks links;
    std::vector<WorldInstance> worldInstances; ///< of the last scene, where prims are kept
    /// Materials that edits have given other networks; who counts edits adds them.
    std::set<std::string> recoloured;

private:
    using GeometryEntry = GeometryStore::Entry;

    /// A prim that was visible, with what it says of the whole scene.
    struct DrawnPrim {
        const GeometryEntry* entry = nullptr;
        std::uint64_t numPrimitives = 0;
        bool hasChunks = false;
        std::size_t firstLeaf = 0; ///< of its leaves, if it has chunks
        bool mayPass = false;      ///< rays may pass its surface
        bool isGlass = false;      ///< PrimMaterialInfo::isGlass
        bool deforms = false;      ///< while the shutter is open
    };

    /// How many of the prims that the tables of a scene show are of a kind that the whole scene is
    /// said to have, and use a material.
    struct Shown {
        static constexpr std::size_t kNumKinds = 6;
        std::array<std::uint32_t, kNumKinds> kinds{};
        std::map<const CachedMaterial*, std::uint32_t> users;
        bool mayHide = true; ///< no other table knows prims by their number
    };

    /// Who has which records of materials.
    struct Records {
        std::map<const CachedMaterial*, std::set<std::uint32_t>> ofMaterial;
        std::vector<std::uint32_t> numUsers; ///< materials, by record
    };

    std::vector<const GeometryEntry*> FindDrawn();
    std::vector<GeometryStore::Drawn> InputsOf(const std::vector<const GeometryEntry*>& drawn);
    void ReadPrimvars(std::size_t index, const GeometryDescription& geometry,
                      std::vector<std::string>* read) const;
    void AddObjects(std::size_t numDrawn);
    void AddObject(const PlannedGeometry& prepared);
    void AddPrim(std::uint32_t index);
    void AddLeaves(const GeometryEntry& entry, const LeafObject& leaf);
    std::optional<std::vector<std::size_t>> FindReshaped(const std::set<std::string>& paths) const;
    void TakeShape(std::size_t index, GeometryPages* pages);
    std::map<std::string, DicingView>
    FindViews(const std::vector<const GeometryEntry*>& wanted) const;
    bool AreViewsAsBefore() const;
    bool AreViewsAsBefore(const std::vector<const GeometryEntry*>& visible) const;
    std::optional<std::vector<std::size_t>> FindMoved(const std::set<std::string>& paths,
                                                      CommittedScene* scene);
    Reshaped GiveShapes(CommittedScene* scene, PlaceChanges* changes,
                        const CancelCallback& isCancelled);
    void Count(std::size_t index, std::uint64_t numPrimitives, bool isAdded,
               CommittedScene* scene) const;
    void FindRecords();
    std::optional<std::set<std::uint32_t>> RecolourOne(const std::string& path);
    bool MendLights(CommittedScene* scene, PlaceChanges* changes);
    std::array<bool, Shown::kNumKinds> KindsOf(std::size_t index) const;
    bool ArePrimsKnownByNumber() const;
    void CountShown();
    bool HideOrShow(std::size_t index, bool isVisible, CommittedScene* scene);
    std::size_t IndexOf(const std::string& path) const;
    bool AreTablesOfTheVisible() const;

    const SceneDescription& _scene;
    CommitOptions _options;
    CommitCache& _cache;
    Warnings& _warnings;
    InstancePrimvarCollector _instancePrimvars;
    std::vector<DrawnPrim> _drawn;             ///< in the order of paths
    std::vector<const GeometryEntry*> _hidden; ///< would be drawn if they were visible
    std::vector<std::uint32_t> _objectOfDrawn; ///< in the order of paths
    std::vector<DrawnLeaf> _leaves;            ///< in the order of paths
    bool _isSpoilt = false;                    ///< by a Reshape that was Otherwise
    std::map<std::string, DicingView> _views;  ///< of subdivided meshes
    std::optional<Records> _records;           ///< from the first Recolour on
    std::unique_ptr<PlaceTables> _places;      ///< of the last scene, from the first Move on
    std::optional<Shown> _shown;               ///< likewise, from the first that hides or shows
};

} // namespace hds
