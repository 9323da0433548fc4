# SPDX-License-Identifier: Apache-2.0
"""Assets as (file, offset, size), resolved while translating so that the core needs no resolver.

Files inside a usdz package (a zip whose entries are stored, never compressed) are byte ranges of
the package; packages nest.
"""

from hdstream import _core


class AssetResolver:
    """Turns Sdf.AssetPath values into AssetReferences; packages are read once an entry."""

    def __init__(self):
        self._entries = {}

    def Resolve(self, attribute, assetPath):
        """The reference of an attribute's asset value; its `file` is empty when it is not found, and a path into a package where what
        is there cannot be read."""
        authored = assetPath.path
        resolved = assetPath.resolvedPath
        pattern = authored.replace("<udim>", "<UDIM>")  # which Arnold knows as well
        if not resolved and "<UDIM>" in pattern:
            resolved = _ResolveUdim(attribute, pattern)
        if resolved.endswith("]"):
            return self._InPackage(authored, resolved)
        return _core.AssetReference(authored, resolved)

    def _InPackage(self, authored, resolved):
        if "<UDIM>" in resolved:  # the core looks which tiles there are
            return _core.AssetReference(authored, resolved)
        if resolved not in self._entries:
            self._entries[resolved] = _core.FindInPackage(resolved)
        entry = self._entries[resolved]
        return _core.AssetReference(authored, *entry) if entry else _core.AssetReference(authored, resolved)  # as the core will tell


def _ResolveUdim(attribute, authored):
    from pxr import UsdShade
    for spec in attribute.GetPropertyStack():
        pattern = UsdShade.UdimUtils.ResolveUdimPath(authored, spec.layer)
        if pattern:
            return pattern
    return ""
