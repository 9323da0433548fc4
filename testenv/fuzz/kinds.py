# SPDX-License-Identifier: Apache-2.0
"""Fuzzing of what files hold: mutated stages and damaged images; and the list of all kinds."""

import os
import signal

from cacheKind import Cache
from commandKinds import CommandLine, Settings
from fileKinds import Ies, MaterialX
from fuzzKind import Kind
from volumeKind import Volume


class Usd(Kind):
    """Mutated text of stages."""

    def __init__(self, folder, seed):
        super().__init__(folder, seed)
        from stages import fuzzBase

        fuzzBase.WriteImages(folder)
        self._texts = fuzzBase.Texts()

    def RunCase(self, rng) -> str:
        from textMutation import Mutated

        base = self._texts[0] if rng.random() < 0.3 else rng.choice(self._texts)
        stage = self.Write("stage.usda", Mutated(base, rng, self._texts))
        options = ["--imageWidth", 16, "--samples", 2, "--maxDepth", 3, "--time", 5,
                   "--residency", rng.choice(["auto", "stream", "resident"])]
        options += rng.choice([[], ["--imageHeight", 12], ["--subdivision", "complexity", "--complexity", rng.randrange(4)],
                               ["--frames", rng.choice(["1:2", "0:3x0.5"])], ["--aovs", "color,depth,normal,albedo,position"]])
        if "--frames" in options:
            return self.Command("record", stage, "out.####.##.exr", "--quiet", *options)
        if rng.random() < 0.05:
            return self.Command("info", stage, "--json", "info.json")
        return self.Record(stage, *options)


class Image(Kind):
    """Damaged image files as textures, normal maps, displacement and lights."""

    def __init__(self, folder, seed):
        super().__init__(folder, seed)
        from images import WriteFormats
        from stages import fuzzBase

        fuzzBase.WriteImages(folder)
        self._images = WriteFormats(self.folder / "formats")
        self._stage = fuzzBase.Texts()[0]

    def RunCase(self, rng) -> str:
        from byteMutation import Mutated

        source = rng.choice(self._images)
        image = self.Write(f"image{source.suffix}", Mutated(source.read_bytes(), rng))
        stage = self._stage
        names = ["color.png", "rough.exr", "sky.exr", "tile.<UDIM>.png"]
        for name in rng.sample(names, rng.choice([1, 2, 4])):
            stage = stage.replace(f"@./{name}@", f"@./{image}@")
        stage = self.Write("stage.usda", stage)
        return self.Record(stage, "--imageWidth", 16, "--samples", 2, "--maxDepth", 3, "--time", 5,
                           "--residency", rng.choice(["stream", "resident"]), "--textureMemory", rng.choice(["4M", "64M", "50%"]))


class SelfTest(Kind):
    """What goes wrong is decided by the number: for the driver's own test."""

    def Run(self, number: int) -> str:
        (self.folder / "case.txt").write_text(str(number), encoding="utf-8")
        if number == 1:
            os.kill(os.getpid(), signal.SIGSEGV)
        if number == 2:
            os._exit(3)
        while number == 100:
            pass
        return "wrong" if number == 3 else ""


KINDS = {"usd": Usd, "image": Image, "cache": Cache, "commandline": CommandLine, "settings": Settings, "ies": Ies,
         "materialX": MaterialX, "volume": Volume, "selfTest": SelfTest}
