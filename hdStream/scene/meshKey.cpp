// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/meshKey.h"

#include <cstring>

namespace hds {

namespace {

/// Below it, arrays are hashed on the spot.
constexpr std::size_t kParallelBytes = 1U << 20U;

class KeyHasher {
public:
    template <typename T>
    void Add(const SharedSpan<T>& values) {
        const std::size_t bytes = values.size() * sizeof(T);
        _hasher.Append(std::uint64_t{values.size()});
        if (bytes >= kParallelBytes) {
            AppendParallel(&_hasher, values.data(), bytes);
        } else if (bytes > 0) {
            _hasher.Append(values.data(), bytes);
        }
    }
    void Add(const std::string& text) { _hasher.Append(std::string_view(text)); }
    void Add(std::uint64_t value) { _hasher.Append(value); }

    void Add(const SubdivTags& tags) {
        Add(tags.interpolateBoundary);
        Add(tags.faceVaryingLinearInterpolation);
        Add(tags.triangleSubdivisionRule);
        Add(tags.creaseIndices);
        Add(tags.creaseLengths);
        Add(tags.creaseSharpnesses);
        Add(tags.cornerIndices);
        Add(tags.cornerSharpnesses);
    }
    void Add(const Primvar& primvar) {
        Add(primvar.name);
        Add(static_cast<std::uint64_t>(primvar.interpolation));
        Add(std::uint64_t{primvar.numComponents});
        Add(primvar.values);
        Add(primvar.indices);
    }
    void Add(const MeshDescription& mesh) {
        Add(static_cast<std::uint64_t>(mesh.primitives));
        Add(mesh.points);
        Add(mesh.faceVertexCounts);
        Add(mesh.faceVertexIndices);
        if (mesh.primitives == PrimitiveKind::Curves) {
            Add(mesh.curves.type);
            Add(mesh.curves.basis);
            Add(mesh.curves.wrap);
        }
        Add(mesh.holeIndices);
        Add(mesh.subdivisionScheme);
        Add(mesh.subdivTags);
        Add(std::uint64_t{mesh.leftHanded ? 1U : 0U});
        Add(std::uint64_t{mesh.primvars.size()});
        for (const Primvar& primvar : mesh.primvars) {
            Add(primvar);
        }
        Add(std::uint64_t{mesh.subsets.size()});
        for (const MeshSubset& subset : mesh.subsets) {
            Add(subset.faces); // names are no part of pages
        }
    }
    void Add(double value) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &value, sizeof(bits));
        Add(bits);
    }
    void Add(const DicingOptions& dicing) {
        Add(std::uint64_t{dicing.isAdaptive ? 1U : 0U});
        Add(std::uint64_t{dicing.level});
        if (!dicing.isAdaptive) {
            return;
        }
        const DicingView& view = dicing.view;
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 4; ++row) {
                Add(view.cameraFromObject[column][row]);
            }
        }
        for (const double value :
             {view.windowMin.x, view.windowMin.y, view.windowMax.x, view.windowMax.y,
              view.imageSize.x, view.imageSize.y, view.nearClip, dicing.maxErrorPixels,
              dicing.maxTurnDegrees, dicing.maxEdgePixels, dicing.maxBumpPixels}) {
            Add(value);
        }
        Add(std::uint64_t{(view.isOrthographic ? 1U : 0U) | (view.isOnlyInstance ? 2U : 0U)});
        Add(std::uint64_t{dicing.offScreenLevel});
    }
    void Add(const DisplacementInput& displacement) {
        Add(static_cast<double>(displacement.constant));
        Add(displacement.primvar);
        Add(std::uint64_t{displacement.lookup ? 1U : 0U});
        if (displacement.lookup) {
            Add(*displacement.lookup);
        }
    }
    /// The heights themselves: a file that changes makes other pages.
    void Add(const DisplacementLookup& lookup) {
        Add(std::uint64_t{lookup.wrapS | lookup.wrapT << 8U});
        for (const double entry : lookup.rows) {
            Add(entry);
        }
        for (const float value :
             {lookup.missing[0], lookup.missing[1], lookup.scale, lookup.bias}) {
            Add(static_cast<double>(value));
        }
        if (lookup.image) {
            Add(std::uint64_t{lookup.image->width});
            const std::size_t bytes = lookup.image->values.size() * sizeof(float);
            AppendParallel(&_hasher, lookup.image->values.data(), bytes);
        }
    }
    PageKey Key() const { return MakePageKey(_hasher); }

private:
    Hasher _hasher;
};

} // namespace

PageKey MakeMeshKey(const MeshInputs& inputs) {
    KeyHasher hasher;
    hasher.Add(*inputs.mesh);
    hasher.Add(inputs.chunkBytes);
    if (inputs.dicing) {
        hasher.Add(*inputs.dicing);
    }
    if (inputs.shutter.IsOpen()) {
        hasher.Add(inputs.shutter.open);
        hasher.Add(inputs.shutter.close);
        for (const PointSample& sample : inputs.mesh->samples) {
            hasher.Add(sample.time);
            hasher.Add(sample.points);
        }
    }
    hasher.Add(std::uint64_t{inputs.displacements.size()});
    for (const DisplacementInput& displacement : inputs.displacements) {
        hasher.Add(displacement);
    }
    return hasher.Key();
}

} // namespace hds
