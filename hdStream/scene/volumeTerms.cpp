// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/volumeTerms.h"

#include "hdStream/scene/gridBounds.h"
#include "hdStream/scene/networkValues.h"
#include "hdStream/shading/programWriter.h"
#include "hdStream/shading/valueResolver.h"
#include "kernels/shared/geometry.h"

#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace hds {

namespace {

/// Of 512 cells each, which are made for every cell of the box.
constexpr double kMaxTiles = 1 << 17;
/// What compression may carry texels beyond the values of their image, as a part of these' range.
constexpr float kTexelSlack = 0.25F;
/// Least mean of a cell that counts, as a part of its greatest value.
constexpr double kLeastMean = 1e-3;

/// Leaves of images what bounds need: the least and the greatest of their values.
void KeepBounds(DisplacementNetwork* network) {
    for (DisplacementStep& step : network->steps) {
        for (DisplacementTile& tile : step.tiles) {
            for (std::shared_ptr<const HeightImage>& heights : tile.heights) {
                if (!heights || heights->values.empty()) {
                    continue;
                }
                const auto [least, greatest] =
                    std::minmax_element(heights->values.begin(), heights->values.end());
                const float slack = kTexelSlack * (*greatest - *least);
                auto bounds = std::make_shared<HeightImage>();
                bounds->width = 2;
                bounds->height = 1;
                bounds->values = {std::max(*least - slack, std::min(*least, 0.0F)),
                                  *greatest + slack};
                heights = std::move(bounds);
            }
        }
    }
}

/// Collects the fields of terms.
class Planner {
public:
    Planner(const VolumeMaterial& material,
            const std::function<PreparedGrids(const std::string&)>& find, ImageLibrary* images,
            const std::function<void(const std::string&)>& warn)
        : _material(material), _find(find), _images(*images), _warn(warn) {}

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
            const std::uint32_t number =
                PatternNumber(name) ? PatternOf(name) : FieldOf(name, static_cast<int>(power));
            if (number == HDS_NONE) {
                return;
            }
            record.factors |= (number + 1) << (8 * i);
        }
        for (int i = 0; i < 3; ++i) {
            record.extinction[i] = term.absorption[i] + term.scattering[i];
            record.scattering[i] = term.scattering[i];
            record.emission[i] = term.emission[i];
            record.turned[i] = term.turned[i];
        }
        plan.terms.push_back(record);
    }

    std::uint32_t FieldOf(const std::string& name, int power) {
        const auto number = static_cast<std::uint32_t>(plan.fields.size());
        const auto [found, isNew] = _numbers.emplace(std::pair(name, power), number);
        if (isNew) {
            const PreparedGrids grids = power > 0 ? GridsOf(name, power - 1) : _find(name);
            if (grids.empty() || !HasRoom(name)) {
                found->second = HDS_NONE;
                return HDS_NONE;
            }
            plan.fields.push_back({grids, std::nullopt});
        }
        return found->second;
    }

    TermPlan plan;

private:
    PreparedGrids GridsOf(const std::string& name, int power) {
        const std::uint32_t number = FieldOf(name, power);
        return number == HDS_NONE ? PreparedGrids() : plan.fields[number].grids;
    }

    bool HasRoom(const std::string& name) const {
        if (plan.fields.size() == HDS_MAX_TERM_FIELDS) {
            _warn("material with too many fields: '" + name + "' is left out");
        }
        return plan.fields.size() < HDS_MAX_TERM_FIELDS;
    }

    /// A pattern has one value at a point, so one that is squared is there once.
    std::uint32_t PatternOf(const std::string& name) {
        const auto [found, isNew] = _numbers.emplace(std::pair(name, 0), HDS_NONE);
        if (isNew) {
            found->second = MakePattern(name);
        }
        return found->second;
    }

    std::uint32_t MakePattern(const std::string& name) {
        const std::size_t index = *PatternNumber(name);
        if (index >= _material.patterns.size()) {
            _warn("volume without the pattern '" + name + "'");
            return HDS_NONE;
        }
        const ShaderValue& value = _material.patterns[index];
        std::map<std::string, std::uint32_t> fields;
        for (const std::string& field : FieldsOf(value)) {
            fields[field] = FieldOf(field, 0);
        }
        const SlotCallback findSlot = [&](const std::string& field, std::uint32_t) {
            const std::uint32_t number = fields.at(field);
            return number == HDS_NONE ? HDS_NONE : HDS_SLOT_FIELD + number;
        };
        ShaderValue resolved = ValueResolver(findSlot).Resolve(value, 3);
        if (IsConstant(resolved) && value.channel != HDS_CHANNEL_ALL) {
            const float one = ConstantOf(resolved)[0];
            resolved = MakeConstant({one, one, one, one}, 3);
        }
        PlannedPattern pattern;
        std::string problem;
        auto network = MakeDisplacementNetwork(resolved, _material.textures, &problem);
        if (network) {
            pattern.program = WriteProgram({{0, resolved}}, _material.textureIndices, findSlot);
        }
        if (pattern.program.empty()) {
            _warn("pattern with " + (network ? "too many functions" : problem) +
                  ": its products are left out");
            return HDS_NONE;
        }
        if (!HasRoom("a pattern")) {
            return HDS_NONE;
        }
        pattern.network = std::move(*network);
        for (const DisplacementPrimvar& primvar : pattern.network.primvars) {
            pattern.fields.push_back(fields.at(primvar.names[0]));
        }
        _images.LoadHeights(&pattern.network);
        KeepBounds(&pattern.network);
        plan.fields.push_back({{}, std::move(pattern)});
        return static_cast<std::uint32_t>(plan.fields.size() - 1);
    }

    const VolumeMaterial& _material;
    const std::function<PreparedGrids(const std::string&)>& _find;
    ImageLibrary& _images;
    const std::function<void(const std::string&)>& _warn;
    std::map<std::pair<std::string, int>, std::uint32_t> _numbers; ///< by name and which factor
};

bool HasMedium(const shared::HdsVolumeTerm& term) {
    const auto isAny = [](float value) { return value != 0.0F; };
    return std::any_of(term.extinction, term.extinction + 3, isAny) ||
           std::any_of(term.scattering, term.scattering + 3, isAny) ||
           std::any_of(term.turned, term.turned + 3, isAny);
}

/// Calls a function with the number of each factor of a term.
template <typename Function>
void ForEachFactor(const shared::HdsVolumeTerm& term, const Function& function) {
    for (std::uint32_t factors = term.factors; factors != 0; factors >>= 8U) {
        function((factors & 255U) - 1);
    }
}

GridRange ProductOf(const GridRange& a, const GridRange& b) {
    const auto [least, greatest] = std::minmax(
        {a.least * b.least, a.least * b.greatest, a.greatest * b.least, a.greatest * b.greatest});
    return {least, greatest};
}

/// What a field can be in one cell of the lattice, by channel, and what it is about its middle.
struct FieldInCell {
    GridRange range[3];
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
            field.range[channel] = _isAligned ? GridRange{cell.least, cell.greatest}
                                              : RangeBetween(grid, middle - reach, middle + reach);
        }
        return field;
    }

private:
    const PreparedGrids& _grids;
    bool _isAligned;
    glm::dmat4 _map;
};

/// What a pattern can be in a box of object space, by channel, and what it is about its middle.
/// \param fields of the plan, of which those that it reads are known.
FieldInCell PatternIn(const TermPlan& plan, const PlannedPattern& pattern,
                      const std::vector<FieldInCell>& fields, glm::dvec3 middle, glm::dvec3 reach) {
    AmountBox box;
    AmountPoint mean;
    box.low.position = middle - reach;
    box.high.position = middle + reach;
    mean.position = middle;
    for (const std::uint32_t number : pattern.fields) {
        const FieldInCell& field = fields[number];
        std::array<double, 4> low{};
        std::array<double, 4> high{};
        std::array<double, 4> about{};
        const std::size_t numChannels = plan.fields[number].grids.size() > 1 ? 3 : 4;
        for (std::size_t k = 0; k < numChannels; ++k) {
            low[k] = field.range[k % 3].least;
            high[k] = field.range[k % 3].greatest;
            about[k] = field.mean[k % 3];
        }
        box.low.primvars.push_back(low);
        box.high.primvars.push_back(high);
        mean.primvars.push_back(about);
    }
    const ValueRange range = RangeOf(pattern.network, box);
    const NetworkValue value = ValueOf(pattern.network, mean);
    FieldInCell result{};
    for (std::size_t k = 0; k < 3; ++k) {
        result.range[k] = {range[k].low, range[k].high};
        result.mean[k] = std::isfinite(value[k]) ? double(value[k]) : 0.0;
    }
    return result;
}

/// What the factors of a plan can be in cells of its lattice.
class FactorsInCells {
public:
    explicit FactorsInCells(const TermPlan& plan)
        : _plan(plan), _objectFromLattice(plan.Lattice().objectFromIndex) {
        for (const PlannedField& field : plan.fields) {
            _placed.emplace_back();
            if (!field.pattern) {
                _placed.back().emplace(field.grids, plan.Lattice());
            }
        }
    }

    /// \param voxel the first of the cell. Patterns whose products are all 0 there count as 0.
    std::vector<FieldInCell> In(glm::ivec3 voxel) const {
        std::vector<FieldInCell> fields(_placed.size());
        for (std::size_t k = 0; k < fields.size(); ++k) {
            if (_placed[k]) {
                fields[k] = _placed[k]->In(voxel);
            }
        }
        const glm::dvec3 half(0.5 * HDS_BRICK_VOXELS);
        const glm::dvec3 middle(_objectFromLattice * glm::dvec4(glm::dvec3(voxel) + half, 1.0));
        glm::dvec3 reach(0.0);
        for (int axis = 0; axis < 3; ++axis) {
            reach += glm::abs(glm::dvec3(_objectFromLattice[axis])) * (half[axis] + kGridSlack);
        }
        for (std::size_t k = 0; k < fields.size(); ++k) {
            if (!_placed[k] && Counts(k, fields)) {
                fields[k] = PatternIn(_plan, *_plan.fields[k].pattern, fields, middle, reach);
            }
        }
        return fields;
    }

    /// The same in the box of the plan, in place of a cell.
    FieldInCell InBox(std::size_t pattern) const {
        std::vector<FieldInCell> fields(_placed.size());
        for (std::size_t k = 0; k < fields.size(); ++k) {
            const PreparedGrids& grids = _plan.fields[k].grids;
            for (std::size_t channel = 0; channel < 3 && !grids.empty(); ++channel) {
                const GridDescription& grid = grids[channel % grids.size()]->description;
                fields[k].range[channel] = {0.0, grid.record.greatest};
            }
        }
        const glm::dvec3 half = 0.5 * (_plan.most - _plan.least);
        const glm::dvec3 middle(_objectFromLattice *
                                glm::dvec4(0.5 * (_plan.most + _plan.least), 1.0));
        glm::dvec3 reach(0.0);
        for (int axis = 0; axis < 3; ++axis) {
            reach += glm::abs(glm::dvec3(_objectFromLattice[axis])) * (half[axis] + kGridSlack);
        }
        return PatternIn(_plan, *_plan.fields[pattern].pattern, fields, middle, reach);
    }

private:
    /// Whether some product of a pattern has no field that is 0.
    bool Counts(std::size_t pattern, const std::vector<FieldInCell>& fields) const {
        return std::any_of(
            _plan.terms.begin(), _plan.terms.end(), [&](const shared::HdsVolumeTerm& term) {
                bool isFactor = false;
                bool isZero = false;
                ForEachFactor(term, [&](std::uint32_t k) {
                    const GridRange* range = fields[k].range;
                    isFactor = isFactor || k == pattern;
                    isZero = isZero || (_placed[k] && range[0].greatest <= 0.0 &&
                                        range[1].greatest <= 0.0 && range[2].greatest <= 0.0);
                });
                return isFactor && !isZero;
            });
    }

    const TermPlan& _plan;
    glm::dmat4 _objectFromLattice;
    std::vector<std::optional<PlacedField>> _placed; ///< by field; of patterns nothing
};

/// A coefficient's sum in one cell and one channel.
struct SumInCell {
    GridRange range;
    double mean = 0.0;
};

SumInCell SumOf(const TermPlan& plan, const std::vector<FieldInCell>& fields,
                const float (shared::HdsVolumeTerm::*coefficient)[3], int channel) {
    SumInCell sum;
    for (const shared::HdsVolumeTerm& term : plan.terms) {
        const double factor = (term.*coefficient)[channel];
        if (factor == 0.0) {
            continue;
        }
        GridRange product{factor, factor};
        double mean = factor;
        ForEachFactor(term, [&](std::uint32_t k) {
            product = ProductOf(product, fields[k].range[channel]);
            mean *= fields[k].mean[channel];
        });
        sum.range.least += product.least;
        sum.range.greatest += product.greatest;
        sum.mean += mean;
    }
    sum.range.least = std::max(sum.range.least, 0.0);
    sum.range.greatest = std::max(sum.range.greatest, 0.0);
    sum.mean = std::max(sum.mean, 0.0);
    return sum;
}

bool HasPatterns(const TermPlan& plan) {
    return std::any_of(plan.fields.begin(), plan.fields.end(),
                       [](const PlannedField& field) { return field.pattern.has_value(); });
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
    // A pattern may be 0 just where its mean is taken; a cell that counts is not empty.
    mean = HasPatterns(plan) ? std::max(mean, kLeastMean * greatest) : mean;
    return {HDS_NONE, static_cast<float>(mean), static_cast<float>(greatest),
            static_cast<float>(least)};
}

/// Leaves out the terms of patterns whose values have no bound.
void DropUnbounded(TermPlan* plan, const std::function<void(const std::string&)>& warn) {
    const FactorsInCells factors(*plan);
    for (std::size_t k = 0; k < plan->fields.size(); ++k) {
        if (!plan->fields[k].pattern) {
            continue;
        }
        const FieldInCell in = factors.InBox(k);
        const bool isBounded = std::all_of(in.range, in.range + 3, [](const GridRange& range) {
            return std::isfinite(range.least) && std::isfinite(range.greatest);
        });
        if (isBounded) {
            continue;
        }
        warn("pattern whose values have no bound (a clamp gives it one): its products are left "
             "out");
        const auto end = std::remove_if(
            plan->terms.begin(), plan->terms.end(), [&](const shared::HdsVolumeTerm& term) {
                bool isFactor = false;
                ForEachFactor(term, [&](std::uint32_t one) { isFactor = isFactor || one == k; });
                return isFactor;
            });
        plan->terms.erase(end, plan->terms.end());
    }
}

} // namespace

void ExtendBox(const GridDescription& grid, const GridDescription& lattice, glm::dvec3* least,
               glm::dvec3* most) {
    const glm::dmat4 map = glm::inverse(lattice.objectFromIndex) * grid.objectFromIndex;
    for (int corner = 0; corner < 8; ++corner) {
        glm::dvec3 at;
        for (int i = 0; i < 3; ++i) {
            at[i] = grid.first[i] + ((corner >> i & 1) != 0 ? grid.size[i] : -1);
        }
        const glm::dvec3 there(map * glm::dvec4(at, 1.0));
        *least = glm::min(*least, there);
        *most = glm::max(*most, there);
    }
}

TermPlan PlanTerms(const VolumeMaterial& material,
                   const std::function<PreparedGrids(const std::string&)>& find,
                   ImageLibrary* images, const std::function<void(const std::string&)>& warn) {
    const VolumeShading& shading = material.shading;
    Planner planner(material, find, images, warn);
    for (const VolumeTerm& term : shading.terms) {
        planner.Add(term);
    }
    TermPlan& plan = planner.plan;
    const auto isGrid = [](const PlannedField& field) { return !field.pattern; };
    const auto first = std::find_if(plan.fields.begin(), plan.fields.end(), isGrid);
    if (first == plan.fields.end()) {
        return {};
    }
    plan.lattice = static_cast<std::size_t>(first - plan.fields.begin());
    const auto isDensity = [&](const VolumeTerm& term) {
        return std::count(term.fields.begin(), term.fields.end(), shading.density) > 0;
    };
    if (std::any_of(shading.terms.begin(), shading.terms.end(), isDensity)) {
        const std::uint32_t number = planner.FieldOf(shading.density, 0);
        plan.lattice = number == HDS_NONE ? plan.lattice : number;
    }
    const GridDescription& lattice = plan.Lattice();
    plan.least = glm::dvec3(lattice.first - 1);
    plan.most = glm::dvec3(lattice.first + lattice.size);
    for (const PlannedField& field : plan.fields) {
        if (isGrid(field)) {
            ExtendBox(field.grids[0]->description, lattice, &plan.least, &plan.most);
        }
    }
    DropUnbounded(&plan, warn);
    const auto end = std::stable_partition(plan.terms.begin(), plan.terms.end(), HasMedium);
    plan.numMedium = static_cast<std::uint32_t>(end - plan.terms.begin());
    return std::move(plan);
}

bool MayBound(glm::dvec3 least, glm::dvec3 most) {
    const glm::dvec3 tiles = (most - least) / double(HDS_TILE_VOXELS) + 2.0;
    return tiles.x * tiles.y * tiles.z <= kMaxTiles;
}

TermBounds BoundTerms(const TermPlan& plan) {
    const GridDescription& lattice = plan.Lattice();
    const glm::ivec3 least(glm::floor(plan.least));
    const glm::ivec3 most(glm::ceil(plan.most));
    const FactorsInCells factors(plan);
    const auto cellsOf = [&](const float(shared::HdsVolumeTerm::*coefficient)[3]) {
        return MakeGridTiles(least, most, [&](glm::ivec3 voxel) {
            return CellOf(plan, factors.In(voxel), coefficient);
        });
    };
    TermBounds bounds;
    GridTiles extinction = cellsOf(&shared::HdsVolumeTerm::extinction);
    bounds.extinction.record = extinction.record;
    bounds.extinction.tiles = std::move(extinction.tiles);
    bounds.extinction.cells = std::move(extinction.cells);
    bounds.extinction.first = least + 1;
    bounds.extinction.size = most - bounds.extinction.first;
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
