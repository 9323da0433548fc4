# SPDX-License-Identifier: Apache-2.0
"""Smooth glass, mirrors, coats, and rays that meet nothing (stages/smooth.py): CPU seconds times relMSE of two folders of kernels, and of Mitsuba.

    smoothSurfaces.py [--stages gems,mirrorRoom,softboxes,wideSky] [--before KERNELS] [--mitsuba] [--samples 32] [--repeats 3]

Every renderer stays in a process of its own, and one renders at a time, in turns, after a picture that compiles what is to be compiled.
The errors are against one reference of the kernels here, in two halves (rivalsLadder.py); those of Mitsuba against its own, which has
smooth surfaces as perfect mirrors (`dielectric`, `conductor`). Printed for each: CPU seconds, relMSE, the same without the 0.1 % of
pixels that are furthest off, each product with the seconds over that of the kernels here (median, least, largest), and the mean of
the reference. --mitsuba needs the Python module and an LLVM that it can use, by DRJIT_LIBLLVM_PATH (rivals.py).
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

_HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(_HERE), str(_HERE.parent), str(_HERE.parent / "render")]

import numpy as np  # noqa: E402

import inTurns  # noqa: E402
from stages import smooth  # noqa: E402

_KERNELS = _HERE.parents[1] / "kernels"


def _BuildHdStream(job: dict):
    from hdstream import _core
    from hdstream.translate import TranslateStage
    from pxr import Usd

    session = _core.Session()
    TranslateStage(Usd.Stage.Open(job["stage"]), session, Usd.TimeCode.Default())
    options = _core.Settings()
    settings = dict(camera="/World/Camera", imageWidth=job["width"], imageHeight=job["height"], maxDepth=job["maxDepth"], pixelFilter="box",
                    pixelFilterWidth=1.0, russianRoulette=False, residency="resident")
    for name, value in settings.items():
        setattr(options, name, value)

    def Render(samples: int, seed: int) -> np.ndarray:
        options.samples, options.seed = samples, seed
        session.Render(options)
        return np.array(session.Layers()[0].pixels[..., :3], np.float32)

    return Render


def _MitsubaBsdf(part) -> dict:
    """Smooth lobes as they are meant: without any roughness. There is no coat over a rough metal in Mitsuba."""
    import mitsubaScene

    if part.material is None:
        color = part.primvars["displayColor"][0, 0]
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": mitsubaScene._Rgb(color)}}
    get = lambda name, default: part.material.get(name, default)
    roughness = get("specular_roughness", 0.2)
    if get("transmission", 0.0) > 0:
        return {"type": "dielectric", "int_ior": float(get("specular_IOR", 1.5)), "ext_ior": 1.0}
    if get("metalness", 0.0) < 1 or get("coat", 0.0) > 0:
        raise ValueError(f"{part.path}: Mitsuba has no such surface")
    # Schlick's term of colours near 1 is near the colour itself.
    look = {"type": "conductor", "material": "none", "specular_reflectance": mitsubaScene._Rgb(get("base_color", (0.8,) * 3))}
    if roughness > 0:
        look.update(type="roughconductor", distribution="ggx", alpha=float(roughness) ** 2)
    return {"type": "twosided", "bsdf": look}


def _BuildMitsuba(job: dict):
    import mitsubaScene
    import stageReader

    mitsubaScene.UseVariant("llvm_ad_rgb")
    mi = mitsubaScene.mi

    def ReadMaterial(material):
        if not material:
            return None
        shader = material.ComputeSurfaceSource("mtlx")[0]
        return {"emissiveColor": (0, 0, 0), **{item.GetBaseName(): item.Get() for item in shader.GetInputs()}}

    stageReader._ReadMaterial, mitsubaScene._Bsdf = ReadMaterial, _MitsubaBsdf
    shapeOf = mitsubaScene.LightShape

    def LightShape(light, folder):
        shape = shapeOf(light, folder)
        if "bsdf" in shape:
            shape["bsdf"] = {"type": "null"}
        return shape

    sensorOf = mitsubaScene.Sensor
    mitsubaScene.LightShape = LightShape
    mitsubaScene.Sensor = lambda *given: {**sensorOf(*given), "sampler": {"type": "multijitter"}}
    with tempfile.TemporaryDirectory() as folder:
        scene = mitsubaScene.Load(stageReader.ReadStage(job["stage"]), job["width"], job["height"], job["maxDepth"] + 2, folder)
    import drjit
    drjit.set_thread_count(job["threads"])

    def Render(samples: int, seed: int) -> np.ndarray:
        total, done = 0.0, 0
        most = max(1, (1 << 22) // (job["width"] * job["height"]))
        while done < samples:
            count = min(most, samples - done)
            total = total + count * np.array(mi.render(scene, spp=count, seed=100003 * seed + done), np.float64)
            done += count
        return (total / samples).astype(np.float32)

    return Render


def _Work(job: dict) -> None:
    """Renders what lines of the input ask for, and tells the CPU seconds."""
    render = (_BuildMitsuba if job["renderer"] == "mitsuba" else _BuildHdStream)(job)
    for line in sys.stdin:
        wanted = json.loads(line)
        begin = time.process_time()
        picture = render(wanted["samples"], wanted["seed"])
        seconds = time.process_time() - begin
        np.save(wanted["out"], picture)
        print(f"SECONDS {seconds}", flush=True)
    os._exit(0)


class Renderer:
    """A process that stays: a script that renders what lines of its input ask for."""

    def __init__(self, script: str, job: dict, kernels, folder: pathlib.Path, build: str | None = None):
        """kernels: a folder of kernels, else the build's own. build: the Python folder of another build."""
        environment = {**os.environ, "POCL_MAX_PTHREAD_COUNT": str(job["threads"])}
        if build:
            environment["PYTHONPATH"] = os.pathsep.join([build, environment.get("PYTHONPATH", "")])
        if kernels:
            environment["HDSTREAM_KERNEL_DIR"] = str(kernels)
        self._process = subprocess.Popen([sys.executable, script, "--work", json.dumps(job)], stdin=subprocess.PIPE,
                                         stdout=subprocess.PIPE, text=True, env=environment)
        self._out = str(folder / f"{id(self)}.npy")

    def Render(self, samples: int, seed: int) -> tuple[np.ndarray, float]:
        self._process.stdin.write(json.dumps(dict(samples=samples, seed=seed, out=self._out)) + "\n")
        self._process.stdin.flush()
        for line in self._process.stdout:
            if line.startswith("SECONDS "):
                return np.load(self._out).astype(np.float64), float(line.split()[1])
        raise SystemExit(f"{pathlib.Path(sys.argv[0]).name}: a renderer has ended")

    def Close(self) -> None:
        self._process.stdin.close()
        self._process.wait()


def _Compare(name: str, args, folder: pathlib.Path) -> None:
    path = folder / f"{name}.usdc"
    smooth.WRITERS[name](str(path))
    aspect = 2.0 if name == "wideSky" else 4 / 3
    job = dict(stage=str(path), width=args.width, height=round(args.width / aspect), maxDepth=smooth.MAX_DEPTH[name], threads=args.threads)
    renderers = {"here": Renderer(__file__, dict(job, renderer="hdstream"), _KERNELS, folder)}
    if args.before:
        renderers["before"] = Renderer(__file__, dict(job, renderer="hdstream"), args.before, folder)
    if args.mitsuba and name != "softboxes":
        renderers["mitsuba"] = Renderer(__file__, dict(job, renderer="mitsuba"), None, folder)
    inTurns.Compare(name, renderers, job, args)



def Main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stages", default=",".join(smooth.WRITERS))
    parser.add_argument("--before", help="folder of other kernels")
    parser.add_argument("--mitsuba", action="store_true")
    parser.add_argument("--samples", type=int, default=32)
    parser.add_argument("--reference", type=int, default=2048)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--width", type=int, default=256)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--work", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.work:
        _Work(json.loads(args.work))
    with tempfile.TemporaryDirectory() as folder:
        for name in args.stages.split(","):
            _Compare(name, args, pathlib.Path(folder))


if __name__ == "__main__":
    Main()
