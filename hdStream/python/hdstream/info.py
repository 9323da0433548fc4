# SPDX-License-Identifier: Apache-2.0
"""`hdstream info`: what is in a stage, in prims, triangles and bytes."""

import collections
import json
import sys

from hdstream import _core
from hdstream.console import SayWarning
from hdstream.textFile import WriteText
from hdstream.texts import BytesText


def Run(args):
    from pxr import UsdGeom
    from hdstream.diagnostics import Diagnostics
    from hdstream.stage import OpenStage
    from hdstream.translate import TranslateStage
    session = _core.Session(SayWarning)
    diagnostics = Diagnostics()
    stage = OpenStage(args.stage)
    diagnostics.WarnOf(session)
    TranslateStage(stage, session, stage.GetStartTimeCode())
    diagnostics.WarnOf(session)
    info = {"stage": args.stage, "upAxis": UsdGeom.GetStageUpAxis(stage),
            "metersPerUnit": UsdGeom.GetStageMetersPerUnit(stage), "primTypes": CountTypes(stage)}
    info.update(json.loads(session.Info()))
    info["cameraPaths"] = sorted(session.Scene().cameras)
    info["startTimeCode"] = stage.GetStartTimeCode()
    info["endTimeCode"] = stage.GetEndTimeCode()
    if args.json != "-":
        _Print(info)
    if args.json:
        _WriteJson(info, args.json)


def CountTypes(stage):
    """Prims of each type; those of native instances count once for every instance."""
    from pxr import Usd
    counts = collections.Counter()
    for prim in stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
        counts[prim.GetTypeName() or "(no type)"] += 1
    return dict(sorted(counts.items()))


def _WriteJson(info, file):
    text = json.dumps(info, indent=2) + "\n"
    if file == "-":
        sys.stdout.write(text)
        return
    WriteText("--json", file, text)


def _Print(info):
    print(f"{info['stage']}: up axis {info['upAxis']}, {info['metersPerUnit']:g} m a unit, "
          f"frames {info['startTimeCode']:g} to {info['endTimeCode']:g}")
    print("prims       " + (", ".join(f"{count} {name}" for name, count in info["primTypes"].items()) or "none"))
    print(f"meshes      {info['meshes']}, {info['triangles']} triangles, {BytesText(info['geometryBytes'])}")
    print(f"curves      {info['curves']}, {info['points']} points, {info['splats']} splats")
    print(f"instances   {info['instances']} drawn, {info['instancers']} instancers")
    print(f"materials   {info['materials']}")
    print(f"lights      {info['lights']}, {info['emissiveTriangles']} emissive triangles")
    volume = info["volume"]
    if volume["volumes"]:
        print(f"volumes     {volume['volumes']}, {volume['grids']} grids, {volume['bricks']} bricks, "
              f"{BytesText(volume['bytesTotal'])}")
    print(f"cameras     {', '.join(info['cameraPaths']) or 'none'}")
    print(f"textures    {len(info['textures'])}, {BytesText(info['textureBytesSource'])} decoded")
    for texture in info["textures"]:
        size = f"{texture['width']}x{texture['height']}x{texture['channels']}, {BytesText(texture['bytesSource'])}"
        print(f"  {texture['file']}: {texture['error'] or size}")
