# SPDX-License-Identifier: Apache-2.0
"""Stages on which forms of kernels are compared: each shows surfaces and lights of unlike kinds side by side."""

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt
from stages import author, hair, lightCases, materialCases, materialX, media, shapes, textured


def _Blur(stage, fStop: float, distance: float) -> UsdGeom.Camera:
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    camera.CreateFStopAttr(fStop)
    camera.CreateFocusDistanceAttr(distance)
    return camera


def _AddPortal(stage, dome) -> None:
    portal = UsdLux.PortalLight.Define(stage, "/World/Portal")
    for name in ("width", "height"):
        portal.GetPrim().CreateAttribute(f"inputs:{name}", Sdf.ValueTypeNames.Float).Set(3.0)
    author.Place(portal, translate=(-2, 4, 0), rotate=(-70, -30, 0))
    dome.CreatePortalsRel().AddTarget(portal.GetPath())


def EveryLight(path) -> None:
    """Each kind of light, on cut-outs and coats; a dome with a portal; a mesh light; a lens and clipping planes."""
    stage = author.NewStage(path)
    lightCases.FiveLights(stage, None)
    author.AddLight(stage, "/World/Tube", "Cylinder", dict(translate=(1.5, 2.5, -1.0), rotate=(0, 30, 12)), radius=0.1,
                    length=1.6, intensity=9.0)
    author.AddLight(stage, "/World/Strip", "Rect", dict(translate=(2.5, 0.05, 1.5), rotate=(0, 60, 0), scale=(1, 2, 1)),
                    width=0.02, height=1.5, intensity=40.0, normalize=True)
    author.AddLight(stage, "/World/Point", "Sphere", dict(translate=(0, 3.0, 1.0)), intensity=4.0, treatAsPoint=True)
    glow = author.AddMaterial(stage, "/World/Glow", diffuseColor=(0.2, 0.2, 0.2), emissiveColor=(9, 8, 6))
    author.AddMesh(stage, "/World/Glows", shapes.Torus(0.3, 0.08), material=glow, translate=(-0.3, 0.4, 1.6))
    _AddPortal(stage, UsdLux.DomeLight(stage.GetPrimAtPath("/World/Dome")))
    looks = (dict(opacity=0.4, roughness=0.2), dict(clearcoat=1.0, clearcoatRoughness=0.1, roughness=0.5),
             dict(metallic=1.0, roughness=0.05, diffuseColor=(0.9, 0.6, 0.3)), dict(opacity=0.3, opacityThreshold=0.5))
    for index, look in enumerate(looks):
        material = author.AddMaterial(stage, f"/World/Look{index}", **look)
        author.AddMesh(stage, f"/World/Small{index}", shapes.Sphere(0.3, 24, 48), material=material,
                       translate=(0.75 * index - 1.2, 0.3, 1.4))
    _Blur(stage, 4.0, 5.0).CreateClippingPlanesAttr(Vt.Vec4fArray([Gf.Vec4f(0.1, 0, -1, -4.4), Gf.Vec4f(1, 0, 0, 2.5)]))
    stage.GetRootLayer().Save()


def Layered(path) -> None:
    """All lobes that have the form of eight paths; plain surfaces beside them."""
    materialX.WriteMaterialBalls(str(path))
    stage = Usd.Stage.Open(str(path))
    sheet = materialX.AddSurface(stage, "/World/Looks/Sheet", thin_walled=True, subsurface=1.0, subsurface_color=(0.3, 0.8, 0.4))
    author.AddMesh(stage, "/World/Sheet", shapes.Plane(2.0, 2.0), material=sheet, doubleSided=True, translate=(-2.4, 1.0, 2.0),
                   rotate=(70, 30, 0))
    pane = materialX.AddSurface(stage, "/World/Looks/Pane", thin_walled=True, transmission=0.8, transmission_color=(0.8, 0.9, 1.0),
                                specular_roughness=0.5, specular_anisotropy=0.5)
    author.AddMesh(stage, "/World/Pane", shapes.Plane(2.0, 2.0), material=pane, doubleSided=True, translate=(2.0, 1.0, 2.5),
                   rotate=(70, -20, 0))
    UsdShade.Material.Define(stage, "/World/Looks/Lacquer")
    bumps = materialX.AddNode(stage, "/World/Looks/Lacquer/Bumps", "ND_normalmap", Sdf.ValueTypeNames.Vector3f,
                              **{"in": Gf.Vec3f(0.7, 0.4, 0.9)})
    lacquer = materialX.AddSurface(stage, "/World/Looks/Lacquer", base_color=(0.3, 0.1, 0.4), specular_roughness=0.5, coat=1.0,
                                   coat_roughness=0.3, coat_anisotropy=0.7, normal=bumps)
    author.AddMesh(stage, "/World/Lacquered", materialX.Ball(0.5), material=lacquer, translate=(-2.4, 0.5, 0.5))
    _Blur(stage, 5.0, 9.0)
    stage.GetRootLayer().Save()


def Stacked(path) -> None:
    """Stacks of reflections and sheens, what lies on glass, closures that send light back, and walks that leave below a stack."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(12, 12), color=(0.4, 0.4, 0.4))

    def Layers(look, *layers):
        below = None
        for index, (kind, inputs) in reversed(list(enumerate(layers))):
            node = materialX.AddNode(stage, f"{look}/Layer{index}", f"ND_{kind}_bsdf", Sdf.ValueTypeNames.Token, **inputs)
            below = node if below is None else materialX.AddNode(stage, f"{look}/On{index}", "ND_layer_bsdf", Sdf.ValueTypeNames.Token,
                                                                 top=node, base=below)
        return materialX.AddSurface(stage, look, "ND_surface", bsdf=below)
    red, tint = dict(color=(0.7, 0.1, 0.08)), (0.9, 0.5, 0.2)

    def Mirror(ior, roughness, **inputs):
        return "dielectric", dict(ior=ior, roughness=(roughness, 0.7 * roughness), **inputs)
    stacks = [
        [Mirror(1.5, 0.2, tint=tint), Mirror(2.2, 0.3), Mirror(1.3, 0.1), ("oren_nayar_diffuse", red)],
        [("sheen", dict(roughness=0.5, color=tint)), ("sheen", dict(roughness=0.3, mode="zeltner")), Mirror(1.5, 0.2),
         ("oren_nayar_diffuse", red)],
        [Mirror(1.8, 0.2, tint=tint), Mirror(1.4, 0.1), Mirror(1.5, 0.05, scatter_mode="T")],
        [Mirror(2.0, 0.3, retroreflective=True, tint=tint), ("oren_nayar_diffuse", red)],
        [Mirror(1.5, 0.1), ("sheen", dict(roughness=0.4)), ("conductor", dict(roughness=(0.3, 0.2), retroreflective=True))],
        [Mirror(1.5, 0.1, tint=tint), ("subsurface", dict(color=(0.8, 0.5, 0.3), radius=(0.2, 0.1, 0.05)))],
    ]
    for index, layers in enumerate(stacks):
        author.AddMesh(stage, f"/World/Ball{index}", materialX.Ball(0.5), material=Layers(f"/World/Looks/Look{index}", *layers),
                       translate=(1.1 * (index % 3 - 1), 0.5, 1.2 * (index // 3) - 0.6))
    author.AddLight(stage, "/World/Key", "Rect", dict(translate=(-3, 5, 4), rotate=(-52, -30, 0)), width=3.0, height=3.0, intensity=12.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.35)
    author.AddCamera(stage, eye=(0, 3.0, 5.0), target=(0, 0.4, 0), aspect=61 / 47, focalLength=40.0)
    stage.GetRootLayer().Save()


def Media(path) -> None:
    """Walks below surfaces and in glass, some of which end while others of their batch go on."""
    media.WriteMedia(str(path))


def Textured(path) -> None:
    """Images on surfaces, on a dome and on panels; a panel without one."""
    textured.WriteImageLights(path, isTextured=True)
    stage = Usd.Stage.Open(str(path))
    author.AddLight(stage, "/World/Plain", "Rect", dict(translate=(0, 2.5, 1), rotate=(-90, 0, 0)), intensity=5.0)
    stage.GetRootLayer().Save()


def ManyLights(path) -> None:
    """A light tree, whose rects are plain and shaped; no perspective."""
    stage = author.NewStage(path)
    materialCases.AddRoom(stage)
    random = np.random.default_rng(3)
    for index in range(60):
        place = dict(translate=random.uniform(-1.5, 1.5, 3) + (0, 1.6, 0), rotate=random.uniform(-180, 180, 3))
        light = author.AddLight(stage, f"/World/Light{index}", ("Rect", "Disk", "Sphere")[index % 3], place, intensity=4.0)
        for name in ("width", "height", "radius"):
            if light.GetPrim().HasAttribute(f"inputs:{name}"):
                light.GetPrim().GetAttribute(f"inputs:{name}").Set(0.2)
        if index % 9 == 0:
            author.ShapeLight(light, coneAngle=50.0, focus=2.0)
    stage.RemovePrim("/World/Camera")
    author.AddCamera(stage, eye=(0, 1.5, 6.0), target=(0, 1.2, 0), width=40.0, orthographic=True)
    stage.GetRootLayer().Save()


def FewShaped(path) -> None:
    """Plain and shaped rects and a shaped ball, too few for a light tree."""
    stage = author.NewStage(path)
    materialCases.AddRoom(stage)
    for index in range(4):
        kind = "Sphere" if index == 3 else "Rect"
        light = author.AddLight(stage, f"/World/Lamp{index}", kind, dict(translate=(index - 1.5, 2.6, 0.4), rotate=(-70, 20 * index, 0)),
                                intensity=6.0)
        if index % 2:
            author.ShapeLight(light, coneAngle=40.0, focus=3.0)
    stage.GetRootLayer().Save()


def Nested(path) -> None:
    """Bricks through one, two and three levels of instancers, side by side on a floor: hits of eight paths lie at unlike depths."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Floor", shapes.Plane(8.0, 8.0), color=(0.5, 0.5, 0.5))
    place = "/World/Rows"
    for level in range(3):
        instancer = UsdGeom.PointInstancer.Define(stage, f"{place}/I{level}" if level else place)
        place = instancer.GetPath().pathString
        inner = [f"{place}/Brick"] + ([f"{place}/I{level + 1}"] if level < 2 else [])
        instancer.CreatePrototypesRel().SetTargets(inner)
        number = 4 * len(inner)
        instancer.CreateProtoIndicesAttr([index % len(inner) for index in range(number)])
        random = np.random.default_rng(level)
        instancer.CreatePositionsAttr([tuple(map(float, random.uniform(-0.9, 0.9, 3) * (1, 0.1, 1))) for _ in range(number)])
        instancer.CreateOrientationsAttr([Gf.Quath(float(np.cos(a)), 0.0, float(np.sin(a)), 0.0) for a in range(number)])
        instancer.CreateScalesAttr([(0.9, 1.1, 0.8)] * number)
        author.AddMesh(stage, f"{place}/Brick", shapes.Box(0.25, 0.5, 0.2), color=(0.8, 0.4 + 0.2 * level, 0.2),
                       translate=(0, 0.3, 0))
    author.AddLight(stage, "/World/Lamp", "Rect", dict(translate=(0, 4, 1), rotate=(-90, 0, 0)), intensity=8.0)
    author.AddCamera(stage, eye=(0, 3.0, 4.5), target=(0, 0.2, 0), focalLength=35.0)
    stage.GetRootLayer().Save()


def Spaces(path) -> None:
    """The bricks of Nested, with colours by what their instances do to points and normals."""
    Nested(path)
    stage, types = Usd.Stage.Open(str(path)), Sdf.ValueTypeNames
    at = materialX.AddNode(stage, "/World/Look/At", "ND_transformpoint_vector3", types.Vector3f, fromspace="object", tospace="world",
                           **{"in": (0.2, 0.9, 0.4)})
    up = materialX.AddNode(stage, "/World/Look/Up", "ND_transformnormal_vector3", types.Vector3f, fromspace="world", tospace="model",
                           **{"in": (0.3, 0.8, -0.5)})
    both = materialX.AddNode(stage, "/World/Look/Sum", "ND_add_vector3", types.Vector3f, in1=at, in2=up)
    color = materialX.AddNode(stage, "/World/Look/Color", "ND_convert_vector3_color3", types.Color3f, **{"in": (
        materialX.AddNode(stage, "/World/Look/Abs", "ND_absval_vector3", types.Vector3f, **{"in": both}))})
    material = materialX.AddSurface(stage, "/World/Look", base_color=color, specular_roughness=0.4)
    for prim in stage.Traverse():
        if prim.GetName() == "Brick":
            author.Bind(prim, material)
    stage.GetRootLayer().Save()


def InsideGlass(path) -> None:
    """Bodies of smooth glass, which take no light samples inside but those of a point, between surfaces that do; round lamps, one of
    them in a body."""
    stage = author.NewStage(path)
    clear, plain = dict(base=0.0, transmission=1.0, specular_roughness=0.0), dict(base_color=(0.6, 0.4, 0.3), specular_roughness=0.2)
    looks = [materialX.AddSurface(stage, f"/World/Look{index}", **inputs)
             for index, inputs in enumerate((clear, dict(clear, specular_roughness=0.3), plain))]
    author.AddMesh(stage, "/World/Floor", shapes.Plane(8, 8), color=(0.5, 0.5, 0.5))
    for index in range(6):
        author.AddMesh(stage, f"/World/Body{index}", shapes.Box(0.6, 0.6, 0.6) if index % 2 else materialX.Ball(0.35),
                       material=looks[index % 3], translate=(0.9 * (index % 3) - 0.9, 0.45, 0.8 * (index // 3) - 0.4), rotate=(0, 20, 15))
    author.AddLight(stage, "/World/Point", "Sphere", dict(translate=(1, 2, 1)), intensity=4.0, treatAsPoint=True)
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(-1, 2, 1), scale=(1, 2, 1), rotate=(0, 0, 30)), radius=0.2,
                    intensity=15.0)
    author.AddLight(stage, "/World/Inside", "Sphere", dict(translate=(-0.9, 0.45, -0.4)), radius=0.1, intensity=9.0)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(0, 1.2, 4.0), target=(0, 0.4, 0), aspect=61 / 47)
    stage.GetRootLayer().Save()


def Smooth(path) -> None:
    """Smooth glass and metal, which take no light samples, between surfaces that do; rays find all lights."""
    stage = author.NewStage(path)
    glass = materialX.AddSurface(stage, "/World/Glass", base=0.0, transmission=1.0, specular_roughness=0.0)
    metal = materialX.AddSurface(stage, "/World/Metal", base=1.0, base_color=(0.9, 0.7, 0.4), metalness=1.0, specular_roughness=0.0)
    coated = materialX.AddSurface(stage, "/World/Coated", base_color=(0.5, 0.1, 0.1), specular_roughness=0.0, coat=1.0, coat_roughness=0.0)
    author.AddMesh(stage, "/World/Floor", shapes.Plane(8, 8), color=(0.5, 0.5, 0.5))
    for index in range(6):
        author.AddMesh(stage, f"/World/Body{index}", shapes.Box(0.6, 0.6, 0.6) if index % 2 else materialX.Ball(0.35),
                       material=(glass, metal, coated)[index % 3], translate=(0.9 * (index % 3) - 0.9, 0.45, 0.8 * (index // 3) - 0.4),
                       rotate=(0, 20, 15))
    author.AddLight(stage, "/World/Lamp", "Rect", dict(translate=(1, 2.5, 1), rotate=(-70, 20, 0)), width=1.0, height=0.6, intensity=12.0)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(0, 1.2, 4.0), target=(0, 0.4, 0), aspect=61 / 47)
    stage.GetRootLayer().Save()


def Displaced(path) -> None:
    """Balls of few triangles whose shading has what these lack of noise: smooth, flat, instanced and stretched."""
    stage = author.NewStage(path)
    look, types = "/World/Look", Sdf.ValueTypeNames
    material = materialX.AddSurface(stage, look, base_color=(0.5, 0.4, 0.3), specular_roughness=0.3, coat=0.5)
    at = materialX.AddNode(stage, f"{look}/Place", "ND_position_vector3", types.Vector3f)
    scaled = materialX.AddNode(stage, f"{look}/Scaled", "ND_multiply_vector3FA", types.Vector3f, in1=at, in2=9.0)
    noise = materialX.AddNode(stage, f"{look}/Noise", "ND_noise3d_float", types.Float, position=scaled, amplitude=0.05)
    moved, _ = materialX.AddNode(stage, f"{look}/Displacement", "ND_displacement_float", types.Token, displacement=noise)
    material.CreateDisplacementOutput("mtlx").ConnectToSource(moved.GetOutput("out"))
    ball = shapes.Sphere(0.6, 9, 14)
    flat = shapes.Shape(ball.points, ball.counts, ball.indices)
    for number, (shape, place) in enumerate(((ball, {}), (flat, {}), (ball, dict(scale=(0.6, -1.3, 1), rotate=(20, 30, 40))))):
        author.AddMesh(stage, f"/World/Ball{number}", shape, material=material, translate=(1.2 * number - 1.2, 0.6, 0), **place)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(8, 8), color=(0.45, 0.45, 0.45))
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(-2, 4, 3), rotate=(-50, -30, 0)), width=2.0, height=2.0,
                    intensity=15.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(0, 1.2, 4.5), target=(0, 0.5, 0), aspect=61 / 47)
    stage.GetRootLayer().Save()


def Hair(path) -> None:
    """Hair, which takes the form of one path, between layered and plain surfaces, and one of both by chance."""
    stage = author.NewStage(path)
    materialX.UsdShade.Material.Define(stage, "/World/Looks")
    author.AddMesh(stage, "/World/Ground", shapes.Plane(24, 24), color=(0.3, 0.3, 0.3), translate=(0, -1.6, 0))
    look = hair.AddHair(stage, "/World/Looks/Hair", hair.OfDisplayColor(stage, "/World/Looks/Colour"), cuticle=0.52)
    colours = np.random.default_rng(1).uniform(0.1, 1.0, (300, 3))
    hair.AddBall(stage, "/World/Ball", look, 300, (-1.2, 0, 0), colours)
    both = hair.AddHair(stage, "/World/Looks/Both", (0.2, 0.4, 0.8))
    node = materialX.UsdShade.Shader.Get(stage, "/World/Looks/Both/Hair"), "out"
    diffuse = materialX.AddNode(stage, "/World/Looks/Both/Diffuse", "ND_oren_nayar_diffuse_bsdf", Sdf.ValueTypeNames.Token)
    mixed = materialX.AddNode(stage, "/World/Looks/Both/Mix", "ND_mix_bsdf", Sdf.ValueTypeNames.Token, fg=node, bg=diffuse, mix=0.6)
    materialX.AddSurface(stage, "/World/Looks/Both", "ND_surface", bsdf=mixed)
    author.AddMesh(stage, "/World/Shell", shapes.Sphere(0.8, 24, 48), material=both, translate=(1.4, -0.6, 0))
    author.AddLight(stage, "/World/Key", "Rect", dict(translate=(-4, 5, 5), rotate=(-40, -38, 0)), width=2.5, height=2.5, intensity=16.0)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.25)
    author.AddCamera(stage, eye=(0, 1.1, 6.6), target=(0, -0.3, 0), focalLength=40.0)
    stage.GetRootLayer().Save()
