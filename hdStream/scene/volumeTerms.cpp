// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/volumeTerms.h"

#include "hdStream/scene/gridBounds.h"

#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <map>
#include <utility>

namespace hds {

namespace {

/// Of 512 cells each, which are made for every cell of the box.
constexpr double kMaxTiles = 1 << 17;

/// Collects the fields of terms.
class Planner {
public:
    Planner(const std::function<PreparedGrids(const std::string&)>& find,
            const std::function<void(const std::string&)>& warn)
        : _find(find), _warn(warn) {}

    void Add(const VolumeTerm& term) {
        if (plan.terms.size() == HDS_MAX_TERMS || term.fields.size() > HDS_MAX_TERM_FACTORS) {
            _warn("material with too many products of fields: one of " +
                  std::to_string(term.fields.size()) + " fields is left out");
            return;
        }
        shared::HdsVolumeTerm record{};
        for (std::size_t i = 0; i < term.fields.size(); ++i) {
            const auto& name = term.fields[i];
            const auto power = std::count(term.fields.begin(), term.fields.begin() + i, name);
            const std::uint32_t number = FieldOf(name, static_cast<int>(power));
            if (number == HDS_NONE) {
                return;
            }
            record.factors |= (number + 1) << (8 * i);
        }
        for (int i = 0; i < 3; ++i) {
            record.extinction[i] = term.absorption[i] + term.scattering[i];
            record.scattering[i] = term.scattering[i];
            record.emission[i] = term.emission[i];
        }
        plan.terms.push_back(record);
    }

    std::uint32_t FieldOf(const std::string& name, int power) {
        const auto number = static_cast<std::uint32_t>(plan.fields.size());
        const auto [found, isNew] = _numbers.emplace(std::pair(name, power), number);
        if (isNew) {
            const PreparedGrids grids = power > 0 ? GridsOf(name, power - 1) : _find(name);
            if (grids.empty() || number == HDS_MAX_TERM_FIELDS) {
                if (!grids.empty()) {
                    _warn("material with too many fields: '" + name + "' is left out");
                }
                found->second = HDS_NONE;
                return HDS_NONE;
            }
            plan.fields.push_back(grids);
        }
        return found->second;
    }

    TermPlan plan;

private:
    PreparedGrids GridsOf(const std::string& name, int power) {
        const std::uint32_t number = FieldOf(name, power);
        return number == HDS_NONE ? PreparedGrids() : plan.fields[number];
    }

    const std::function<PreparedGrids(const std::string&)>& _find;
    const std::function<void(const std::string&)>& _warn;
    std::map<std::pair<std::string, int>, std::uint32_t> _numbers; ///< by name and which factor
};

bool HasMedium(const shared::HdsVolumeTerm& term) {
    const auto isAny = [](float value) { return value != 0.0F; };
    return std::any_of(term.extinction, term.extinction + 3, isAny) ||
           std::any_of(term.scattering, term.scattering + 3, isAny);
}

/// What a field can be in one cell of the lattice, by channel, and what it is about its middle.
struct FieldInCell {
    ValueRange range[3];
    double mean[3];
};

/// A field in the voxels of the lattice.
class PlacedField {
public:
    PlacedField(const PreparedGrids& grids, const GridDescription& lattice)
        : _grids(grids),
          _isAligned(grids[0]->description.objectFromIndex == lattice.objectFromIndex),
          _map(glm::inverse(grids[0]->description.objectFromIndex) * lattice.objectFromIndex) {}

    FieldInCell In(glm::ivec3 voxel) const {
        FieldInCell field{};
        const glm::dvec3 half(0.5 * HDS_BRICK_VOXELS);
        const glm::dvec3 middle(_map * glm::dvec4(glm::dvec3(voxel) + half, 1.0));
        glm::dvec3 reach(kGridSlack);
        for (int axis = 0; axis < 3; ++axis) {
            reach += glm::abs(glm::dvec3(_map[axis])) * half[axis];
        }
        for (std::size_t channel = 0; channel < 3; ++channel) {
            const GridDescription& grid = _grids[channel % _grids.size()]->description;
            const shared::HdsGridCell cell =
                GridCellAt(grid, _isAligned ? voxel : glm::ivec3(glm::floor(middle)));
            field.mean[channel] = cell.value;
            field.range[channel] = _isAligned ? ValueRange{cell.least, cell.greatest}
                                              : RangeBetween(grid, middle - reach, middle + reach);
        }
        return field;
    }

private:
    const PreparedGrids& _grids;
    bool _isAligned;
    glm::dmat4 _map;
};

/// A coefficient's sum in one cell and one channel.
struct SumInCell {
    ValueRange range;
    double mean = 0.0;
};

SumInCell SumOf(const TermPlan& plan, const std::vector<FieldInCell>& fields,
                const float (shared::HdsVolumeTerm::*coefficient)[3], int channel) {
    SumInCell sum;
    for (const shared::HdsVolumeTerm& term : plan.terms) {
        const double factor = (term.*coefficient)[channel];
        double least = factor;
        double greatest = factor;
        double mean = factor;
        for (std::uint32_t factors = term.factors; factors != 0; factors >>= 8U) {
            const FieldInCell& field = fields[(factors & 255U) - 1];
            least *= field.range[channel].least;
            greatest *= field.range[channel].greatest;
            mean *= field.mean[channel];
        }
        sum.range.least += factor < 0.0 ? greatest : least;
        sum.range.greatest += factor < 0.0 ? least : greatest;
        sum.mean += mean;
    }
    sum.range.least = std::max(sum.range.least, 0.0);
    sum.range.greatest = std::max(sum.range.greatest, 0.0);
    sum.mean = std::max(sum.mean, 0.0);
    return sum;
}

/// Over the channels: the least and the greatest of all, the mean of means.
shared::HdsGridCell CellOf(const TermPlan& plan, const std::vector<FieldInCell>& fields,
                           const float (shared::HdsVolumeTerm::*coefficient)[3]) {
    const SumInCell sums[] = {SumOf(plan, fields, coefficient, 0),
                              SumOf(plan, fields, coefficient, 1),
                              SumOf(plan, fields, coefficient, 2)};
    double least = sums[0].range.least;
    double greatest = 0.0;
    double mean = 0.0;
    for (const SumInCell& sum : sums) {
        least = std::min(least, sum.range.least);
        greatest = std::max(greatest, sum.range.greatest);
        mean += sum.mean / 3.0;
    }
    return {HDS_NONE, static_cast<float>(mean), static_cast<float>(greatest),
            static_cast<float>(least)};
}

} // namespace

TermPlan PlanTerms(const VolumeShading& shading,
                   const std::function<PreparedGrids(const std::string&)>& find,
                   const std::function<void(const std::string&)>& warn) {
    Planner planner(find, warn);
    for (const VolumeTerm& term : shading.terms) {
        planner.Add(term);
    }
    TermPlan& plan = planner.plan;
    const auto end = std::stable_partition(plan.terms.begin(), plan.terms.end(), HasMedium);
    plan.numMedium = static_cast<std::uint32_t>(end - plan.terms.begin());
    const auto isDensity = [&](const VolumeTerm& term) {
        return std::count(term.fields.begin(), term.fields.end(), shading.density) > 0;
    };
    if (std::any_of(shading.terms.begin(), shading.terms.end(), isDensity)) {
        const std::uint32_t number = planner.FieldOf(shading.density, 0);
        plan.lattice = number == HDS_NONE ? 0 : number;
    }
    return std::move(plan);
}

bool MayBound(glm::dvec3 least, glm::dvec3 most) {
    const glm::dvec3 tiles = (most - least) / double(HDS_TILE_VOXELS) + 2.0;
    return tiles.x * tiles.y * tiles.z <= kMaxTiles;
}

TermBounds BoundTerms(const TermPlan& plan, glm::dvec3 least, glm::dvec3 most) {
    const GridDescription& lattice = plan.fields[plan.lattice][0]->description;
    std::vector<PlacedField> placed;
    for (const PreparedGrids& grids : plan.fields) {
        placed.emplace_back(grids, lattice);
    }
    const auto cellsOf = [&](const float(shared::HdsVolumeTerm::*coefficient)[3]) {
        return MakeGridTiles(glm::ivec3(glm::floor(least)), glm::ivec3(glm::ceil(most)),
                             [&](glm::ivec3 voxel) {
                                 std::vector<FieldInCell> fields;
                                 for (const PlacedField& field : placed) {
                                     fields.push_back(field.In(voxel));
                                 }
                                 return CellOf(plan, fields, coefficient);
                             });
    };
    TermBounds bounds;
    GridTiles extinction = cellsOf(&shared::HdsVolumeTerm::extinction);
    bounds.extinction.record = extinction.record;
    bounds.extinction.tiles = std::move(extinction.tiles);
    bounds.extinction.cells = std::move(extinction.cells);
    bounds.extinction.first = glm::ivec3(glm::floor(least)) + 1;
    bounds.extinction.size = glm::ivec3(glm::ceil(most)) - bounds.extinction.first;
    bounds.extinction.objectFromIndex = lattice.objectFromIndex;
    if (std::any_of(plan.terms.begin(), plan.terms.end(), [](const auto& term) {
            return std::any_of(term.emission, term.emission + 3,
                               [](float value) { return value != 0.0F; });
        })) {
        bounds.emission = cellsOf(&shared::HdsVolumeTerm::emission);
    }
    return bounds;
}

} // namespace hds
