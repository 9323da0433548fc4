# SPDX-License-Identifier: Apache-2.0
"""What the figures were measured on: no names of hosts, no paths."""

import os
import pathlib
import platform
import re

import numpy
from bench.performancePage import Table
from hdstream import _core
from pxr import Usd


def _Match(pattern: str, path, default: str = "unknown") -> str:
    try:
        found = re.search(pattern, pathlib.Path(path).read_text(), re.MULTILINE)
    except OSError:
        return default
    return found[1].strip() if found else default


def _Compiler(build: pathlib.Path) -> str:
    """As CMake found it."""
    for path in sorted(build.glob("CMakeFiles/*/CMakeCXXCompiler.cmake")):
        return " ".join([*(_Match(rf'set\(CMAKE_CXX_COMPILER_{key} "(.*?)"\)', path) for key in ("ID", "VERSION")),
                         _Match(r"^CMAKE_BUILD_TYPE:\w+=(.*)$", build / "CMakeCache.txt", "")])
    return "unknown"


def Run(bench) -> list:
    devices = _core.ListDevices()
    device = next((device for device in devices if not device.isCpu), devices[0])  # what `--device` defaults to
    kilobytes = _Match(r"^MemTotal:\s+(\d+)", "/proc/meminfo", "0")
    system = _Match(r'^PRETTY_NAME="(.*)"', "/etc/os-release", platform.system())
    rows = [["processor", _Match(r"^model name\s*:\s*(.*)$", "/proc/cpuinfo", platform.machine())],
            ["cores", str(os.cpu_count())], ["memory", f"{int(kilobytes) / 2**20:.1f} GiB"],
            ["OpenCL device", f"{device.name}, {device.computeUnits} compute units"],
            ["OpenCL driver", f"{device.platform}, {device.version}, driver {device.driverVersion}"],
            ["system", system], ["compiler", _Compiler(bench.build)], ["OpenUSD (usd-core)", ".".join(map(str, Usd.GetVersion()))],
            ["Python, numpy", f"{platform.python_version()}, {numpy.__version__}"]]
    return [Table("machine", ["", ""], [[name, re.sub(r"\s+", " ", value)] for name, value in rows])]
