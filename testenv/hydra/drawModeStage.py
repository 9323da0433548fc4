# SPDX-License-Identifier: Apache-2.0
"""A stage of draw modes that OpenUSD 24.11 draws alike in both of its ways, but for the native instances.

Scene indices give cards a place only where the model has an extentsHint (docs/hydra.md), which every model
here has; that of an instance they lose. All sizes are in metres.
"""

from pxr import Gf, Sdf, Usd, UsdGeom

from stages import author, shapes

# Model -> (draw mode, card geometry, textures by face, place).
MODELS = {
    "Cross": ("cards", "cross", {"XNeg": "card.png", "ZPos": "card.png", "ZNeg": "cardRed.png"}, (-2.4, 1.2, 0)),
    "Box": ("cards", "box", {face: "cardRed.png" if "Neg" in face else "card.png"
                             for face in ("XPos", "XNeg", "YPos", "YNeg", "ZPos", "ZNeg")}, (-0.8, 1.2, 0)),
    "Plain": ("cards", "box", {}, (0.8, 1.2, 0)),
    "Full": ("default", "cross", {"ZPos": "cardRed.png"}, (2.4, 1.2, 0)),
    "Bounds": ("bounds", "cross", {}, (-2.4, -0.6, 0)),
    "Origin": ("origin", "cross", {}, (-0.8, -0.6, 0)),
    "CopyA": ("cards", "cross", {"XPos": "card.png", "ZPos": "cardRed.png"}, (0.8, -0.6, 0)),
    "CopyB": ("cards", "cross", {"XPos": "card.png", "ZPos": "cardRed.png"}, (2.4, -0.6, 0)),
}


def WriteDrawModeStage(path, textures, hasInstances=True) -> None:
    """textures: the folder of card.png and cardRed.png."""
    stage = author.NewStage(path)
    Usd.ModelAPI(stage.GetPrimAtPath("/World")).SetKind("group")
    asset = stage.CreateClassPrim("/Asset")
    author.AddMesh(stage, "/Asset/Ball", shapes.Sphere(0.5, 16, 32), color=(0.8, 0.6, 0.1))
    for name, (mode, geometry, images, place) in MODELS.items():
        if name.startswith("Copy") and not hasInstances:
            continue
        model = UsdGeom.Xform.Define(stage, f"/World/{name}")
        prim = model.GetPrim()
        prim.GetReferences().AddInternalReference(asset.GetPath())
        prim.SetInstanceable(name.startswith("Copy"))
        Usd.ModelAPI(prim).SetKind("component")
        api = UsdGeom.ModelAPI.Apply(prim)
        api.CreateModelDrawModeAttr(mode)
        api.CreateModelCardGeometryAttr(geometry)
        api.CreateModelDrawModeColorAttr(Gf.Vec3f(0.1, 0.5, 0.2))
        api.SetExtentsHint([Gf.Vec3f(-0.5), Gf.Vec3f(0.5)])
        for face, image in images.items():
            prim.GetAttribute("model:cardTexture" + face).Set(Sdf.AssetPath(f"{textures}/{image}"))
        author.Place(model, translate=place, rotate=(25, 30, 0))
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-40, 25, 0)), intensity=2.0, angle=1.0, normalize=True)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.5)
    author.AddCamera(stage, "/World/Camera", eye=(0, 0.3, 6))
    stage.GetRootLayer().Save()
