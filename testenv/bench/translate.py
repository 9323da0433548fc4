# SPDX-License-Identifier: Apache-2.0
"""Prints how many prims a second the Python front end translates: translate.py [NUM_MESHES].

The stage (default 10^5 meshes) has a group a hundred meshes, and each mesh has a transform,
displayColor, uvs, normals and a bound material, one of 16: what a layout of small props has. It is
made once, as a crate file, in the temporary directory. Bar: 3000 prims a second on one core
(docs/performance.md). Run with PYTHONPATH=<build>/python; pin to one core with taskset -c 0.
"""

import os
import resource
import sys
import tempfile
import time

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

from hdstream import _core
from hdstream.translate import TranslateStage

MESHES_PER_GROUP = 100
NUM_MATERIALS = 16


def MakeMaterials(stage):
    materials = []
    for index in range(NUM_MATERIALS):
        material = UsdShade.Material.Define(stage, f"/World/Looks/M{index}")
        shader = UsdShade.Shader.Define(stage, f"/World/Looks/M{index}/Surface")
        shader.SetShaderId("UsdPreviewSurface")
        shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(index / NUM_MATERIALS)
        output = shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
        material.CreateSurfaceOutput().ConnectToSource(output)
        materials.append(material)
    return materials


def MakeMesh(stage, path, rng):
    mesh = UsdGeom.Mesh.Define(stage, path)
    points = rng.random((24, 3), np.float32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(6, 4, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.arange(24, dtype=np.int32)))
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.CreateExtentAttr([(0, 0, 0), (1, 1, 1)])
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateDisplayColorAttr([Gf.Vec3f(*map(float, rng.random(3)))])
    uvs = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
    uvs.Set(Vt.Vec2fArray.FromNumpy(rng.random((24, 2), np.float32)))
    mesh.AddTranslateOp().Set(Gf.Vec3d(*map(float, rng.random(3) * 1000)))
    return mesh


def MakeStage(path, numMeshes):
    stage = Usd.Stage.CreateNew(path)
    UsdGeom.Xform.Define(stage, "/World")
    materials = MakeMaterials(stage)
    rng = np.random.default_rng(7)
    with Sdf.ChangeBlock():
        layer = stage.GetRootLayer()
        for index in range(numMeshes):
            Sdf.CreatePrimInLayer(layer, f"/World/Group{index // MESHES_PER_GROUP}/Mesh{index}")
    for index in range(numMeshes):
        group = f"/World/Group{index // MESHES_PER_GROUP}"
        if index % MESHES_PER_GROUP == 0:
            UsdGeom.Xform.Define(stage, group).AddTranslateOp().Set(Gf.Vec3d(index, 0, 0))
        mesh = MakeMesh(stage, f"{group}/Mesh{index}", rng)
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(materials[index % NUM_MATERIALS])
    stage.GetRootLayer().Save()


def Main():
    numMeshes = int(sys.argv[1]) if len(sys.argv) > 1 else 100000
    path = os.path.join(tempfile.gettempdir(), f"hdstreamTranslate{numMeshes}.usdc")
    if not os.path.exists(path):
        MakeStage(path, numMeshes)
    start = time.perf_counter()
    stage = Usd.Stage.Open(path)
    loaded = time.perf_counter()
    cpuStart = time.process_time()
    session = _core.Session()
    translator = TranslateStage(stage, session, stage.GetStartTimeCode())
    seconds = time.perf_counter() - loaded
    cpuSeconds = time.process_time() - cpuStart
    assert len(session.Scene().geometry) == numMeshes
    peakMegabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"load {loaded - start:.2f} s, translate {translator.numPrims} prims in {seconds:.2f} s: "
          f"{translator.numPrims / seconds:.0f} prims/s ({translator.numPrims / cpuSeconds:.0f} a second of CPU "
          f"time, which other programs do not slow), peak {peakMegabytes:.0f} MiB")


if __name__ == "__main__":
    Main()
