# SPDX-License-Identifier: Apache-2.0
"""Numbers as people read them."""


def BytesText(count):
    """Bytes with a binary unit: 512 B, 1.5 MiB."""
    if count < 1024:
        return f"{count} B"
    value = float(count)
    for unit in ("KiB", "MiB", "GiB", "TiB"):
        value /= 1024.0
        if value < 1024.0 or unit == "TiB":
            break
    return f"{value:.1f} {unit}"


def SecondsText(seconds):
    """A duration: 3.2 s, 4:05, 1:02:03."""
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def NumPrimsText(count):
    """A number of prims: 1 prim, 2 prims."""
    return f"{count} prim" if count == 1 else f"{count} prims"
