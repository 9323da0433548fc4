# SPDX-License-Identifier: Apache-2.0
"""`hdstream devices`."""

from hdstream import _core
from hdstream.errors import CommandError
from hdstream.texts import BytesText


def Run(args):
    devices = _core.ListDevices()
    if not devices:
        raise CommandError("no OpenCL device found; install a driver, or PoCL for the CPU "
                           "(Debian: pocl-opencl-icd)")
    default = _Texts(_core.FindDevice(""))
    chosen = next(device for device in devices if _Texts(device) == default)
    for device in devices:
        kind = "CPU" if device.isCpu else "GPU"
        default = " (default)" if device is chosen else ""
        print(f"{device.name}{default}\n  {kind}, {device.computeUnits} compute units, "
              f"{BytesText(device.memoryBytes)} memory, {BytesText(device.maxAllocationBytes)} an allocation\n"
              f"  {device.platform}, {device.version}, driver {device.driverVersion}")


def _Texts(device):
    """What one device has in common with no other, but for its twins."""
    return device.platform, device.name, device.version, device.driverVersion
