// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/volumeCommit.h"

#include "hdStream/scene/motion.h"
#include "hdStream/scene/movingGrid.h"
#include "hdStream/scene/placements.h"
#include "hdStream/scene/volumeTerms.h"
#include "hdStream/shading/programWriter.h"
#include "kernels/shared/frame.h"

#include <glm/common.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

namespace hds {

namespace {

/// What glows beside its density has so many collisions on the way through a brick, about.
constexpr double kGlowCollisions = 4.0;
/// Every ray looks at each of them.
constexpr std::uint32_t kMaxVolumes = 4096;
/// Names that hosts give to the field of velocities, in object space a second.
constexpr const char* kVelocities[] = {"velocities", "velocity", "vel", "v"};
/// Voxels that a volume may move while the shutter is open: bounds of cells would say nothing.
constexpr double kMaxShift = 4096.0;
/// Lines that eight voxels around a point may lie in.
constexpr std::uint32_t kLinesAround = 8;

void StoreVector(glm::dvec3 v, float* out) {
    for (int i = 0; i < 3; ++i) {
        out[i] = static_cast<float>(v[i]);
    }
}

/// Rows of an affine map.
void StoreRows(const glm::dmat4& map, float* out) {
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
            out[4 * row + column] = static_cast<float>(map[column][row]);
        }
    }
}

/// Where the terms of a volume are in the tables, once for all its placements.
struct PlacedTerms {
    std::uint32_t number = HDS_NONE;     ///< HDS_NONE: it has none
    std::uint32_t extinction = HDS_NONE; ///< grids of bounds
    std::uint32_t emission = HDS_NONE;
    glm::dvec3 least{0.0}; ///< box of the lattice
    glm::dvec3 most{0.0};
};

/// The grids that light meets.
struct VolumeGrids {
    std::shared_ptr<const PreparedGrid> density; ///< whose voxels the lattice has
    PlacedTerms terms;
    PreparedGrids emission;                          ///< empty, one, or red, green and blue
    std::shared_ptr<const PreparedGrid> temperature; ///< may be null
    GridVelocity velocity;                           ///< of the density's lattice
};

/// Collects the tables.
class VolumeTables {
public:
    VolumeTables(glm::dvec3 centre, std::uint32_t numTextures, std::uint32_t firstWord)
        : _centre(centre), _numTextures(numTextures), _firstWord(firstWord) {}

    /// \pre the grids are valid and the volume has a density.
    void Add(const MovingTransform& worldFromObject, const VolumeShading& shading,
             const VolumeGrids& grids, std::uint32_t identity, std::uint32_t linkSet) {
        const GridDescription& lattice = grids.density->description;
        shared::HdsVolume volume{};
        const glm::dmat4 worldFromLattice = worldFromObject.AtFrame() * lattice.objectFromIndex;
        glm::dvec3 least(lattice.first - 1);
        glm::dvec3 most(lattice.first + lattice.size);
        volume.velocity.grid = HDS_NONE;
        volume.terms = grids.terms.number;
        const bool hasTerms = volume.terms != HDS_NONE;
        if (!hasTerms) {
            _bounded.insert(grids.density.get());
        }
        if (hasTerms) {
            least = grids.terms.least;
            most = grids.terms.most;
            volume.fields[HDS_FIELD_DENSITY].grid = grids.terms.extinction;
            volume.fields[HDS_FIELD_DENSITY].flags = HDS_FIELD_IS_ALIGNED;
        } else if (grids.velocity.grids.empty()) {
            volume.fields[HDS_FIELD_DENSITY] = Field({grids.density}, lattice);
        } else {
            volume.fields[HDS_FIELD_DENSITY].grid = MovingGridOf(grids, lattice);
            volume.fields[HDS_FIELD_DENSITY].flags = HDS_FIELD_IS_ALIGNED;
        }
        if (!grids.velocity.grids.empty()) {
            Move(grids, lattice, &volume);
        }
        volume.fields[HDS_FIELD_EMISSION] = volume.fields[HDS_FIELD_DENSITY];
        volume.fields[HDS_FIELD_TEMPERATURE].grid = HDS_NONE;
        if (hasTerms) {
            volume.fields[HDS_FIELD_EMISSION].grid = grids.terms.emission;
        } else if (!grids.emission.empty()) {
            volume.fields[HDS_FIELD_EMISSION] = Field(grids.emission, lattice);
            ExtendBox(grids.emission[0]->description, lattice, &least, &most);
            StoreVector(shading.emission, volume.emission);
        }
        if (grids.temperature) {
            volume.fields[HDS_FIELD_TEMPERATURE] = Field({grids.temperature}, lattice);
            ExtendBox(grids.temperature->description, lattice, &least, &most);
            StoreVector(shading.blackbody, volume.blackbody);
        }
        if (!grids.velocity.grids.empty()) {
            const VoxelShift shift = ShiftOf(grids.velocity);
            least -= shift.most;
            most -= shift.least;
        }
        PlaceBox(worldFromLattice, least, most, &volume);
        AddKeys(worldFromObject, lattice, least, most, &volume);
        const glm::vec3 extinction =
            hasTerms ? glm::vec3(1.0F) : shading.absorption + shading.scattering;
        StoreVector(extinction, volume.extinction);
        volume.most = std::max({extinction.x, extinction.y, extinction.z});
        for (int i = 0; i < 3; ++i) {
            volume.albedo[i] = extinction[i] > 0.0F ? shading.scattering[i] / extinction[i] : 0.0F;
        }
        volume.asymmetry = std::clamp(shading.anisotropy, -0.98F, 0.98F);
        volume.kelvin = shading.kelvin;
        const bool glows = (!grids.emission.empty() && shading.emission != glm::vec3(0.0F)) ||
                           (grids.temperature && shading.blackbody != glm::vec3(0.0F)) ||
                           grids.terms.emission != HDS_NONE;
        const double voxel = std::cbrt(std::abs(glm::determinant(glm::dmat3(worldFromLattice))));
        volume.emissionRate =
            glows ? static_cast<float>(kGlowCollisions / (HDS_BRICK_VOXELS * voxel)) : 0.0F;
        volume.identity = identity;
        volume.linkSet = linkSet;
        result.volumes.push_back(volume);
    }

    /// The tables of a volume's terms. \param velocity of their lattice.
    PlacedTerms AddTerms(const TermPlan& plan, bool turnsVary, const GridVelocity& velocity) {
        const GridDescription& lattice = plan.Lattice();
        PlacedTerms placed;
        placed.least = plan.least;
        placed.most = plan.most;
        if (!MayBound(placed.least, placed.most)) {
            return placed;
        }
        shared::HdsVolumeTerms record{};
        record.numTerms = static_cast<std::uint32_t>(plan.terms.size());
        record.numMedium = plan.numMedium;
        record.flags = turnsVary ? HDS_TERMS_TURN : 0U;
        result.havePatterns = result.havePatterns || turnsVary;
        StoreRows(lattice.objectFromIndex, record.objectFromLattice);
        std::copy(plan.terms.begin(), plan.terms.end(), record.terms);
        std::uint32_t numLines = 0;
        for (std::size_t i = 0; i < plan.fields.size(); ++i) {
            const PlannedField& field = plan.fields[i];
            record.fields[i] =
                field.pattern ? Pattern(*field.pattern) : Field(field.grids, lattice);
            numLines += static_cast<std::uint32_t>(field.grids.size());
        }
        numLines += LinesOfPatterns(plan);
        result.linesOfTerms = std::max(result.linesOfTerms, numLines);
        placed.number = static_cast<std::uint32_t>(result.terms.size());
        result.terms.push_back(record);
        const TermBounds bounds = BoundTerms(plan);
        placed.extinction = AddBounds(
            velocity.grids.empty() ? GridTiles{bounds.extinction.record, bounds.extinction.tiles,
                                               bounds.extinction.cells}
                                   : SpreadGrid(bounds.extinction, velocity));
        if (!bounds.emission.tiles.empty()) {
            placed.emission = AddBounds(bounds.emission);
        }
        return placed;
    }

    /// Says where bounds of bricks lie. Nothing is added afterwards.
    void Finish() {
        std::map<std::uint32_t, std::uint32_t> firstBricks; // by texture
        for (const std::shared_ptr<const PreparedGrid>& grid : result.prepared) {
            if (_bounded.count(grid.get()) != 0) {
                firstBricks[TextureOf(grid)] = static_cast<std::uint32_t>(result.numBoundedBricks);
                result.bounded.push_back(grid);
                result.numBoundedBricks += grid->description.numBricks;
            }
        }
        for (shared::HdsGrid& grid : result.grids) {
            const auto found = firstBricks.find(grid.texture);
            grid.firstBrick = found == firstBricks.end() ? 0 : found->second;
        }
    }

    CommittedVolumes result;

private:
    /// Cells that have no voxels.
    std::uint32_t AddBounds(const GridTiles& bounds) {
        AddGrid(bounds.record, bounds.tiles, bounds.cells, HDS_NONE);
        return static_cast<std::uint32_t>(result.grids.size() - 1);
    }

    void PlaceBox(const glm::dmat4& worldFromLattice, glm::dvec3 least, glm::dvec3 most,
                  shared::HdsVolume* volume) const {
        const glm::dvec3 middle = 0.5 * (least + most);
        const glm::dmat3 inwards = glm::inverse(glm::dmat3(worldFromLattice));
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) {
                volume->latticeFromWorld[3 * row + column] =
                    static_cast<float>(inwards[column][row]);
            }
        }
        StoreVector(glm::dvec3(worldFromLattice * glm::dvec4(middle, 1.0)) - _centre,
                    volume->worldCentre);
        StoreVector(middle, volume->latticeCentre);
        StoreVector(least, volume->boxMin);
        StoreVector(most, volume->boxMax);
    }

    /// \param least, most the box in the lattice.
    void AddKeys(const MovingTransform& worldFromObject, const GridDescription& lattice,
                 glm::dvec3 least, glm::dvec3 most, shared::HdsVolume* volume) {
        if (!worldFromObject.Moves()) {
            return;
        }
        result.haveMotion = true;
        const glm::dmat4 identity(1.0);
        const MovingTransform place =
            MovingTransform(glm::translate(identity, -_centre)) * worldFromObject *
            MovingTransform(lattice.objectFromIndex *
                            glm::translate(identity, 0.5 * (least + most)));
        const Bounds bounds{glm::vec3(0.5 * (least - most)), glm::vec3(0.5 * (most - least))};
        const std::vector<glm::dmat4> keys = MakeMotionKeys(place, bounds);
        volume->firstKey = static_cast<std::uint32_t>(result.motionKeys.size());
        volume->numSegments = static_cast<std::uint32_t>(keys.size() - 1);
        for (const glm::dmat4& key : keys) {
            result.motionKeys.push_back(RowsFromMatrix(key));
        }
    }

    /// Adds the program of a pattern.
    shared::HdsVolumeField Pattern(const PlannedPattern& pattern) {
        shared::HdsVolumeField field{};
        field.grid = _firstWord + static_cast<std::uint32_t>(result.programs.size());
        field.flags = HDS_FIELD_IS_PATTERN;
        for (const std::uint32_t number : pattern.fields) {
            field.flags |= 1U << (HDS_FIELD_READS_SHIFT + number);
        }
        result.programs.insert(result.programs.end(), pattern.program.begin(),
                               pattern.program.end());
        result.havePatterns = true;
        return field;
    }

    /// Lines of bricks that the patterns of a volume read at a point; counts their look-ups too.
    std::uint32_t LinesOfPatterns(const TermPlan& plan) {
        std::set<std::uint32_t> read;
        std::uint32_t numLookups = 0;
        for (const PlannedField& field : plan.fields) {
            if (field.pattern) {
                read.insert(field.pattern->fields.begin(), field.pattern->fields.end());
                numLookups += CountLookups(field.pattern->program);
            }
        }
        result.maxLookups = std::max(result.maxLookups, numLookups);
        std::uint32_t numGrids = 0;
        for (const std::uint32_t number : read) {
            numGrids += static_cast<std::uint32_t>(plan.fields[number].grids.size());
        }
        return kLinesAround * numGrids;
    }

    /// Where the voxels of grids are, which are in one place.
    static shared::HdsVolumeField PlaceField(const PreparedGrids& grids,
                                             const GridDescription& lattice) {
        const glm::dmat4& place = grids[0]->description.objectFromIndex;
        shared::HdsVolumeField field{};
        field.flags = place == lattice.objectFromIndex ? HDS_FIELD_IS_ALIGNED : 0U;
        StoreRows(glm::inverse(place) * lattice.objectFromIndex, field.indexFromLattice);
        return field;
    }

    /// \param grids one, or those of red, green and blue, which follow one another.
    shared::HdsVolumeField Field(const PreparedGrids& grids, const GridDescription& lattice) {
        shared::HdsVolumeField field = PlaceField(grids, lattice);
        field.grid = GridOf(grids[0]);
        for (std::size_t i = 1; i < grids.size(); ++i) {
            GridOf(grids[i]);
        }
        field.flags |= grids.size() > 1 ? HDS_FIELD_IS_COLOR : 0U;
        return field;
    }

    /// A density whose bounds hold while it moves.
    std::uint32_t MovingGridOf(const VolumeGrids& grids, const GridDescription& lattice) {
        const PreparedGrid* density = grids.density.get();
        const auto number = static_cast<std::uint32_t>(result.grids.size());
        const auto [found, isNew] =
            _movingNumbers.emplace(std::pair(density, grids.velocity.grids[0].get()), number);
        if (isNew) {
            const GridTiles moving = SpreadGrid(lattice, grids.velocity);
            AddGrid(moving.record, moving.tiles, moving.cells, TextureOf(grids.density));
        }
        return found->second;
    }

    /// Makes a volume follow its velocity.
    void Move(const VolumeGrids& grids, const GridDescription& lattice, shared::HdsVolume* volume) {
        result.haveMotion = true;
        result.haveVelocities = true;
        volume->velocity = PlaceField(grids.velocity.grids, lattice);
        volume->velocity.grid = VelocityOf(grids.velocity.grids);
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) {
                volume->latticeFromVelocity[3 * row + column] =
                    static_cast<float>(grids.velocity.latticeFromVelocity[column][row]);
            }
        }
        volume->openSeconds = static_cast<float>(grids.velocity.openSeconds);
        volume->closeSeconds = static_cast<float>(grids.velocity.closeSeconds);
    }

    std::uint32_t GridOf(const std::shared_ptr<const PreparedGrid>& grid) {
        const auto number = static_cast<std::uint32_t>(result.grids.size());
        const auto [found, isNew] = _numbers.emplace(grid.get(), number);
        if (isNew) {
            const GridDescription& description = grid->description;
            AddGrid(description.record, description.tiles, description.cells, TextureOf(grid));
        }
        return found->second;
    }

    void AddGrid(shared::HdsGrid record, const std::vector<shared::HdsGridTile>& tiles,
                 const std::vector<shared::HdsGridCell>& cells, std::uint32_t texture) {
        record.firstTile = static_cast<std::uint32_t>(result.tiles.size());
        record.firstCell = static_cast<std::uint32_t>(result.cells.size());
        record.texture = texture;
        record.firstBrick = 0; // Finish
        result.grids.push_back(record);
        result.tiles.insert(result.tiles.end(), tiles.begin(), tiles.end());
        result.cells.insert(result.cells.end(), cells.begin(), cells.end());
    }

    /// The first of a velocity's grids, which follow one another, whoever else reads some of them.
    std::uint32_t VelocityOf(const PreparedGrids& grids) {
        const auto number = static_cast<std::uint32_t>(result.grids.size());
        const auto [found, isNew] = _velocityNumbers.emplace(grids[0].get(), number);
        for (std::size_t i = 0; isNew && i < grids.size(); ++i) {
            const GridDescription& description = grids[i]->description;
            AddGrid(description.record, description.tiles, description.cells, TextureOf(grids[i]));
        }
        return found->second;
    }

    /// The texture whose lines a grid's bricks are.
    std::uint32_t TextureOf(const std::shared_ptr<const PreparedGrid>& grid) {
        const auto number = static_cast<std::uint32_t>(result.prepared.size());
        const auto [found, isNew] = _textures.emplace(grid.get(), number);
        if (isNew) {
            result.prepared.push_back(grid);
            result.numBricks += grid->description.numBricks;
        }
        return _numTextures + found->second;
    }

    glm::dvec3 _centre;
    std::uint32_t _numTextures;
    std::uint32_t _firstWord;                              ///< of programs
    std::map<const PreparedGrid*, std::uint32_t> _numbers; ///< of grids
    std::map<std::pair<const PreparedGrid*, const PreparedGrid*>, std::uint32_t> _movingNumbers;
    std::map<const PreparedGrid*, std::uint32_t> _velocityNumbers;
    std::map<const PreparedGrid*, std::uint32_t> _textures; ///< among those of grids
    std::set<const PreparedGrid*> _bounded; ///< densities without terms: no other bounds are read
};

/// Finds the grids of one volume.
class GridFinder {
public:
    GridFinder(const std::string& path, const VolumePrim& prim, GridPreparer* preparer,
               Warnings& warnings)
        : _path(path), _prim(prim), _preparer(*preparer), _warnings(warnings) {}

    bool Has(const std::string& name) const { return _prim.fields.count(name) != 0; }

    /// Of a field by name; nothing, with a warning, when it cannot be read.
    /// \param isNegated what is below 0 counts, in place of what is above.
    PreparedGrids Find(const std::string& name, bool isNegated = false) {
        const auto found = _prim.fields.find(name);
        if (found == _prim.fields.end()) {
            _warnings.Add(_path, "volume without the field '" + name + "'");
            return {};
        }
        const VolumeField& field = found->second;
        PreparedGrids grids =
            field.voxels ? _preparer.Prepare(field.voxels) : Read(name, field, isNegated);
        if (!grids.empty() && !CanBeInverted(grids[0]->description.objectFromIndex)) {
            _warnings.Add(_path, "field '" + name + "' has a place that makes no sense");
            return {};
        }
        return grids;
    }

    void Warn(const std::string& text) { _warnings.Add(_path, text); }

private:
    PreparedGrids Read(const std::string& name, const VolumeField& field, bool isNegated) {
        const AssetReference& asset = field.asset;
        if (asset.file.empty()) {
            _warnings.Add(_path, "field '" + name + "': " + asset.authoredPath + " is not found");
            return {};
        }
        std::string error;
        PreparedGrids grids = _preparer.Prepare(
            {asset.file, asset.offset, field.gridName, field.gridIndex, isNegated}, asset.size,
            &error);
        if (grids.empty()) {
            _warnings.Add(_path, "field '" + name + "': " + error);
        }
        return grids;
    }

    const std::string& _path;
    const VolumePrim& _prim;
    GridPreparer& _preparer;
    Warnings& _warnings;
};

/// \return false, with a warning, when there is nothing to draw.
/// \param[out] plan where coefficients are sums of products; else without terms.
bool FindGrids(const VolumeMaterial& material, GridFinder finder, ImageLibrary* images,
               VolumeGrids* grids, TermPlan* plan) {
    const VolumeShading& shading = material.shading;
    *plan = PlanTerms(
        material, [&](const std::string& name) { return finder.Find(name); }, images,
        [&](const std::string& text) { finder.Warn(text); });
    if (!shading.terms.empty() && plan->fields.empty()) {
        return false;
    }
    const auto density =
        shading.terms.empty() ? finder.Find(shading.density) : plan->fields[plan->lattice].grids;
    if (density.empty()) {
        return false;
    }
    grids->density = density[0];
    if (shading.terms.empty() && shading.emission != glm::vec3(0.0F)) {
        const bool isOwn =
            !shading.emissionField.empty() && shading.emissionField != shading.density;
        grids->emission = isOwn ? finder.Find(shading.emissionField) : density;
    }
    // Hosts' shaders name a temperature by default; without that field nothing glows.
    if (shading.blackbody != glm::vec3(0.0F) && finder.Has(shading.temperatureField)) {
        const auto temperature = finder.Find(shading.temperatureField);
        grids->temperature = temperature.empty() ? nullptr : temperature[0];
    }
    return true;
}

/// The plain form as terms, where its kernels cannot draw it: a density that has three channels, or
/// none beside what glows.
VolumeShading WithTerms(VolumeShading shading, GridFinder finder) {
    if (!shading.terms.empty()) {
        return shading;
    }
    const std::string& emissionField =
        shading.emissionField.empty() ? shading.density : shading.emissionField;
    const bool isGlowAlone = !finder.Has(shading.density) &&
                             shading.absorption + shading.scattering == glm::vec3(0.0F) &&
                             shading.emission != glm::vec3(0.0F);
    const bool isColored = finder.Has(shading.density) && finder.Find(shading.density).size() > 1;
    if (!isGlowAlone && !isColored) {
        return shading;
    }
    if (isColored) {
        shading.terms.push_back({{shading.density}, shading.absorption, shading.scattering, {}});
    }
    if (shading.emission != glm::vec3(0.0F)) {
        shading.terms.push_back({{emissionField}, {}, {}, shading.emission});
    }
    return shading;
}

/// \param density whose lattice is moved. \return one without grids where nothing moves.
GridVelocity FindVelocity(const Shutter& shutter, double timeCodesPerSecond,
                          const GridDescription& density, GridFinder finder) {
    GridVelocity velocity;
    const auto* const name = std::find_if(std::begin(kVelocities), std::end(kVelocities),
                                          [&](const char* text) { return finder.Has(text); });
    if (!shutter.IsOpen() || name == std::end(kVelocities) || !(timeCodesPerSecond > 0.0)) {
        return velocity;
    }
    PreparedGrids above = finder.Find(*name);
    const PreparedGrids below = above.empty() ? above : finder.Find(*name, true);
    if (above.size() != 3 || below.size() != 3) {
        if (!above.empty()) {
            finder.Warn("field '" + std::string(*name) + "' is no vector: the volume is at rest");
        }
        return velocity;
    }
    const glm::dmat4& place = above[0]->description.objectFromIndex;
    velocity.isAligned = place == density.objectFromIndex;
    velocity.latticeFromVelocity = glm::inverse(glm::dmat3(density.objectFromIndex));
    velocity.openSeconds = shutter.open / timeCodesPerSecond;
    velocity.closeSeconds = shutter.close / timeCodesPerSecond;
    above.insert(above.end(), below.begin(), below.end());
    velocity.grids = std::move(above);
    const VoxelShift shift = ShiftOf(velocity);
    if (!(glm::length(shift.least) < kMaxShift && glm::length(shift.most) < kMaxShift)) {
        finder.Warn("field '" + std::string(*name) + "' moves voxels further than " +
                    std::to_string(static_cast<int>(kMaxShift)) + ": the volume is at rest");
        velocity.grids.clear();
    }
    return velocity;
}

} // namespace

CommittedVolumes CommitVolumes(const SceneDescription& scene, VolumeMaterials materials,
                               const Shutter& shutter, glm::dvec3 centre,
                               const VolumeTableStarts& starts, const VolumeSources& sources,
                               LightLinks* links, Warnings& warnings) {
    VolumeTables tables(centre, starts.textures, starts.words);
    GridPreparer* preparer = sources.grids;
    std::uint32_t number = 0;
    std::uint64_t numLeftOut = 0;
    for (const auto& [path, prim] : scene.volumes) {
        ++number;
        const auto material = materials.find(path);
        std::vector<Placed> places;
        if (material != materials.end()) {
            WarnOfTooMany(scene, path, prim.placement, warnings);
            places = PlacementsOf(scene, prim.placement, shutter);
        }
        if (places.empty()) {
            continue;
        }
        VolumeShading& shading = material->second.shading;
        shading = WithTerms(std::move(shading), {path, prim, preparer, warnings});
        const std::size_t numPlaces = places.size();
        places.erase(
            std::remove_if(places.begin(), places.end(),
                           [](const Placed& one) { return !CanBeInverted(one.worldFromObject); }),
            places.end());
        if (!IsFinite(shading) || places.empty()) {
            warnings.Add(path, "volume with a place or material that makes no sense: left out");
            continue;
        }
        if (places.size() < numPlaces) { // as of geometry, those alone
            warnings.Add(path, std::to_string(numPlaces - places.size()) +
                                   " instances of a volume dropped: transform singular or not "
                                   "finite while the shutter is open");
        }
        VolumeGrids grids;
        TermPlan plan;
        if (!FindGrids(material->second, {path, prim, preparer, warnings}, sources.images, &grids,
                       &plan)) {
            continue;
        }
        grids.velocity = FindVelocity(shutter, prim.timeCodesPerSecond, grids.density->description,
                                      {path, prim, preparer, warnings});
        if (!shading.terms.empty()) {
            grids.terms = tables.AddTerms(plan, shading.turnsVary, grids.velocity);
            if (grids.terms.number == HDS_NONE) {
                warnings.Add(path, "volume whose fields are too far apart: left out");
                continue;
            }
        }
        for (std::uint32_t i = 0; i < places.size(); ++i) {
            if (tables.result.volumes.size() == kMaxVolumes) {
                numLeftOut += places.size() - i;
                break;
            }
            tables.Add(places[i].worldFromObject, shading, grids, number * kMaxVolumes + i,
                       links->SetOf(prim.categories, places[i].categories));
        }
    }
    if (numLeftOut > 0) {
        warnings.Add("", std::to_string(numLeftOut) + " volumes are left out: at most " +
                             std::to_string(kMaxVolumes) + " are drawn");
    }
    preparer->ForgetUnused();
    tables.Finish();
    return std::move(tables.result);
}

} // namespace hds
