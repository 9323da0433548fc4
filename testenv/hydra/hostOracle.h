// SPDX-License-Identifier: Apache-2.0
// The oracle of the first-hit AOVs: brute force over all triangles of a scene in double precision,
// through OpenUSD's own projection. Knows meshes with convex planar faces and no subdivision.
#pragma once

#include "host.h"

#include <pxr/base/gf/vec3d.h>

#include <vector>

namespace hydraHost {

/// The nearest surface behind a pixel's centre.
struct OracleHit {
    bool isHit = false;
    /// The pixel is too near to an edge, or to a second surface at the same depth, to compare.
    bool isAmbiguous = false;
    SdfPath prim;
    int instance = -1; ///< parent-major rank; -1: not below an instancer
    int face = 0;      ///< authored
    GfVec3d position{0.0};
    GfVec3d normal{0.0};      ///< world space, geometric, unit length, by orientation
    double depth = 1.0;       ///< clip z mapped to [0, 1]
    double cameraDepth = 0.0; ///< along the view direction, scene units
};

class Oracle {
public:
    /// All visible meshes of the host's scene, as its render pass sees them now.
    explicit Oracle(Host& host);

    /// \param x, y pixel of the buffer, y up.
    OracleHit Trace(int x, int y) const;

private:
    struct Triangle {
        GfVec3d points[3];
        GfVec3d normal;
        SdfPath prim;
        int instance;
        int face;
    };
    void _AddMesh(const SdfPath& path, const GprimData& gprim, const GfMatrix4d& worldFromObject,
                  int instance);

    std::vector<Triangle> _triangles;
    GfMatrix4d _viewFromWorld;
    GfMatrix4d _clipFromWorld;
    GfRect2i _dataWindow;
    int _height;
};

/// The instance transforms of an instancer for one of its prototypes, parent-major.
std::vector<GfMatrix4d> FlattenInstances(const SceneData& scene, const SdfPath& instancer,
                                         const SdfPath& prototype);

} // namespace hydraHost
