// SPDX-License-Identifier: Apache-2.0
// Cells of volumes whose coefficients are computed: nothing that rays can meet leaves their bounds.
#include "hdStream/scene/volumeTerms.h"

#include "hdStream/scene/gridBounds.h"
#include "hdStream/scene/networkValues.h"

#include <glm/common.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

namespace hds {
namespace {

/// A network that grows node by node.
class Network {
public:
    MaterialNetwork network;

    /// \param inputs paths of nodes by input.
    std::string Add(const std::string& identifier, const std::map<std::string, std::string>& inputs,
                    std::map<std::string, ParameterValue> parameters = {}) {
        MaterialNode node;
        node.path = "/n" + std::to_string(network.nodes.size());
        node.identifier = identifier;
        node.parameters = std::move(parameters);
        for (const auto& [input, path] : inputs) {
            node.connections[input] = {path, "out"};
        }
        network.nodes.push_back(node);
        return node.path;
    }

    std::string Field(const std::string& name) {
        return Add("ND_geompropvalue_float", {}, {{"geomprop", name}});
    }

    void End(const std::string& absorption, const std::string& scattering,
             const std::string& emission) {
        const std::string vdf =
            Add("ND_anisotropic_vdf", {{"absorption", absorption}, {"scattering", scattering}});
        const std::string edf = Add("ND_uniform_edf", {{"color", emission}});
        network.terminals["volume"] = {Add("ND_volume", {{"vdf", vdf}, {"edf", edf}}), "out"};
    }
};

/// Sines, noises, thresholds and powers of places and of two fields.
MaterialNetwork MakeNetwork(std::mt19937* random) {
    Network made;
    const auto number = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(*random);
    };
    const std::string place =
        made.Add("ND_multiply_vector3FA", {{"in1", made.Add("ND_position_vector3", {})}},
                 {{"in2", number(0.5, 6.0)}});
    const std::string x =
        made.Add("ND_extract_vector3", {{"in", place}}, {{"index", std::int64_t{0}}});
    std::vector<std::string> values = {
        x,
        made.Field("a"),
        made.Field("b"),
        made.Add("ND_fractal3d_float", {{"position", place}}, {{"amplitude", number(0.2, 2.0)}}),
        made.Add("ND_noise3d_float", {{"position", place}}, {{"pivot", number(0.0, 1.0)}}),
        made.Add("ND_worleynoise3d_float", {{"position", place}})};
    const auto any = [&] { return values[(*random)() % values.size()]; };
    for (int i = 0; i < 6; ++i) {
        switch ((*random)() % 5) {
        case 0:
            values.push_back(made.Add("ND_multiply_float", {{"in1", any()}, {"in2", any()}}));
            break;
        case 1:
            values.push_back(made.Add("ND_sin_float", {{"in", any()}}));
            break;
        case 2:
            values.push_back(made.Add("ND_smoothstep_float", {{"in", any()}},
                                      {{"low", number(-0.5, 0.3)}, {"high", number(0.4, 1.5)}}));
            break;
        case 3:
            values.push_back(made.Add("ND_power_float", {{"in1", any()}}, {{"in2", 2.0}}));
            break;
        default:
            values.push_back(made.Add("ND_mix_float", {{"bg", any()}, {"fg", any()}},
                                      {{"mix", number(0.0, 1.0)}}));
        }
    }
    made.End(values[values.size() - 1], values[values.size() - 2], values[values.size() - 3]);
    return made.network;
}

std::shared_ptr<const VoxelGrid> MakeField(std::mt19937* random, glm::ivec3 size,
                                           const glm::dmat4& place) {
    std::vector<float> values(std::size_t(size.x) * size.y * size.z);
    for (float& value : values) {
        value = (*random)() % 4 == 0 ? 0.0F
                                     : std::uniform_real_distribution<float>(0.0F, 2.0F)(*random);
    }
    return std::make_shared<VoxelGrid>(MakeVoxelGrid(values.data(), glm::ivec3(-3), size, place));
}

/// A grid and the voxels that it was made of.
struct Field {
    std::shared_ptr<const VoxelGrid> voxels;
    PreparedGrids grids;

    float ValueAt(glm::ivec3 voxel) const {
        const glm::ivec3 last = voxels->first + voxels->size - 1;
        return glm::all(glm::lessThanEqual(voxels->first, voxel)) &&
                       glm::all(glm::lessThanEqual(voxel, last))
                   ? voxels->ValueAt(voxel)
                   : 0.0F;
    }
};

class VolumeTerms : public ::testing::Test {
protected:
    VolumeTerms() {
        const glm::dmat4 turned = glm::scale(
            glm::rotate(glm::dmat4(1.0), 0.7, glm::dvec3(1.0, 2.0, 0.5)), glm::dvec3(0.08));
        _fields["a"].voxels =
            MakeField(&_random, {20, 12, 9}, glm::scale(glm::dmat4(1.0), glm::dvec3(0.05)));
        _fields["b"].voxels = MakeField(&_random, {9, 14, 11}, turned);
        for (auto& [name, field] : _fields) {
            field.grids = _preparer.Prepare(field.voxels);
        }
    }

    double Unit() { return std::uniform_real_distribution<double>(0.0, 1.0)(_random); }

    TermPlan Plan(const MaterialNetwork& network) {
        _material = {};
        const ImageQueries images;
        VolumePatterns patterns(network, "/m", images, _warnings);
        const auto warn = [&](const std::string& text) { _warnings.Add("/v", text); };
        _material.shading = ReadVolumeShading(network, &patterns, warn);
        _material.patterns = patterns.Values();
        return PlanTerms(
            _material,
            [&](const std::string& name) { return _fields.at(name == "b" ? "b" : "a").grids; },
            &_library, warn);
    }

    const Field& FieldAt(const TermPlan& plan, std::size_t number) const {
        const bool isFirst = plan.fields[number].grids == _fields.at("a").grids;
        return _fields.at(isFirst ? "a" : "b");
    }

    /// The value of one factor, as a ray may meet it at a point of the lattice.
    double ValueOfFactor(const TermPlan& plan, std::size_t number, glm::dvec3 point) {
        const glm::dvec3 object(plan.Lattice().objectFromIndex * glm::dvec4(point, 1.0));
        const PlannedField& planned = plan.fields[number];
        if (!planned.pattern) {
            const Field& field = FieldAt(plan, number);
            const glm::dvec3 at(glm::inverse(field.voxels->objectFromIndex) *
                                glm::dvec4(object, 1.0));
            const glm::ivec3 corner(_random() % 2, _random() % 2, _random() % 2);
            return field.ValueAt(glm::ivec3(glm::floor(at)) + corner);
        }
        AmountPoint where;
        where.position = object;
        for (const std::uint32_t read : planned.pattern->fields) {
            const Field& field = FieldAt(plan, read);
            const glm::dvec3 at(glm::inverse(field.voxels->objectFromIndex) *
                                glm::dvec4(object, 1.0));
            const glm::dvec3 part = at - glm::floor(at);
            double value = 0.0;
            for (int i = 0; i < 8; ++i) {
                const glm::ivec3 corner(i & 1, i >> 1 & 1, i >> 2);
                const glm::dvec3 shares = glm::mix(1.0 - part, part, glm::dvec3(corner));
                value += shares.x * shares.y * shares.z *
                         field.ValueAt(glm::ivec3(glm::floor(at)) + corner);
            }
            where.primvars.push_back({value, value, value, value});
        }
        return ValueOf(planned.pattern->network, where)[0];
    }

    /// A coefficient's first channel at a point, with factors that are met once.
    double SumAt(const TermPlan& plan, glm::dvec3 point,
                 const float (shared::HdsVolumeTerm::*coefficient)[3]) {
        std::vector<double> factors;
        for (std::size_t k = 0; k < plan.fields.size(); ++k) {
            factors.push_back(ValueOfFactor(plan, k, point));
        }
        double sum = 0.0;
        for (const shared::HdsVolumeTerm& term : plan.terms) {
            double product = (term.*coefficient)[0];
            for (std::uint32_t rest = term.factors; rest != 0; rest >>= 8U) {
                product *= factors[(rest & 255U) - 1];
            }
            sum += product;
        }
        return std::max(sum, 0.0);
    }

    std::mt19937 _random{5};
    Warnings _warnings;
    ImageLibrary _library{_warnings};
    GridPreparer _preparer{nullptr};
    std::map<std::string, Field> _fields;
    VolumeMaterial _material;
};

GridDescription DescriptionOf(const GridTiles& tiles) {
    GridDescription description;
    description.record = tiles.record;
    description.tiles = tiles.tiles;
    description.cells = tiles.cells;
    return description;
}

TEST_F(VolumeTerms, NothingLeavesTheBoundsOfItsCell) {
    int numPatterns = 0;
    for (int i = 0; i < 40; ++i) {
        const TermPlan plan = Plan(MakeNetwork(&_random));
        if (plan.fields.empty()) {
            continue;
        }
        numPatterns += static_cast<int>(
            std::count_if(plan.fields.begin(), plan.fields.end(),
                          [](const PlannedField& field) { return field.pattern.has_value(); }));
        const TermBounds bounds = BoundTerms(plan);
        const GridDescription emission = DescriptionOf(bounds.emission);
        for (int n = 0; n < 2000; ++n) {
            const glm::dvec3 point =
                glm::mix(plan.least, plan.most, glm::dvec3(Unit(), Unit(), Unit()));
            const glm::ivec3 voxel(glm::floor(point));
            const shared::HdsGridCell cell = GridCellAt(bounds.extinction, voxel);
            const double slack = 1e-5 * cell.greatest + 1e-6;
            const double sum = SumAt(plan, point, &shared::HdsVolumeTerm::extinction);
            ASSERT_LE(sum, cell.greatest + slack) << i;
            ASSERT_GE(sum, cell.least - slack) << i;
            if (!emission.tiles.empty()) {
                ASSERT_LE(SumAt(plan, point, &shared::HdsVolumeTerm::emission),
                          GridCellAt(emission, voxel).greatest * (1 + 1e-5) + 1e-6)
                    << i;
            }
        }
    }
    EXPECT_GT(numPatterns, 60);
}

TEST_F(VolumeTerms, WhatHasNoBoundIsLeftOut) {
    Network made;
    const std::string place = made.Add("ND_position_vector3", {});
    const std::string x =
        made.Add("ND_extract_vector3", {{"in", place}}, {{"index", std::int64_t{0}}});
    const std::string quotient = made.Add("ND_divide_float", {{"in2", x}}, {{"in1", 1.0}});
    const std::string product =
        made.Add("ND_multiply_float", {{"in1", quotient}, {"in2", made.Field("a")}});
    made.End(product, made.Field("a"), made.Field("a"));
    const TermPlan plan = Plan(made.network);
    ASSERT_EQ(plan.terms.size(), 1U) << "a alone";
    EXPECT_EQ(plan.terms[0].extinction[0], 1.0F);
    ASSERT_EQ(_warnings.Lines().size(), 1U);
    EXPECT_NE(_warnings.Lines()[0].find("no bound"), std::string::npos);
}

} // namespace
} // namespace hds
