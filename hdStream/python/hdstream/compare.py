# SPDX-License-Identifier: Apache-2.0
"""`hdstream compare A B`: differences in the measures of docs/film.md; B is the reference."""

from hdstream import _core
from hdstream.errors import EXIT_FAILURE, EXIT_OK, CommandError


def Run(args):
    result = _core.CompareImages(args.image, args.reference)
    if result.error:
        raise CommandError(result.error)
    width = max(len(layer.name) for layer in result.layers)
    print(f"{'layer':{width}}  {'max abs':>12} {'RMSE':>12} {'relMSE':>12} {'PSNR dB':>8}  pixels unlike")
    for layer in result.layers:
        print(f"{layer.name:{width}}  {layer.maxAbs:12.6g} {layer.rmse:12.6g} {layer.relMse:12.6g} "
              f"{layer.psnr:8.2f}  {layer.numDifferingPixels} of {layer.numPixels}")
    if args.threshold is not None and result.IsAbove(args.threshold):
        print(f"relMSE is above {args.threshold:g}")
        return EXIT_FAILURE
    return EXIT_OK
