# SPDX-License-Identifier: Apache-2.0
"""Fuzzing of what a user types: options of the command line, attributes of render settings prims, members of Settings."""

import json

from fuzzKind import Kind
from judge import SampleVerdict

_NUMBERS = ["0", "-1", "1", "2", "3", "7", "0.5", "1e-9", "1e9", "1e300", "-0", "nan", "inf", "-inf", "4294967295", "4294967296",
            "18446744073709551616", "-2147483649", "0x10", "1_000", " 1", "1 ", "+1", "", "one", "\u0661", "1,2", "1e", "--", "%", "#"]
_WORDS = ["", " ", "color", "none", "auto", "stream", "resident", "mapped", "adaptive", "complexity", "cage", "lru", "flush", "list",
          "first", "lazy", "eager", "default", "render", "proxy", "guide", "low", "veryhigh", "sRGB", "openColorIO", "disabled", "mesh",
          "/main_cam", "/Render", "main_cam", "/", "//", "/Floor", "Floor,/Many", "a\nb", "\u00e9\u4e2d", "x" * 5000, "%s%n", "../x",
          "primvars:st", "primvars:displayColor", "depth,depth", "color,nothing", "color,,depth", ",", "variance", "box"]
_SIZES = ["1", "4K", "64K", "1M", "16M", "1G", "0", "-1K", "1e3M", "99999999T", "5%", "0.001%", "100%", "101%", "nan%", "%", "K", "1.5G"]
_FRAMES = ["1", "1:3", "3:1", "1:2x0.5", "1:2x0", "1:3x-1", "1:", ":", "1,2,2", "nan", "1:inf", "1:1e9", "1:2x1e-9", "a:b", "1:2:3", "-1",
           "1e300", "0.1:0.3x0.1"]
_OUTPUTS = ["out.exr", "out.png", "out.jpg", "out.tif", "out.hdr", "out.####.exr", "out.##.##.exr", "out.gif", "out", ".exr", "none/out.exr",
            "stage.usda", "", "out.exr ", "out#.png", "\u00e9.exr", "#.exr", "out.EXR"]
_STAGES = ["stage.usda"] * 12 + ["none.usda", "", ".", "out.exr", "broken.usda", "empty.usda", "color.png"]


class CommandLine(Kind):
    """Random options with random values, most of them near what they should be."""

    def __init__(self, folder, seed):
        super().__init__(folder, seed)
        from stages import fuzzBase

        fuzzBase.WriteImages(folder)
        (self.folder / "stage.usda").write_text(fuzzBase.Texts()[0], encoding="utf-8")
        (self.folder / "broken.usda").write_text("#usda 1.0\ndef {", encoding="utf-8")
        (self.folder / "empty.usda").write_text("", encoding="utf-8")

    def RunCase(self, rng) -> str:
        for old in self.folder.glob("out*"):
            old.unlink()
        command = rng.choice(["record"] * 20 + ["info", "info", "compare", "devices", "cache", "no such", "-h", "--version"])
        if command == "info":
            return self.Command("info", rng.choice(_STAGES), *rng.choice([[], ["--json", rng.choice(["-", "i.json", "none/i", ""])]]))
        if command == "compare":
            return self.Command("compare", rng.choice(_STAGES + _OUTPUTS), rng.choice(_OUTPUTS), *rng.choice(
                [[], ["--threshold", rng.choice(_NUMBERS)]]))
        if command != "record":
            return self.Command(command, *rng.sample(_WORDS, rng.choice([0, 0, 1])))
        arguments = ["record", rng.choice(_STAGES), rng.choice(_OUTPUTS[:7] if rng.random() < 0.8 else _OUTPUTS), "--quiet"]
        # What comes later wins: without these a case could take hours and be right.
        options = [self._Option(rng) for _ in range(rng.choice([0, 1, 2, 3, 5]))]
        given = {option[0] for option in options}
        for name, value in (("--imageWidth", 16), ("--samples", 2), ("--maxDepth", 3)):
            if name not in given:
                options.append([name, value])
        rng.shuffle(options)
        return self.Command(*arguments, *(word for option in options for word in option), "--time", 3)

    def _Option(self, rng) -> list:
        name, values = rng.choice([
            ("--camera", _WORDS), ("--frames", _FRAMES), ("--imageWidth", _NUMBERS), ("--imageHeight", _NUMBERS), ("--purposes", _WORDS),
            ("--mask", _WORDS), ("--complexity", _NUMBERS + _WORDS), ("--subdivision", _WORDS), ("--colorCorrectionMode", _WORDS),
            ("--renderSettingsPrimPath", _WORDS), ("--renderPassPrimPath", _WORDS), ("--samples", _NUMBERS), ("--maxDepth", _NUMBERS), ("--seed", _NUMBERS),
            ("--noise", _NUMBERS), ("--aovs", _WORDS), ("--stats", ["s.json", "none/s.json", "", ".", "s.####.json"]),
            ("--device", ["", "cpu", "no such", "pthread", "x" * 300]), ("--cacheDir", ["stage.usda", "/proc/none", ""]),
            ("--residency", _WORDS), ("--hostMemory", _SIZES), ("--geometryMemory", _SIZES), ("--textureMemory", _SIZES),
            ("--volumeMemory", _SIZES),
            ("--geometryEviction", _WORDS), ("--chunkSize", _SIZES + ["mesh"]), ("--request", _WORDS), ("--waveSize", _NUMBERS),
            ("--shadeIterations", _NUMBERS), ("--prepare", _WORDS), ("--nothing", _WORDS), ("--time", _NUMBERS)])
        if rng.random() < 0.05:
            return [rng.choice(["--defaultTime", "--disableCameraLight", "--quiet", name])]
        return [name, rng.choice(values)]


# Values that a case could not finish with are not drawn: whole images of 32768 pixels a side, 2^24 samples.
_BOUNDED = {"imageWidth": 64, "imageHeight": 64, "samples": 4, "maxDepth": 64}


class Settings(Kind):
    """Random values of all rows of the settings table: as attributes of a render settings prim, and as members."""

    def __init__(self, folder, seed):
        super().__init__(folder, seed)
        from hdstream import _core
        from stages import fuzzBase

        fuzzBase.WriteImages(folder)
        self._core, self._text = _core, fuzzBase.Texts()[0]
        self._rows = [row for row in _core.SettingTable() if row.name not in ("noCache", "cacheDirectory")]
        self._session = None

    def RunCase(self, rng) -> str:
        chosen = {row.name: self._Value(row, rng) for row in rng.sample(self._rows, rng.choice([1, 2, 4, 8]))}
        (self.folder / "settings.json").write_text(json.dumps(chosen), encoding="utf-8")
        return self._AsAttributes(chosen, rng) if rng.random() < 0.5 else self._AsMembers(chosen)

    def _Value(self, row, rng):
        kinds = self._core.SettingKind
        if rng.random() < 0.05:
            return rng.choice([None, "", "x", -1, 0.5, True, [], ["color"], 1 << 70])
        if row.kind == kinds.Choice:
            return rng.choice([*row.choices, *row.choices, "none", ""])
        if row.kind == kinds.Bool:
            return rng.choice([True, False])
        if row.kind == kinds.Memory:
            return rng.choice(_SIZES)
        if row.kind in (kinds.Text, kinds.Names):
            return rng.choice(_WORDS) if row.kind == kinds.Text else rng.sample(_WORDS, rng.randrange(4))
        most = min(row.maximum, _BOUNDED.get(row.name, row.maximum))
        value = rng.choice([row.minimum, most, rng.uniform(row.minimum, most), rng.uniform(row.minimum, min(most, 64)), row.minimum - 1,
                            row.maximum * 2, float("nan"), float("inf")])
        return value if row.kind == kinds.Number or not abs(value) < 1e300 else int(value)

    def _AsAttributes(self, chosen, rng) -> str:
        lines = []
        for name, value in chosen.items():
            kind = {bool: "bool", int: "int64", float: "double", str: "string", list: "token[]"}.get(type(value), "token")
            text = json.dumps(value, ensure_ascii=False).replace("NaN", "nan").replace("Infinity", "inf")
            text = {"true": "1", "false": "0", "null": "None"}.get(text, text)
            lines.append(f"    {rng.choice([kind] * 8 + ['int', 'float', 'string'])} hdstream:{name} = {text}\n")
        head, tail = self._text.split('def RenderSettings "Render"\n{\n')
        kept = "".join(line + "\n" for line in tail.split("\n") if not any(f"hdstream:{name} " in line for name in chosen))
        stage = self.Write("stage.usda", head + 'def RenderSettings "Render"\n{\n' + "".join(lines) + kept)
        bounds = [word for name, option in (("samples", "--samples"), ("maxDepth", "--maxDepth")) if name not in chosen
                  for word in (option, 2)]
        return self.Record(stage, "--imageWidth", 16, "--time", 3, *bounds)

    def _AsMembers(self, chosen) -> str:
        """Errors must be of the kinds that Python's users are told of."""
        import numpy as np

        if self._session is None:
            self._session = self._MakeSession()
        settings = self._core.Settings()
        settings.camera, settings.imageWidth, settings.imageHeight, settings.samples = "/main_cam", 16, 12, 2
        settings.timeLimit = 3
        try:
            for name, value in chosen.items():
                if name == "device" and value:
                    continue
                setattr(settings, name, value)
            if settings.samples > 4 or settings.imageWidth > 64 or settings.imageHeight > 64:
                return ""
            self._session.Render(settings)
            for layer in self._session.Layers():
                if not layer.isInteger and not np.isfinite(layer.pixels).all():
                    return f"layer {layer.name} has values that are not finite"
            return SampleVerdict(self._session.Statistics())
        except (self._core.Error, TypeError, ValueError, OverflowError, MemoryError):
            pass
        except Exception as error:  # pylint: disable=broad-except
            return f"{type(error).__name__}: {error}"
        return ""

    def _MakeSession(self):
        from hdstream.translate import TranslateStage
        from pxr import Usd

        (self.folder / "members.usda").write_text(self._text, encoding="utf-8")
        session = self._core.Session()
        TranslateStage(Usd.Stage.Open("members.usda"), session, Usd.TimeCode.Default())
        return session
