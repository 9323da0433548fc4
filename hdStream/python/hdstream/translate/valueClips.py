# SPDX-License-Identifier: Apache-2.0
"""Value clips: attributes that only they hold, and files of theirs that are not there.

Of attributes that no layer declares OpenUSD finds the values, where the schema has them and the manifest of the clips too, but
it does not name them as authored. Of missing files it names neither the prim nor those of a template.
"""

import math

from pxr import Ar, Sdf, Usd, UsdGeom

from hdstream.pipeWatch import IS_PIPE, IsPipe, StandIn
from hdstream.translate.usdCalls import GetAuthoredPropertyNames, HasAuthoredMetadata

METADATA = "clips"


def AreOn(prim):
    """Whether a prim has clips of its own, which may hold values of all prims at and below it."""
    return HasAuthoredMetadata(prim, METADATA)


def NamesOf(prim, hasClips):
    """Names of the properties that a prim says something of. `hasClips`: it or a prim above it has clips."""
    if not hasClips:  # looking at all that a schema has takes much longer
        return GetAuthoredPropertyNames(prim)
    return [found.GetName() for found in prim.GetProperties()
            if found.IsAuthored() or isinstance(found, Usd.Attribute) and found.HasAuthoredValue()]


def Varies(attribute):
    """ValueMightBeTimeVarying, which OpenUSD denies of what clips hold for prims of instances."""
    if attribute.ValueMightBeTimeVarying():
        return True
    prim = attribute.GetPrim()
    return prim.IsInstanceProxy() and prim.GetPrimInPrototype().GetAttribute(attribute.GetName()).ValueMightBeTimeVarying()


def TransformVaries(prim):
    """The same of TransformMightBeTimeVarying."""
    return UsdGeom.Xformable(prim).TransformMightBeTimeVarying() or (
        prim.IsInstanceProxy() and UsdGeom.Xformable(prim.GetPrimInPrototype()).TransformMightBeTimeVarying())


def MissingClips(prim):
    """What is wrong with the files of a prim's clip sets, a line each; AreOn(prim). No pipe among them is opened from now on."""
    clips = Usd.ClipsAPI(prim)
    texts = []
    for name, clipSet in clips.GetClips().items():
        manifest = clipSet.get("manifestAssetPath")
        manifestFile = _Find(prim, manifest) if manifest else ""
        if manifest and not manifestFile:
            texts.append(f"the manifest {manifest.path} of its value clips does not exist; they are not used")
        texts += _WithoutPipes([manifestFile] + [asset.resolvedPath for asset in clips.ComputeClipAssetPaths(name)])
        template = clipSet.get("templateAssetPath")
        if template and not clipSet.get("assetPaths"):  # these win
            found = len(clips.ComputeClipAssetPaths(name))
            numClips = _NumClips(clipSet)
            if found < numClips:
                texts.append(f"{numClips - found} of {numClips} value clips {template} do not exist; those that do fill their times"
                             if found else f"none of {numClips} value clips {template} exists")
            continue
        missing = [asset.path for asset in clips.ComputeClipAssetPaths(name) if not asset.resolvedPath]
        if missing:
            others = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
            texts.append(f"value clip {missing[0]}{others} does not exist; it has no values")
    return texts


def _Find(prim, asset):
    """The file of an asset of a prim's metadata, from a layer that says something of the prim; or ""."""
    paths = (str(Ar.GetResolver().Resolve(Sdf.ComputeAssetPathRelativeToLayer(spec.layer, asset.path)))
             for spec in prim.GetPrimStack())
    return asset.resolvedPath or next(filter(None, paths), "")


def _WithoutPipes(files):
    """A line for each that is a pipe. OpenUSD would open it with its first value, and wait."""
    pipes = [file for file in dict.fromkeys(files) if file and IsPipe(file)]
    for file in pipes:
        StandIn(file)
    return [f"{file} of its value clips {IS_PIPE}" for file in pipes]


def _NumClips(clipSet):
    """How many files a template stands for."""
    start, end, stride = (clipSet.get("template" + name, 0.0) for name in ("StartTime", "EndTime", "Stride"))
    return max(0, math.floor((end - start) / stride + 1e-6) + 1) if stride > 0.0 else 0
