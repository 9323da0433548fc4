// SPDX-License-Identifier: Apache-2.0
// The control cage as OpenSubdiv wants it: only usable faces, tags checked, one face-varying
// channel per faceVarying primvar. Internal to geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/triangleMesh.h"

#include <opensubdiv/far/topologyRefiner.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// Usable faces of a mesh and its checked tags.
struct SubdivCage {
    std::vector<int> counts;            ///< [numFaces]
    std::vector<int> indices;           ///< [numCorners] points
    std::vector<std::uint32_t> faces;   ///< [numFaces] authored face
    std::vector<std::uint32_t> corners; ///< [numCorners] authored face-vertex
    std::vector<int> holes;       ///< cage faces that are not drawn, but shape their neighbours
    std::vector<int> creasePairs; ///< two points per edge
    std::vector<float> creaseWeights;
    std::vector<int> cornerPoints;
    std::vector<float> cornerWeights;
    OpenSubdiv::Sdc::Options options;
};

/// Value indices of a face-varying channel, one per cage corner.
struct SubdivChannel {
    int numValues = 0;
    std::vector<int> valueIndices;
};

/// Checks the mesh; what is dropped is warned about as Triangulate does.
SubdivCage BuildSubdivCage(const GeometryDescription& mesh, const std::string& primPath,
                           Warnings& warnings);

/// \return null when OpenSubdiv refuses the topology. Precondition: a subdivision scheme.
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner>
CreateRefiner(const GeometryDescription& mesh, const SubdivCage& cage,
              const std::vector<SubdivChannel>& channels);

} // namespace hds
