// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/geometryCommit.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/base/error.h"
#include "hdStream/base/forEachArray.h"
#include "hdStream/geometry/awayArrays.h"
#include "hdStream/geometry/curveSource.h"
#include "hdStream/geometry/pointSource.h"
#include "hdStream/geometry/polygonSource.h"
#include "hdStream/geometry/splatSource.h"
#include "hdStream/geometry/subdivSource.h"
#include "hdStream/persist/arrayFiles.h"
#include "hdStream/scene/geometryKey.h"
#include "hdStream/scene/geometryMotion.h"
#include "hdStream/scene/meshDisplacement.h"
#include "hdStream/scene/transforms.h"

#include <algorithm>

namespace hds {

namespace {

/// Geometry of fewer triangles is looked at as fast as its summary is read.
constexpr std::uint64_t kMinKeptSummary = 256;

/// Makes the chunks, ordered by the leaves of a BVH over their boxes.
void BuildTopTree(PlannedGeometry* planned) {
    const std::vector<Bounds>& boxes = planned->geometry->Summary().chunkBounds;
    const auto addChunk = [&](std::uint32_t chunk) {
        planned->chunks.push_back(std::make_shared<ChunkPages>(planned->geometry, chunk));
    };
    if (boxes.size() == 1) {
        addChunk(0);
        return;
    }
    BvhOptions options;
    options.maxLeafItems = 1;
    Bvh tree = BuildBvh(boxes, options);
    std::for_each(tree.order.begin(), tree.order.end(), addChunk);
    planned->topNodes = std::move(tree.nodes);
}

/// A source that holds arrays that may be mapped from files: no triangles are made of files that
/// have been written into.
class WatchedSource final : public ChunkSource {
public:
    WatchedSource(std::shared_ptr<const ChunkSource> source, std::string path,
                  std::shared_ptr<const GeometryDescription> geometry)
        : _source(std::move(source)), _path(std::move(path)), _geometry(std::move(geometry)) {
        _bounds = _source->AllBounds();
        _numGroups = _source->NumPrimitiveGroups();
        _numTriangles = _source->NumTriangles();
        _numVertices = _source->NumVertices();
        _origin = _source->Origin();
        _isLeftHanded = _source->IsLeftHanded();
        _attributes = _source->Attributes();
        _boundBytes = _source->BoundBytes();
        _meanBytes = _source->MeanBytes();
    }

    std::uint32_t GroupTriangles(std::uint32_t group) const override {
        return _source->GroupTriangles(group);
    }
    Bounds GroupBounds(std::uint32_t group) const override { return _source->GroupBounds(group); }
    std::uint64_t TableBytes() const override { return sizeof(*this) + _source->TableBytes(); }

    ChunkGeometry Gather(const std::uint32_t* groups, std::size_t count) const override {
        ChunkGeometry chunk = _source->Gather(groups, count);
        // Now that all has been read: what is written later is no part of it.
        ForEachArray(*_geometry, [this](const auto& array) {
            try {
                ArrayFiles::Check(array.Source());
            } catch (const Error& error) {
                throw Error(_path + ": cannot be read again: " + error.what());
            }
        });
        return chunk;
    }

private:
    std::shared_ptr<const ChunkSource> _source;
    std::string _path;
    std::shared_ptr<const GeometryDescription> _geometry; ///< whose arrays are away
};

/// The source of arrays that are held.
std::shared_ptr<const ChunkSource> SourceOf(const std::shared_ptr<const GeometryDescription>& held,
                                            const std::string& path, const GeometryInputs& inputs,
                                            Warnings& warnings) {
    const std::shared_ptr<const GeometryDescription> geometry =
        inputs.shutter.IsOpen() ? AtShutter(*held, inputs.shutter) : held;
    if (geometry->primitives == PrimitiveKind::Curves) {
        return MakeCurveSource(geometry, path, warnings);
    }
    if (geometry->primitives == PrimitiveKind::Points) {
        return MakePointSource(geometry, path, warnings);
    }
    if (geometry->primitives == PrimitiveKind::Splats) {
        return MakeSplatSource(geometry, path, warnings);
    }
    const Displacement displacement = MakeDisplacement(inputs.displacements);
    if (*inputs.dicing) {
        auto source = MakeSubdivSource(geometry, path, **inputs.dicing, displacement, warnings,
                                       inputs.autobump);
        if (source) {
            return source;
        }
    }
    return MakePolygonSource(geometry, path, displacement, warnings, inputs.autobump);
}

std::shared_ptr<const ChunkSource> MakeSource(const std::string& path, const GeometryInputs& inputs,
                                              Warnings& warnings) {
    const std::shared_ptr<const GeometryDescription> held = Held(inputs.geometry);
    auto source = SourceOf(held, path, inputs, warnings);
    return held == inputs.geometry
               ? source
               : std::make_shared<const WatchedSource>(std::move(source), path, inputs.geometry);
}

/// The inputs without the primvars that nobody reads: themselves where all are read.
std::shared_ptr<const GeometryInputs>
OnlyRead(const std::shared_ptr<const GeometryInputs>& inputs) {
    const std::vector<std::string>& read = inputs->primvars;
    const auto isUnread = [&](const Primvar& primvar) {
        return primvar.name != "normals" && primvar.name != "widths" &&
               !std::binary_search(read.begin(), read.end(), primvar.name);
    };
    const std::vector<Primvar>& all = inputs->geometry->primvars;
    if (std::any_of(all.begin(), all.end(), isUnread)) {
        auto geometry = std::make_shared<GeometryDescription>(*inputs->geometry);
        geometry->primvars.erase(
            std::remove_if(geometry->primvars.begin(), geometry->primvars.end(), isUnread),
            geometry->primvars.end());
        auto fewer = std::make_shared<GeometryInputs>(*inputs);
        fewer->geometry = std::move(geometry);
        return fewer;
    }
    return inputs;
}

} // namespace

bool GeometryInputs::Suffice(const GeometryInputs& other) const {
    bool areEqual = true;
    ForEachField<GeometryInputs>([&](const auto& field) {
        if (!field.Is(&GeometryInputs::primvars)) {
            areEqual = areEqual && this->*field.member == other.*field.member;
        }
    });
    return areEqual && std::includes(primvars.begin(), primvars.end(), other.primvars.begin(),
                                     other.primvars.end());
}

PlannedGeometry PlanGeometry(const std::string& path,
                             const std::shared_ptr<const GeometryInputs>& all,
                             std::shared_ptr<PageStore> store, Warnings& warnings,
                             std::shared_ptr<SourceKeeper> keeper) {
    const std::shared_ptr<const GeometryInputs> inputs = OnlyRead(all);
    const auto held = Held(inputs->geometry); // read once, for the key and for the source
    const PageKey key = store ? MakeGeometryKey(*inputs) : PageKey();
    const auto geometry = std::make_shared<const ChunkedGeometry>(
        [path, inputs, &warnings] { return MakeSource(path, *inputs, warnings); },
        inputs->chunkBytes, std::move(store), key, std::move(keeper), AwayBytes(*inputs->geometry));
    DropArrays(*all->geometry);
    const GeometrySummary& summary = geometry->Summary();
    if (summary.numTriangles >= kMinKeptSummary && !warnings.Has(path)) {
        geometry->SaveSummary();
    }
    PlannedGeometry result;
    result.leftHanded = summary.isLeftHanded;
    result.origin = summary.origin;
    result.numTriangles = summary.numTriangles;
    for (const AttributeFormat& attribute : summary.attributes) {
        result.attributes.push_back({attribute.name, attribute.numComponents});
    }
    if (result.numTriangles > 0) {
        for (const Bounds& bounds : summary.chunkBounds) {
            ExtendBounds(&result.bounds, bounds);
        }
        result.geometry = geometry;
        BuildTopTree(&result);
    }
    return result;
}

ChunkGeometry GatherAll(const PlannedGeometry& planned) {
    const auto cut = planned.geometry->Hold();
    std::vector<std::uint32_t> groups = cut->plan.groups;
    std::sort(groups.begin(), groups.end());
    return cut->source->Gather(groups.data(), groups.size());
}

} // namespace hds
