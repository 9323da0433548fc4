# SPDX-License-Identifier: Apache-2.0
"""The oracle is right before it judges: the Mitsuba harness against closed forms and against itself.

Needs mitsuba with LLVM (`pip install mitsuba`, Debian's libllvm19); skipped without.
"""

import numpy as np
import pytest

pytest.importorskip("mitsuba")

import closedForm
import mitsubaScene
import plateCases
from stageReader import ReadStage
from stages.verify import CASES


@pytest.fixture(scope="module", autouse=True)
def _Llvm():
    mitsubaScene.UseVariant("llvm_ad_rgb")


@pytest.mark.parametrize("name", sorted(plateCases.PLATES))
def test_mitsuba_plate_equals_closed_form(name, tmp_path):
    path = plateCases.WritePlate(name, str(tmp_path))
    expected = plateCases.ExpectedPlate(path)
    scene = mitsubaScene.Load(ReadStage(path), plateCases.WIDTH, plateCases.HEIGHT, 2, str(tmp_path))
    # 4096 samples: noise of the mean below 7e-4 and of a block below 4e-3 in the noisiest plate (cylinder).
    image = np.array(mitsubaScene.mi.render(scene, spp=4096, seed=3), np.float64)
    assert image.mean() == pytest.approx(expected.mean(), rel=1.5e-3)
    blocks = lambda a: a.reshape(6, 6, 8, 6, 3).mean((1, 3))
    np.testing.assert_allclose(blocks(image), blocks(expected), rtol=0.012, atol=3e-3 * expected.max())


def test_scalar_and_llvm_agree(tmp_path):
    """The two variants share the scene but not the execution: same mean within their noise."""
    case = CASES["rectLight"]
    path = case.Write(f"{tmp_path}/stage.usda")
    fast, fastVariance = mitsubaScene.RenderReference(path, case, samples=256, batches=8)
    try:
        mitsubaScene.UseVariant("scalar_rgb")
        slow, slowVariance = mitsubaScene.RenderReference(path, case, samples=32, batches=8)
    finally:
        mitsubaScene.UseVariant("llvm_ad_rgb")
    error = np.sqrt(fastVariance.sum() + slowVariance.sum()) / fast.size
    assert abs(fast.mean() - slow.mean()) < 5 * error


@pytest.mark.parametrize("roughness,metallic,clearcoat,ior", [(0.5, 0.0, 0.0, 1.5), (0.3, 1.0, 0.0, 1.5), (0.7, 0.3, 1.0, 2.0)])
def test_plugin_albedo_equals_quadrature(roughness, metallic, clearcoat, ior):
    """The plug-in's directional albedo by its own sampling equals a double-precision integral of the
    formula written out once more, over directions on a grid."""
    import drjit as dr

    mi = mitsubaScene.mi
    rgb = (0.8, 0.4, 0.2)
    bsdf = mi.load_dict({"type": "usdpreview", "useSpecularWorkflow": 0, "lambert": 0, "metallic": metallic, "roughness": roughness,
                         "clearcoat": clearcoat, "clearcoatRoughness": 0.3, "opacity": 1.0, "opacityThreshold": 0.0, "ior": ior,
                         "diffuseColor": {"type": "rgb", "value": list(rgb)}, "specularColor": {"type": "rgb", "value": [0, 0, 0]},
                         "normalX": 0.0, "normalY": 0.0, "normalZ": 1.0})
    for cosine in (0.95, 0.6, 0.25):
        view = np.array([np.sqrt(1 - cosine**2), 0, cosine])
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(7, 1 << 20)
        si = dr.zeros(mi.SurfaceInteraction3f, 1 << 20)
        si.n = mi.Normal3f(0, 0, 1)
        si.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
        si.wi = si.to_local(mi.Vector3f(*map(float, view)))
        _, weight = bsdf.sample(mi.BSDFContext(), si, sampler.next_1d(), sampler.next_2d())
        sampled = np.array(dr.mean(weight, axis=1)).ravel()
        np.testing.assert_allclose(sampled, closedForm.PreviewAlbedo(cosine, rgb, roughness, metallic, clearcoat, 0.3, ior), rtol=5e-3)
