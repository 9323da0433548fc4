// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/meshKey.h"

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
        Add(primvar.numComponents);
        Add(primvar.values);
        Add(primvar.indices);
    }
    void Add(const MeshDescription& mesh) {
        Add(mesh.points);
        Add(mesh.faceVertexCounts);
        Add(mesh.faceVertexIndices);
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
    void Add(const MeshOptions& options) {
        Add(options.chunkBytes);
        Add(static_cast<std::uint64_t>(options.subdivision));
        Add(options.refineLevel);
    }
    PageKey Key() const { return MakePageKey(_hasher); }

private:
    Hasher _hasher;
};

} // namespace

PageKey MakeMeshKey(const MeshDescription& mesh, const MeshOptions& options) {
    KeyHasher hasher;
    hasher.Add(mesh);
    hasher.Add(options);
    return hasher.Key();
}

} // namespace hds
