# SPDX-License-Identifier: Apache-2.0
"""Stages in which something moves around frame 1, with samples at frames 0 and 2."""

import pathlib

import numpy as np
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade, UsdVol, Vt

from . import author, curves, motionLights, motionShapes, shapes, smoke, splats
from .ways import AddBox, AddWay

FRAME = 1.0
SHUTTER = (-0.5, 0.5)


def SetPoints(pointBased, first, last):
    """Points at the frames 0 and 2; at frame 1 they are halfway."""
    for time, points in ((0.0, first), (2.0, last)):
        pointBased.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, np.float32)), time)


def Grid(size):
    """A square of size x size quads in the plane z = 0, from -1 to 1."""
    x, y = np.meshgrid(np.linspace(-1, 1, size + 1), np.linspace(-1, 1, size + 1))
    index = np.arange((size + 1) ** 2).reshape(size + 1, size + 1)
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1)
    return shapes.Shape(np.stack([x, y, 0 * x], -1).reshape(-1, 3), np.full(size * size, 4), quads)


def _AddMovingBox(stage):
    AddWay(AddBox(stage, "/World/Box"), (-3, 0.5, 0), (3, 0, 0))


def _AddTurningBox(stage):
    AddWay(AddBox(stage, "/World/Box"), (0, 0, 0), (0.5, 0, 0), degrees=500.0)


def _AddNestedInstances(stage):
    """Boxes that turn in a swarm that moves in a group that turns."""
    AddWay(UsdGeom.Xform.Define(stage, "/World/Group"), (0, 0, 0), (0, 0, 0), degrees=90.0)
    swarm = UsdGeom.PointInstancer.Define(stage, "/World/Group/Swarm")
    AddWay(AddBox(stage, "/World/Group/Swarm/Box"), (0, 0, 0), (0.4, 0, 0), degrees=120.0)
    author.AddMesh(stage, "/World/Group/Swarm/Ball", shapes.Sphere(0.3, 8, 12), color=(0.2, 0.5, 0.8), translate=(0, 0.6, 0))
    swarm.CreatePrototypesRel().SetTargets(["/World/Group/Swarm/Box", "/World/Group/Swarm/Ball"])
    swarm.CreateProtoIndicesAttr([0, 1, 0])
    positions = swarm.CreatePositionsAttr()
    positions.Set([(-1.2, 0, 0), (1.2, 0, 0), (0, -1, 0)], 0.0)
    positions.Set([(-1.2, 1.5, 0), (0.6, -1, 0), (0, -1, 0)], 2.0)


def _Wave(points, way):
    return points + np.stack([0 * points[:, 0], way * np.sin(2.0 * points[:, 0]), 0.8 * way * points[:, 0]], -1)


def _AddSheet(stage, scheme):
    grid = Grid(12)
    mesh = author.AddMesh(stage, "/World/Sheet", grid, color=(0.8, 0.5, 0.2), doubleSided=True)
    mesh.GetSubdivisionSchemeAttr().Set(scheme)
    SetPoints(mesh, _Wave(grid.points, -1.2), _Wave(grid.points, 1.2))



def _AddBendingPolygons(stage):
    _AddSheet(stage, "none")


def _AddBendingSurface(stage):
    _AddSheet(stage, "catmullClark")


def _AddCurves(stage):
    rng = np.random.default_rng(3)
    roots = rng.uniform(-1, 1, (40, 1, 3)) * (1, 1, 0.2)
    hairs = roots + np.linspace(0, 1, 5)[:, None] * (0.2, 0.6, 0.1)
    prim = curves.AddCurves(stage, "/World/Hair", list(hairs), 0.12, wrap="pinned", color=(0.6, 0.4, 0.2))
    moved = hairs + np.linspace(0, 1, 5)[:, None] ** 2 * (1.2, -0.6, 0.4)
    SetPoints(prim, hairs.reshape(-1, 3), moved.reshape(-1, 3))


def _AddRibbons(stage):
    rng = np.random.default_rng(4)
    roots = rng.uniform(-1, 1, (20, 1, 3)) * (1, 1, 0.2)
    ribbons = roots + np.linspace(0, 1, 5)[:, None] * (0.2, 0.6, 0.1)
    prim = curves.AddCurves(stage, "/World/Ribbons", list(ribbons), 0.2, wrap="pinned", normals=[(0, 0, 1)],
                            normalInterpolation="constant", color=(0.3, 0.7, 0.3))
    SetPoints(prim, ribbons.reshape(-1, 3), (ribbons + (0.5, 0.2, 0)).reshape(-1, 3))


def _AddPoints(stage):
    """Dust that velocities move."""
    rng = np.random.default_rng(5)
    points = rng.uniform(-1.2, 1.2, (60, 3))
    prim = UsdGeom.Points(curves.AddPoints(stage, "/World/Dust", points, rng.uniform(0.1, 0.4, 60), color=(0.5, 0.5, 0.8)))
    prim.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)), FRAME)
    velocities = rng.uniform(-1, 1, (60, 3)) * 24.0  # per second
    prim.CreateVelocitiesAttr().Set(Vt.Vec3fArray.FromNumpy(velocities.astype(np.float32)), FRAME)


# Frames at which what goes there and back has samples: so many parts of the shutter's interval lie between them.
_STEPS = (0.5, 0.75, 1.0, 1.25, 1.5)


def _SetOverSteps(attribute, valueAt, steps=_STEPS):
    """valueAt(part) at frames: part 0 at the opening of the shutter, 1 at its closing."""
    for frame in steps:
        attribute.Set(valueAt((frame - steps[0]) / (steps[-1] - steps[0])), frame)


def _Float3s(points):
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, np.float32))


def _AddReturningPolygons(stage):
    """A sheet that leaves and is back when the shutter closes, with authored normals that turn as it bends."""
    grid = Grid(12)
    mesh = author.AddMesh(stage, "/World/Sheet", grid, color=(0.8, 0.5, 0.2), doubleSided=True)
    mesh.GetSubdivisionSchemeAttr().Set("none")
    bend = lambda part: 1.6 * np.sin(np.pi * part)
    _SetOverSteps(mesh.GetPointsAttr(), lambda part: _Float3s(_Wave(grid.points, bend(part))))
    slope = lambda part: np.stack([-0.8 * bend(part) + 0 * grid.points[:, 0], 0 * grid.points[:, 0], 1 + 0 * grid.points[:, 0]], -1)
    mesh.SetNormalsInterpolation("vertex")
    _SetOverSteps(mesh.CreateNormalsAttr(), lambda part: _Float3s(slope(part) / np.linalg.norm(slope(part), axis=1, keepdims=True)))


def _AddUnevenSurface(stage):
    """A subdivided sheet whose samples lie at odd times."""
    grid = Grid(8)
    mesh = author.AddMesh(stage, "/World/Sheet", grid, color=(0.8, 0.5, 0.2), doubleSided=True)
    mesh.GetSubdivisionSchemeAttr().Set("catmullClark")
    steps = (0.5, 0.6, 0.9, 1.5)
    _SetOverSteps(mesh.GetPointsAttr(), lambda part: _Float3s(_Wave(grid.points, 2.0 * np.sin(4.0 * part))), steps)


def _AddGrowingHair(stage):
    """Hairs that swing, and get thicker and thinner."""
    rng = np.random.default_rng(3)
    roots = rng.uniform(-1, 1, (40, 1, 3)) * (1, 1, 0.2)
    along = np.linspace(0, 1, 5)[:, None]
    hairs = roots + along * (0.2, 0.6, 0.1)
    prim = curves.AddCurves(stage, "/World/Hair", list(hairs), 0.12, wrap="pinned", color=(0.6, 0.4, 0.2))
    swing = lambda part: hairs + along ** 2 * (1.2 * np.sin(2 * np.pi * part), -0.6 * part, 0.4)
    _SetOverSteps(prim.GetPointsAttr(), lambda part: _Float3s(swing(part).reshape(-1, 3)))
    for widths in (prim.GetPrim().GetAttribute(name) for name in ("widths", "primvars:widths")):
        if widths and widths.HasAuthoredValue():
            size = len(widths.Get())
            widths.Clear()
            _SetOverSteps(widths, lambda part: Vt.FloatArray([0.06 + 0.3 * part * (1 - part)] * size))


def _AddThrownPoints(stage):
    """Dust on parabolas, by velocities and accelerations, that grows."""
    rng = np.random.default_rng(5)
    points = rng.uniform(-1.2, 1.2, (60, 3))
    prim = UsdGeom.Points(curves.AddPoints(stage, "/World/Dust", points, rng.uniform(0.1, 0.3, 60), color=(0.5, 0.5, 0.8)))
    prim.GetPointsAttr().Set(_Float3s(points), FRAME)
    prim.CreateVelocitiesAttr().Set(_Float3s(rng.uniform(-1, 1, (60, 3)) * 12.0), FRAME)
    prim.CreateAccelerationsAttr().Set(_Float3s(rng.uniform(-1, 1, (60, 3)) * 8.0 * 24.0 ** 2), FRAME)


def _AddReturningSwarm(stage):
    """Instances that leave and return."""
    swarm = UsdGeom.PointInstancer.Define(stage, "/World/Swarm")
    AddBox(stage, "/World/Swarm/Box")
    swarm.CreatePrototypesRel().SetTargets(["/World/Swarm/Box"])
    swarm.CreateProtoIndicesAttr([0, 0, 0])
    places = np.array([(-1.2, 0, 0), (1.2, 0, 0), (0, -1, 0)])
    ways = np.array([(0, 1.5, 0), (-0.8, 0.3, 0), (1.0, 0.0, 0.2)])
    _SetOverSteps(swarm.CreatePositionsAttr(), lambda part: _Float3s(places + ways * np.sin(np.pi * part)))


def _AddTurningSplats(stage):
    """Splats that turn, grow, fade and go there and back, without light of their own on the wall."""
    cloud = splats.RandomCloud(60, 1, 8, reach=1.3, size=(0.05, 0.6), opacity=(0.3, 1.0))
    cloud["coefficients"] *= 0.5
    prim = splats.AddSplats(stage, "/World/Splats", cloud)
    other = splats.OtherShapes(cloud, 9)
    ends = {name: cloud[name] for name in other}
    ways = np.random.default_rng(10).uniform(-0.7, 0.7, cloud["positions"].shape)
    for frame, shapes_, way in ((0.5, ends, 0.0), (0.9, other, 1.0), (1.5, ends, 0.0)):
        splats.SetArrays(prim, {**shapes_, "positions": cloud["positions"] + way * ways}, timeCode=frame)


def _AddNothing(stage):
    AddBox(stage, "/World/Box")


def _AddFar(stage):
    """Out of sight: all stages have a point and a group, and so the same kernels."""
    curves.AddPoints(stage, "/World/Far", [(0, 0, 50)], 0.01)
    group = UsdGeom.PointInstancer.Define(stage, "/World/FarGroup")
    UsdGeom.Xform.Define(stage, "/World/FarGroup/Pair")
    for name in ("A", "B"):
        author.AddMesh(stage, f"/World/FarGroup/Pair/{name}", shapes.Box(0.01, 0.01, 0.01), translate=(0, 0, 50))
    group.CreatePrototypesRel().SetTargets(["/World/FarGroup/Pair"])
    group.CreateProtoIndicesAttr([0])
    group.CreatePositionsAttr([(0, 0, 0)])


def _AddGlow(stage):
    """Boxes that emit, by material, below an instancer that turns: each moves, turns and grows. And a panel near the wall,
    which the camera does not see, whose area becomes 64 times as large: the density at hits is that of the time."""
    AddBox(stage, "/World/Box")
    swarm = UsdGeom.PointInstancer.Define(stage, "/World/Glows")
    AddWay(swarm, (0, 0, 1.4), (0, 0.3, 1.4), degrees=70.0)
    glow = author.AddMaterial(stage, "/World/Glow", emissiveColor=(9.0, 4.0, 2.0), diffuseColor=(0.0, 0.0, 0.0))
    mesh = author.AddMesh(stage, "/World/Glows/Glow", shapes.Box(0.6, 0.2, 0.3), material=glow)
    grow = UsdGeom.Xformable(mesh).AddScaleOp()
    grow.Set(Gf.Vec3f(0.6, 1.0, 1.0), 0.0)
    grow.Set(Gf.Vec3f(1.6, 0.7, 1.0), 2.0)
    panel = author.AddMesh(stage, "/World/Panel", Grid(1), material=glow, doubleSided=True, translate=(-3.6, 0.2, -0.7))
    grow = UsdGeom.Xformable(panel).AddScaleOp()
    grow.Set(Gf.Vec3f(0.1, 0.2, 1.0), 0.0)
    grow.Set(Gf.Vec3f(0.8, 1.6, 1.0), 2.0)
    swarm.CreatePrototypesRel().SetTargets(["/World/Glows/Glow"])
    swarm.CreateProtoIndicesAttr([0, 0])
    positions = swarm.CreatePositionsAttr()
    positions.Set([(-2.5, 0, 0), (2, 1, 0)], 0.0)
    positions.Set([(2.5, 0.5, 0), (0, -1.5, 0.6)], 2.0)


def _AddBeam(stage):
    """A flat mesh light with a beam, that turns and moves: its light samples follow its axis."""
    AddBox(stage, "/World/Box")
    mesh = author.AddMesh(stage, "/World/Beam", Grid(2), doubleSided=True)
    UsdLux.MeshLightAPI.Apply(mesh.GetPrim())
    light = UsdLux.LightAPI(mesh.GetPrim())
    light.CreateIntensityAttr(60.0)
    author.ShapeLight(light, coneAngle=40.0, coneSoftness=0.3, focus=2.0)
    AddWay(mesh, (-0.5, 0.3, 3.0), (0.8, 0.0, 3.2))
    turn = UsdGeom.Xformable(mesh).AddRotateYOp()
    turn.Set(-70.0, 0.0)
    turn.Set(70.0, 2.0)
    UsdGeom.Xformable(mesh).AddScaleOp().Set(Gf.Vec3f(0.4, 0.25, 1.0))


def _AddFlame(stage):
    """A subdivided tongue that bends, there and back, while it goes along, and whose emission a primvar varies."""
    AddBox(stage, "/World/Box")
    grid = Grid(6)
    glow = author.AddMaterial(stage, "/World/Heat", {"emissiveColor": ("heat", "float3", (0.0, 0.0, 0.0))}, diffuseColor=(0.0, 0.0, 0.0))
    mesh = author.AddMesh(stage, "/World/Flame", grid, material=glow, doubleSided=True)
    mesh.GetSubdivisionSchemeAttr().Set("catmullClark")
    heat = np.clip(grid.points[:, :1] + 0.6, 0.0, None) * np.array([6.0, 3.0, 1.0])
    UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("heat", Sdf.ValueTypeNames.Color3fArray, "vertex").Set(_Float3s(heat))
    tongue = grid.points * (0.5, 0.9, 1.0)
    _SetOverSteps(mesh.GetPointsAttr(), lambda part: _Float3s(_Wave(tongue, 1.5 * np.sin(np.pi * part))))
    AddWay(mesh, (-1.5, 0.3, 0.8), (1.5, -0.2, 1.0), degrees=60.0)


def _AddSmoke(stage, path):
    """A volume of 32^3 voxels, 1.6 wide, of bars and a corner that glows: nothing of it is the same from elsewhere."""
    folder = pathlib.Path(stage.GetRootLayer().realPath).parent
    density = np.zeros((32, 32, 32))
    density[4:28, 12:18, 10:20] = 1.0
    density[20:27, 4:28, 12:20] = np.linspace(0.2, 2.0, 24)[:, None]
    heat = np.zeros_like(density)
    heat[4:10, 12:18, 10:20] = 1.0
    smoke.WriteVdb(folder / "bars.vdb", 0.05, (-16, -16, -16), density=density, heat=heat)
    look = UsdShade.Material.Define(stage, "/World/SmokeLook")
    look.CreateVolumeOutput().ConnectToSource(smoke.AddShader(
        stage, "/World/SmokeLook/Volume", "arnold:standard_volume", density=4.0, scatter_color=(0.8, 0.5, 0.3), emission=3.0,
        emission_color=(0.2, 0.5, 1.0), emission_mode="channel", emission_channel="heat"))
    volume = UsdVol.Volume.Define(stage, path)
    for name in ("density", "heat"):
        asset = UsdVol.OpenVDBAsset.Define(stage, f"{path}/{name}")
        asset.CreateFilePathAttr("./bars.vdb")
        volume.CreateFieldRelationship(name, asset.GetPath())
    UsdShade.MaterialBindingAPI.Apply(volume.GetPrim()).Bind(look)
    return volume


def _AddTurningSmoke(stage):
    """It goes along, turns by more than half a circle, and grows, behind a box that moves too."""
    AddWay(author.AddMesh(stage, "/World/Box", shapes.Box(0.5, 0.3, 0.3), color=(0.8, 0.5, 0.2)), (-1, -1.4, 0.5), (1, -1.4, 0.5))
    volume = _AddSmoke(stage, "/World/Smoke")
    AddWay(volume, (-1.2, 0.3, 0), (1.4, 0, 0), degrees=420.0)
    grow = UsdGeom.Xformable(volume).AddScaleOp()
    grow.Set(Gf.Vec3f(0.7, 0.9, 1.0), 0.0)
    grow.Set(Gf.Vec3f(1.6, 1.1, 1.0), 2.0)


def _AddSmokeSwarm(stage):
    """Volumes of an instancer that moves, whose instances leave and return."""
    swarm = UsdGeom.PointInstancer.Define(stage, "/World/Puffs")
    AddWay(swarm, (0, 0, 0), (0.4, 0, 0), degrees=60.0)
    _AddSmoke(stage, "/World/Puffs/Puff")
    swarm.CreatePrototypesRel().SetTargets(["/World/Puffs/Puff"])
    swarm.CreateProtoIndicesAttr([0, 0])
    places, ways = np.array([(-1.2, 0, 0), (1.0, 0.4, 0.0)]), np.array([(0.3, 1.5, 0), (-0.4, -1.2, 0.5)])
    _SetOverSteps(swarm.CreatePositionsAttr(), lambda part: _Float3s(places + ways * np.sin(np.pi * part)))


def _SetOverFrames(attribute, first, last):
    attribute.Set(first, 0.0)
    attribute.Set(last, 2.0)


def _SetFilm(camera, *values):
    """Apertures and offsets at the frames 0 and 2, in pairs."""
    names = ("HorizontalAperture", "VerticalAperture", "HorizontalApertureOffset", "VerticalApertureOffset")
    for name, (first, last) in zip(names, values):
        _SetOverFrames(getattr(camera, f"Create{name}Attr")(), first, last)


def _SetShift(camera):
    """The film shifts, and gets larger."""
    _SetFilm(camera, (24.0, 44.0), (18.0, 33.0), (-8.0, 6.0), (3.0, -5.0))


def _SetOrthographic(camera):
    """An orthographic zoom with a lens in front of it."""
    camera.CreateProjectionAttr("orthographic")
    _SetFilm(camera, (24.0, 70.0), (18.0, 52.5))
    camera.CreateFStopAttr(4.0)
    camera.CreateFocusDistanceAttr(5.0)


def _SetFisheye(camera):
    """A fisheye that turns and moves, with an open lens that is focused on its way."""
    camera.GetPrim().CreateAttribute("hdstream:camera:projection", Sdf.ValueTypeNames.Token).Set("fisheyeEquisolid")
    camera.ClearXformOpOrder()
    AddWay(camera, (-1.0, -0.5, 3), (1.0, 0.5, 4), degrees=70.0)
    camera.CreateFStopAttr(2.0)
    _SetOverFrames(camera.CreateFocusDistanceAttr(), 1.0, 5.0)


# What moves in a stage, by name; "camera", "focus" and "zoom" are still but for the camera.
SCENES = {
    "way": _AddMovingBox, "turn": _AddTurningBox, "nested": _AddNestedInstances, "polygons": _AddBendingPolygons,
    "surface": _AddBendingSurface, "curves": _AddCurves, "ribbons": _AddRibbons, "points": _AddPoints, "camera": _AddNothing,
    "focus": _AddNothing, "zoom": _AddNothing,
}
# What has samples within the shutter's interval, more than at its ends.
KEYS = {
    "returns": _AddReturningPolygons, "uneven": _AddUnevenSurface, "growing": _AddGrowingHair, "thrown": _AddThrownPoints,
    "swarm": _AddReturningSwarm, "splats": _AddTurningSplats,
}
# Lights that move. Their pictures need more stills: what moves is bright, or sharp.
LIGHTS = {
    **motionLights.SCENES, "glow": _AddGlow, "beam": _AddBeam, "flame": _AddFlame,
}
# Shapes that are not authored point by point.
SHAPES = motionShapes.SCENES
# Cameras that change, by name: what sets them.
CAMERAS = {"shift": _SetShift, "orthographic": _SetOrthographic, "fisheye": _SetFisheye}
# Volumes whose transforms move.
VOLUMES = {"turningSmoke": _AddTurningSmoke, "smokeSwarm": _AddSmokeSwarm}


def Write(path, *names, shutter=SHUTTER):
    """A stage with the scenes named, in front of a wall, lit from the side."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Wall", shapes.Plane(12, 12), color=(0.4, 0.4, 0.4), translate=(0, 0, -1.5), rotate=(90, 0, 0))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-30, 25, 0)), intensity=1.5, angle=2.0, normalize=True)
    _AddFar(stage)
    for name in names:
        {**SCENES, **KEYS, **LIGHTS, **SHAPES, **VOLUMES, **dict.fromkeys(CAMERAS, _AddNothing)}[name](stage)
    camera = author.AddCamera(stage, eye=(0, 0, 6), focalLength=40.0)
    camera.CreateShutterOpenAttr(shutter[0])
    camera.CreateShutterCloseAttr(shutter[1])
    if "camera" in names:
        camera.ClearXformOpOrder()
        AddWay(camera, (-1.0, -0.5, 5), (1.0, 0.5, 7), degrees=40.0)
    if "focus" in names:
        _SetOverFrames(camera.CreateFStopAttr(), 1.5, 4.0)
        _SetOverFrames(camera.CreateFocusDistanceAttr(), 2.0, 9.0)
    if "zoom" in names:
        _SetOverFrames(camera.CreateFocalLengthAttr(), 20.0, 60.0)
    for name in CAMERAS.keys() & names:
        CAMERAS[name](camera)
    stage.SetStartTimeCode(FRAME)
    stage.SetEndTimeCode(FRAME)
    stage.GetRootLayer().Save()
    return str(path)
