# SPDX-License-Identifier: Apache-2.0
"""The triangles of a stage, in world space, for `benchTraversal --stage FILE`.

Usage: traversalStage.py STAGE FILE [--camera PATH]    (prints the number of triangles)

Each mesh is cut into triangles as fans, as it is when it is not subdivided. The rays of the
benchmark begin at the camera: the one that is named, else the first that the stage has.
"""

import argparse

import numpy as np
from pxr import Usd, UsdGeom


def meshes(stage):
    """Positions in world space and triangles of each mesh."""
    cache = UsdGeom.XformCache()
    for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()):
        mesh = UsdGeom.Mesh(prim)
        if not mesh or UsdGeom.Imageable(prim).ComputeVisibility() == UsdGeom.Tokens.invisible:
            continue
        points = mesh.GetPointsAttr().Get()
        counts = np.array(mesh.GetFaceVertexCountsAttr().Get() or [], dtype=np.int64)
        indices = np.array(mesh.GetFaceVertexIndicesAttr().Get() or [], dtype=np.uint32)
        if not points or counts.sum() != len(indices):
            continue
        world = np.array(cache.GetLocalToWorldTransform(prim))
        positions = np.array(points, dtype=np.float64) @ world[:3, :3] + world[3, :3]
        begin = np.repeat(np.cumsum(counts) - counts, np.maximum(counts - 2, 0))
        first = np.cumsum(np.maximum(counts - 2, 0)) - np.maximum(counts - 2, 0)
        step = np.arange(len(begin)) - np.repeat(first, np.maximum(counts - 2, 0))
        corners = np.stack([begin, begin + step + 1, begin + step + 2], axis=1)
        yield positions.astype(np.float32), indices[corners]


def frame(stage, path):
    """Rows: the eye, forward, and the half extents of the view to the right and up."""
    cameras = [UsdGeom.Camera(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Camera)]
    camera = UsdGeom.Camera.Get(stage, path) if path else cameras[0]
    view = camera.GetCamera(Usd.TimeCode.EarliestTime())
    world = np.array(view.transform)
    width = view.horizontalAperture / (2 * view.focalLength)
    return np.array([world[3, :3], -world[2, :3], width * world[0, :3], width * world[1, :3]])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("stage")
    parser.add_argument("file")
    parser.add_argument("--camera")
    options = parser.parse_args()
    stage = Usd.Stage.Open(options.stage)
    parts = list(meshes(stage))
    with open(options.file, "wb") as out:
        out.write(frame(stage, options.camera).astype("<f4").tobytes())
        out.write(np.uint32(len(parts)).tobytes())
        for positions, triangles in parts:
            out.write(np.array([len(positions), len(triangles)], dtype="<u4").tobytes())
            out.write(positions.astype("<f4").tobytes())
            out.write(triangles.astype("<u4").tobytes())
    print(sum(len(triangles) for _, triangles in parts))


if __name__ == "__main__":
    main()
