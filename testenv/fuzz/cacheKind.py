# SPDX-License-Identifier: Apache-2.0
"""Fuzzing of the persistent cache: its files of pages and lines are damaged between two runs, which must give the picture
that a run without them gives."""

import os
import pathlib
import shutil

import numpy as np

from fuzzKind import Kind

_SIZE = (48, 32)


class Cache(Kind):
    def __init__(self, folder, seed):
        super().__init__(folder, seed)
        from hdstream import _core
        from stages import streaming, textured

        self._core = _core
        self._stages = []
        for name, write in (("overlap", lambda path: streaming.WriteOverlap(path, meshes=6, rings=12)),
                            ("textured", textured.WriteTextured)):
            path = self.folder / name / "stage.usda"
            if not path.exists():
                path.parent.mkdir()
                write(str(path))
            self._stages.append(path)
        self._full = self.folder / "full"
        shutil.rmtree(self._full, ignore_errors=True)
        self._CopyKernels(self._full)
        self._wanted = [self._Picture(stage, self._full, residency="resident") for stage in self._stages]

    def _CopyKernels(self, target) -> None:
        """Kernels, which take half a minute to build, are shared."""
        target.mkdir()
        for kernel in pathlib.Path(self._core.InspectCache("").directory).glob("kernel-*.hdsc"):
            os.link(kernel, target / kernel.name)

    def _Picture(self, stage, cache, **options) -> list:
        from hdstream.translate import TranslateStage
        from pxr import Usd

        session = self._core.Session()
        TranslateStage(Usd.Stage.Open(str(stage)), session, Usd.TimeCode.Default())
        settings = self._core.Settings()
        settings.camera, settings.imageWidth, settings.imageHeight = "/World/Camera", *_SIZE
        settings.samples, settings.maxDepth, settings.chunkBytes, settings.cacheDirectory = 2, 3, 4096, str(cache)
        settings.aovs = ["color", "depth", "normal"]
        for name, value in options.items():
            setattr(settings, name, value)
        session.Render(settings)
        return [np.array(layer.pixels).tobytes() for layer in session.Layers()]

    def RunCase(self, rng) -> str:
        from byteMutation import Mutated

        cache = self.folder / "cache"
        shutil.rmtree(cache, ignore_errors=True)
        cache.mkdir()
        for source in self._full.iterdir():
            if source.name.startswith("kernel-"):
                os.link(source, cache / source.name)
            else:
                (cache / source.name).write_bytes(Mutated(source.read_bytes(), rng) if rng.random() < 0.8 else source.read_bytes())
        which = rng.randrange(len(self._stages))
        options = dict(residency=rng.choice(["stream", "resident", "auto", "mapped"]), prepare=rng.choice(["lazy", "eager"]),
                       hostMemory=rng.choice([0, 1 << 14]), geometryMemory=rng.choice(["64M", "100K"]),
                       textureMemory=rng.choice(["64M", "8M"]))
        (self.folder / "case.txt").write_text(f"{self._stages[which]} {options}", encoding="utf-8")
        for turn in range(2):
            try:
                picture = self._Picture(self._stages[which], cache, **options)
            except self._core.Error as error:
                return f"run {turn + 1} with {options['residency']}: {error}"
            if picture != self._wanted[which]:
                return f"run {turn + 1} with {options['residency']}: another picture"
        return ""
