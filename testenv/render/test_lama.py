# SPDX-License-Identifier: Apache-2.0
"""LamA's closures look to the bit like MaterialX's own node graphs of them, which are put together of other closures."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")
materialX = pytest.importorskip("MaterialX")

from pxr import UsdShade
from stages import surfaceGraphs
from stages.materialX import AddSurface
from test_closures import BLUE, GOLD, RED, Closures, _Picture


class _Document:
    """A document of MaterialX with a surface of closures. Calls add a node; nodes as inputs are connected."""

    def __init__(self):
        self.document, self._count = surfaceGraphs.NewDocument(), 0

    def __call__(self, category, kind="BSDF", **inputs):
        self._count += 1
        node = self.document.addNode(category, f"Node{self._count}", kind)
        for name, value in inputs.items():
            if isinstance(value, materialX.Node):
                node.addInput(name, value.getType()).setConnectedNode(value)
            elif isinstance(value, tuple):
                isVector = name in ("IOR", "extinction")
                node.setInputValue(name, (materialX.Vector3 if isVector else materialX.Color3)(*value), "vector3" if isVector else "color3")
            elif isinstance(value, int):
                node.setInputValue(name, value, "integer")
            else:
                node.setInputValue(name, float(value), "float")
        return node

    def Layers(self, bsdf, edf=None):
        """(with the nodes of LamA, with their node graphs)"""
        parts = {name: node for name, node in (("bsdf", bsdf), ("edf", edf)) if node is not None}
        surface = self("surface", "surfaceshader", **parts)
        self.document.addMaterialNode("Look", surface)
        own = surfaceGraphs.ReadLayer(self.document)
        self.document.flattenSubgraphs("", lambda node: node.getCategory().startswith("Lama"))
        assert not any(node.getCategory().startswith("Lama") for node in self.document.getNodes())
        return own, surfaceGraphs.ReadLayer(self.document)


def _Ramp(d):
    return d("ramplr", "float", valuel=0.1, valuer=0.8)


_CLOSURES = {
    "diffuse": lambda d: (d("LamaDiffuse", color=RED, roughness=0.6),),
    "diffusePlain": lambda d: (d("LamaDiffuse", roughness=_Ramp(d), energyCompensation=0.0),),
    "translucent": lambda d: (d("LamaTranslucent", color=BLUE),),
    "sheen": lambda d: (d("LamaSheen", color=GOLD, roughness=0.4),),
    "subsurface": lambda d: (d("LamaSSS", color=GOLD, sssRadius=(20.0, 10.0, 5.0), sssScale=2.0, sssAnisotropy=0.3),),
    "subsurfaceOfNoRadius": lambda d: (d("LamaSSS"),),
    "glass": lambda d: (d("LamaDielectric"),),
    "glassByIor": lambda d: (d("LamaDielectric", fresnelMode=1, IOR=1.8, roughness=0.3, anisotropy=0.5, transmissionTint=GOLD,
                               absorptionColor=(0.2, 0.5, 0.9), absorptionRadius=2.0, scatterColor=(0.5, 0.4, 0.3), scatterAnisotropy=0.4),),
    "metal": lambda d: (d("LamaConductor"),),
    "metalByIor": lambda d: (d("LamaConductor", fresnelMode=1, IOR=(1.2, 0.9, 0.6), extinction=(3.0, 3.2, 2.0), tint=(0.9, 0.7, 1.0),
                               roughness=0.4, anisotropy=-0.6),),
    "schlick": lambda d: (d("LamaGeneralizedSchlick", reflectivity=(0.3, 0.5, 0.7), roughness=0.4, anisotropy=0.2, reflectionTint=GOLD),),
    "schlickByIor": lambda d: (d("LamaGeneralizedSchlick", fresnelMode=1, IOR=(1.6, 1.6, 1.6), transmissionTint=RED),),
    "film": lambda d: (d("LamaIridescence", relativeFilmThickness=0.3, filmIOR=1.7, roughness=0.3),),
    "glow": lambda d: (d("LamaDiffuse"), d("LamaMix", "EDF", material1=d("LamaEmission", "EDF", color=RED),
                                         material2=d("LamaAdd", "EDF", material1=d("LamaEmission", "EDF", color=BLUE), weight1=0.3,
                                                     material2=d("LamaEmission", "EDF", color=GOLD), weight2=0.7), mix=0.4)),
    "mix": lambda d: (d("LamaMix", material1=d("LamaDiffuse", color=RED), material2=d("LamaConductor"), mix=0.3),),
    "add": lambda d: (d("LamaAdd", material1=d("LamaDiffuse", color=RED), weight1=0.6, material2=d("LamaSheen"), weight2=0.3),),
    "layer": lambda d: (d("LamaLayer", materialTop=d("LamaDielectric", roughness=0.3), topMix=0.7, materialBase=d("LamaDiffuse", color=RED)),),
}


@pytest.mark.parametrize("name", _CLOSURES)
def test_closures_are_those_of_their_node_graphs(tmp_path, name):
    document = _Document()
    layers = document.Layers(*_CLOSURES[name](document))
    own, graph = (_Picture(tmp_path, lambda stage: surfaceGraphs.CopyMaterial(layer, "Look", stage, "/World/Look"), samples=8, maxDepth=6)
                  for layer in layers)
    assert not any("not supported" in warning or "unknown" in warning for warning in own.warnings)
    assert np.array_equal(own.rgb, graph.rgb)
    black = _Picture(tmp_path, lambda stage: AddSurface(stage, "/World/Look", "ND_surface"), samples=8, maxDepth=6)
    assert np.abs(own.rgb - black.rgb).mean() > 0.004  # it is drawn


def test_a_surface_of_lama_is_its_front(tmp_path):
    def Add(identifier, front, presence):
        def Surface(stage):
            UsdShade.Material.Define(stage, "/World/Look")
            closures = Closures(stage)
            return AddSurface(stage, "/World/Look", identifier, **{front: closures("lama_diffuse", color=RED), presence: 0.5})
        return _Picture(tmp_path, Surface, samples=8)
    assert np.array_equal(Add("ND_lama_surface", "materialFront", "presence").rgb, Add("ND_surface", "bsdf", "opacity").rgb)
