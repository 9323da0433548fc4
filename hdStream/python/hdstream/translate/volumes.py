# SPDX-License-Identifier: Apache-2.0
"""UsdVol volumes: their fields as files and names of grids; what they mean is the core's to say."""

from pxr import UsdVol

from hdstream import _core


def ReadVolume(prim, placement, purpose, materialPath, timeCode, assets, warn):
    """The volume of a prim. Fields that are no OpenVDB files are left out."""
    volume = _core.VolumePrim(placement, purpose, materialPath)
    for name, path in sorted(UsdVol.Volume(prim).GetFieldPaths().items()):
        field = prim.GetStage().GetPrimAtPath(path)
        if not field or not field.IsA(UsdVol.OpenVDBAsset):
            what = f"is a {field.GetTypeName()}, no OpenVDBAsset" if field else "does not exist"
            warn(prim, f"field '{name}' ({path}) {what}: left out")
            continue
        asset = UsdVol.OpenVDBAsset(field)
        file = asset.GetFilePathAttr()
        value = file.Get(timeCode)
        if value is None:
            warn(prim, f"field '{name}' ({path}) has no filePath: left out")
            continue
        gridName = asset.GetFieldNameAttr().Get(timeCode) or name
        volume.SetFile(name, assets.Resolve(file, value), str(gridName), asset.GetFieldIndexAttr().Get(timeCode) or 0)
    # At no frame nothing moves.
    volume.SetTimeCodesPerSecond(prim.GetStage().GetTimeCodesPerSecond() if timeCode.IsNumeric() else 0.0)
    return volume
