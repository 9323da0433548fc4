# SPDX-License-Identifier: Apache-2.0
"""What these tests need of usdrecord, over the same class of OpenUSD, where there is no such program (Blender's module bpy).

Renders on the CPU alone. Options have usdrecord's names and defaults.
"""

import argparse
import sys

from pxr import Sdf, Tf, Usd, UsdAppUtils


def _Parse():
    parser = argparse.ArgumentParser(prog="recorder")
    parser.add_argument("usdFilePath")
    parser.add_argument("outputImagePath")
    parser.add_argument("--disableGpu", action="store_true")
    parser.add_argument("--disableCameraLight", action="store_true")
    parser.add_argument("--enableDomeLightVisibility", action="store_true")
    parser.add_argument("--imageWidth", "-w", type=int, default=960)
    parser.add_argument("--mask", default="")
    parser.add_argument("--purposes", default="proxy")
    parser.add_argument("--renderSettingsPrimPath", "-rs", default="")
    for arguments in (UsdAppUtils.cameraArgs, UsdAppUtils.framesArgs, UsdAppUtils.complexityArgs, UsdAppUtils.colorArgs,
                      UsdAppUtils.rendererArgs):
        arguments.AddCmdlineArgs(parser)
    return parser, parser.parse_args()


def _OpenStage(args):
    if not args.mask:
        return Usd.Stage.Open(args.usdFilePath)
    mask = Usd.StagePopulationMask()
    for path in args.mask.replace(",", " ").split():
        mask.Add(path)
    return Usd.Stage.OpenMasked(Sdf.Layer.FindOrOpen(args.usdFilePath), mask)


def main():
    parser, args = _Parse()
    try:
        stage = _OpenStage(args)
    except Tf.ErrorException as error:
        return f"recorder: {args.usdFilePath} cannot be opened: {error}"
    UsdAppUtils.framesArgs.ValidateCmdlineArgs(parser, args, stage, frameFormatArgName="outputImagePath")
    recorder = UsdAppUtils.FrameRecorder(UsdAppUtils.rendererArgs.GetPluginIdFromArgument(args.rendererPlugin) or "", False)
    settings = args.renderSettingsPrimPath or stage.GetMetadata("renderSettingsPrimPath")
    if settings:
        recorder.SetActiveRenderSettingsPrimPath(settings)
    recorder.SetImageWidth(max(1, args.imageWidth))
    recorder.SetComplexity(args.complexity.value)
    recorder.SetCameraLightEnabled(not args.disableCameraLight)
    recorder.SetColorCorrectionMode(args.colorCorrectionMode)
    recorder.SetIncludedPurposes(args.purposes.replace(",", " ").split())
    recorder.SetDomeLightVisibility(args.enableDomeLightVisibility)
    camera = UsdAppUtils.GetCameraAtPath(stage, args.camera)
    for timeCode in args.frames:
        try:
            recorder.Record(stage, camera, timeCode, args.outputImagePath.format(frame=timeCode))
        except Tf.ErrorException as error:
            return f"recorder: time code {timeCode}: {error}"
    return 0


if __name__ == "__main__":
    sys.exit(main())
