# SPDX-License-Identifier: Apache-2.0
"""One session that is edited and rendered thousands of times: does its memory grow?

    longRun.py [--frames 10000] [--seed 1] [--residency stream,resident] [--out docs/images/longRun]

Each frame makes one to three edits (transforms, points, materials and their images, meshes and lights that come and go, the camera,
instances, visibility, resolution, layers, settings; some renders are stopped) and renders a tiny picture. Every `--every` frames the scene is put
back into its first state: the picture then has the bits that it had the first time. Sampled there: resident set, bytes that the
process has from malloc (mallinfo2), device bytes. At the end the session gives everything back and begins anew: the device must then
have exactly the bytes of the first sample. Printed: the samples, and the slope of the second half.
"""

import argparse
import ctypes
import json
import os
import pathlib
import random
import sys
import tempfile
from dataclasses import dataclass

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from stages import fuzzBase  # noqa: E402
from support.svgChart import Chart  # noqa: E402

_SIZES = [(20, 14), (33, 17), (8, 48)]
_AOVS = [["color"], ["color", "depth"], ["color", "normal", "primId", "variance"]]
_MOST_ADDED = 12


class _MallInfo(ctypes.Structure):
    _fields_ = [(name, ctypes.c_size_t) for name in ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks",
                                                     "uordblks", "fordblks", "keepcost")]


def MallocBytes() -> int:
    """Bytes that the process holds from malloc; 0 where glibc is too old to say."""
    library = ctypes.CDLL(None)
    if not hasattr(library, "mallinfo2"):
        return 0
    library.mallinfo2.restype = _MallInfo
    info = library.mallinfo2()
    return info.uordblks + info.hblkhd


def ResidentBytes() -> int:
    """Of the process, after malloc has given back what it can."""
    ctypes.CDLL(None).malloc_trim(0)
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@dataclass
class Sample:
    frame: int
    residentBytes: int
    mallocBytes: int
    deviceBytes: int
    picture: bytes


class EditedSession:
    """A session over the stage of stages/fuzzBase.py and the edits that are made to it."""

    def __init__(self, folder, residency: str, seed: int):
        from hdstream import _core
        from hdstream.translate import TranslateStage
        from pxr import Usd

        fuzzBase.WriteImages(folder)
        path = pathlib.Path(folder) / "stage.usda"
        path.write_text(fuzzBase.Texts()[0], encoding="utf-8")
        self._core, self._random, self.residency = _core, random.Random(seed), residency
        self.session = _core.Session()
        TranslateStage(Usd.Stage.Open(str(path)), self.session, Usd.TimeCode.Default())
        scene = self.session.Scene()
        self._set = {"geometry": self.session.SetGeometry, "lights": self.session.SetLight, "materials": self.session.SetMaterial,
                     "instancers": self.session.SetInstancer, "cameras": self.session.SetCamera}
        # Stages are read once: their prims are the first state.
        self._first = {kind: dict(getattr(scene, kind)) for kind in self._set}
        self._added, self._numAdded = [], 0
        self.settings = self._FirstSettings()

    def _FirstSettings(self):
        settings = self._core.Settings()
        settings.camera, settings.residency, settings.samples, settings.maxDepth = "/main_cam", self.residency, 1, 2
        settings.imageWidth, settings.imageHeight = _SIZES[0]
        settings.geometryMemory, settings.textureMemory, settings.chunkBytes = "256K", "1M", 4096
        settings.hostMemory = 1 << 20
        return settings

    # --- Edits -----------------------------------------------------------------------------------

    def Edit(self) -> None:
        edits = [self._Move, self._Points, self._Add, self._Take, self._Hide, self._Material, self._Light, self._Camera, self._Instances,
                 self._Setting, self._Setting]
        for _ in range(self._random.randrange(1, 4)):
            self._random.choice(edits)()
        if self._random.random() < 0.02:
            self.session.FlushTextures()

    def _Mesh(self):
        return self._random.choice(sorted(self._first["geometry"].items()))

    def _Copy(self, prim, geometry=None, **placement):
        """The mesh prim with another description or placement."""
        old = prim.placement
        place = self._core.Placement(placement.get("matrix", old.worldFromObject), old.instancerPath, old.instances,
                                     placement.get("visible", old.visible))
        copy = self._core.GeometryPrim(geometry or prim.geometry, place, prim.purpose, prim.materialPath)
        copy.doubleSided, copy.subsetMaterialPaths = prim.doubleSided, prim.subsetMaterialPaths
        return copy

    def _Matrix(self, matrix):
        matrix = np.array(matrix)
        matrix[3, :3] += [self._random.uniform(-1, 1) for _ in range(3)]
        return matrix

    def _Move(self):
        path, prim = self._Mesh()
        self.session.SetGeometry(path, self._Copy(prim, matrix=self._Matrix(prim.placement.worldFromObject)))

    def _OtherPoints(self, prim):
        mesh = self._core.GeometryDescription()
        for name in ("faceVertexCounts", "faceVertexIndices", "holeIndices", "subdivisionScheme", "subdivTags", "leftHanded",
                     "primvars", "subsets"):
            setattr(mesh, name, getattr(prim.geometry, name))
        mesh.points = np.array(prim.geometry.points).reshape(-1, 3) * np.float32(self._random.uniform(0.5, 1.5))
        return mesh

    def _Points(self):
        path, prim = self._Mesh()
        self.session.SetGeometry(path, self._Copy(prim, self._OtherPoints(prim)))

    def _Add(self):
        _, prim = self._Mesh()
        self._numAdded += 1
        path = f"/Added{self._numAdded}"
        self.session.SetGeometry(path, self._Copy(prim, self._OtherPoints(prim), matrix=self._Matrix(prim.placement.worldFromObject)))
        self._added.append(path)
        if len(self._added) > _MOST_ADDED:
            self.session.Remove(self._added.pop(0))

    def _Take(self):
        kind = self._random.choice(["geometry", "lights", "materials"])
        self.session.Remove(self._random.choice(sorted(self._first[kind])))

    def _Hide(self):
        path, prim = self._Mesh()
        self.session.SetGeometry(path, self._Copy(prim, visible=False))

    def _Material(self):
        """One parameter of one node; sometimes another image."""
        path, network = self._random.choice(sorted(self._first["materials"].items()))
        nodes = []
        for node in network.nodes:
            parameters = dict(node.parameters)
            for name, value in parameters.items():
                if isinstance(value, float):
                    parameters[name] = self._random.uniform(0, 1)
                elif isinstance(value, self._core.AssetReference) and self._random.random() < 0.3:
                    folder = pathlib.Path(value.file).parent
                    parameters[name] = self._core.AssetReference("other", str(folder / self._random.choice(["color.png", "rough.exr"])))
            nodes.append(self._core.MaterialNode(node.path, node.identifier, parameters, dict(node.connections)))
        self.session.SetMaterial(path, self._core.MaterialNetwork(nodes, dict(network.terminals)))

    def _Light(self):
        path, prim = self._random.choice(sorted(self._first["lights"].items()))
        light = self._core.LightDescription()
        for name in ("type", "exposure", "color", "angle", "radius", "width", "height", "length", "textureFile"):
            setattr(light, name, getattr(prim.light, name))
        light.intensity = self._random.uniform(0, 10)
        place = self._core.Placement(self._Matrix(prim.placement.worldFromObject))
        self._numAdded += 1
        new = self._random.choice([path, f"/Light{self._numAdded}"])
        self.session.SetLight(new, self._core.LightPrim(light, place))
        if new != path:
            self._added.append(new)
            if len(self._added) > _MOST_ADDED:
                self.session.Remove(self._added.pop(0))

    def _Camera(self):
        camera = self._core.CameraPrim()
        first = self._first["cameras"]["/main_cam"]
        camera.horizontalAperture, camera.verticalAperture = first.horizontalAperture, first.verticalAperture
        camera.focalLength = first.focalLength * self._random.uniform(0.5, 2)
        camera.worldFromCamera = self._Matrix(first.worldFromCamera)
        self.session.SetCamera("/main_cam", camera)

    def _Instances(self):
        path, prim = self._random.choice(sorted(self._first["instancers"].items()))
        copy = self._core.InstancerPrim(prim.placement)
        matrices = np.array(prim.instanceTransforms).reshape(-1, 4, 4).copy()
        matrices[:, 3, :3] += self._random.uniform(-0.5, 0.5)
        copy.instanceTransforms = matrices
        self.session.SetInstancer(path, copy)

    def _Setting(self):
        settings = self.settings
        self._random.choice([
            lambda: self._SetSize(self._random.choice(_SIZES)), lambda: setattr(settings, "aovs", self._random.choice(_AOVS)),
            lambda: setattr(settings, "seed", self._random.randrange(1000)),
            lambda: setattr(settings, "domeVisible", self._random.random() < 0.5),
            lambda: setattr(settings, "cullStyle", self._random.choice(["nothing", "back"])),
            lambda: setattr(settings, "subdivision", self._random.choice(["adaptive", "cage"])),
            lambda: setattr(settings, "maxDepth", self._random.randrange(4))])()

    def _SetSize(self, size):
        self.settings.imageWidth, self.settings.imageHeight = size

    # --- Frames ----------------------------------------------------------------------------------

    def Render(self) -> None:
        """Some renders are stopped after a few reports."""
        reports = self._random.choice([None] * 9 + [0, 1, 3])
        left = iter(range(reports if reports is not None else 1 << 30))
        self.session.Render(self.settings, lambda progress: next(left, None) is not None)

    def Restore(self) -> None:
        """The first state."""
        for path in self._added:
            self.session.Remove(path)
        self._added.clear()
        for kind, prims in self._first.items():
            for path, prim in prims.items():
                self._set[kind](path, prim)
        self.settings = self._FirstSettings()

    def Sample(self, frame: int, discards: bool = False) -> Sample:
        """Of the first state. Rendered twice: the peak of the second is what there is. `discards`: the session first gives back
        all of the device's memory and its prepared pages, as it does for another cache folder."""
        self.Restore()
        if discards:
            self.settings.cacheDirectory = os.path.join(self._core.InspectCache("").directory, ".")
        for _ in range(2):
            assert self.session.Render(self.settings) == self._core.RenderResult.Complete
        picture = b"".join(np.array(layer.pixels).tobytes() for layer in self.session.Layers())
        memory = json.loads(self.session.Statistics())["memory"]
        return Sample(frame, ResidentBytes(), MallocBytes(), memory["devicePeak"], picture)


def Run(folder, residency: str, frames: int, every: int, seed: int, onSample=lambda sample: None) -> list:
    """Samples of the first state: before the first edit, after each `every` frames, and at the end once more after the session has
    given everything back: the device then has exactly the bytes of the first one, unless something holds what nobody uses."""
    edited = EditedSession(folder, residency, seed)
    samples = []

    def Take(frame, discards=False):
        samples.append(edited.Sample(frame, discards))
        onSample(samples[-1])

    Take(0)
    for frame in range(1, frames + 1):
        edited.Edit()
        edited.Render()
        if frame % every == 0:
            Take(frame)
    Take(frames, discards=True)
    return samples


def SlopeBytes(samples, name: str) -> float:
    """Bytes a frame over the second half, by least squares; without the last sample."""
    half = samples[len(samples) // 2: -1]
    return float(np.polyfit([s.frame for s in half], [getattr(s, name) for s in half], 1)[0]) if len(half) > 1 else 0.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=10000)
    parser.add_argument("--every", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--residency", default="stream,resident")
    parser.add_argument("--out", help="stem of the chart")
    args = parser.parse_args()
    chart = Chart("One session, edited before each frame", "frames", "MB")
    print("| residency | frame | resident MB | malloc MB | device bytes | same bits |")
    print("|---" * 6 + "|", flush=True)
    for residency in args.residency.split(","):
        with tempfile.TemporaryDirectory() as folder:
            first = []

            def Print(sample, residency=residency, first=first):
                first.append(sample.picture)
                print(f"| {residency} | {sample.frame} | {sample.residentBytes / 1e6:.1f} | {sample.mallocBytes / 1e6:.2f} | "
                      f"{sample.deviceBytes} | {sample.picture == first[0]} |", flush=True)

            samples = Run(folder, residency, args.frames, args.every, args.seed, Print)
        for name, label in (("residentBytes", "resident set"), ("mallocBytes", "malloc")):
            print(f"{residency}, {label}: {SlopeBytes(samples, name):.0f} bytes a frame in the second half", flush=True)
            chart.Add(f"{residency}, {label}", [s.frame for s in samples], [getattr(s, name) / 1e6 for s in samples])
        chart.Add(f"{residency}, device", [s.frame for s in samples], [s.deviceBytes / 1e6 for s in samples])
    if args.out:
        chart.Save(args.out)


if __name__ == "__main__":
    main()
