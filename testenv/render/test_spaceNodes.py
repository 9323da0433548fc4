# SPDX-License-Identifier: Apache-2.0
"""Nodes that carry points, vectors and normals between object and world space, below transforms of every kind.

A row of cubes for each case glows with what a node gives, placed by the columns' transforms. Oracles: the matrices of the
columns, composed and inverted in double precision; the nodes `position` and `normal`, which know both spaces of a hit
without the matrix.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdShade, Vt

pytest.importorskip("hdstream._core")

import hdstream
import ours
from stages import author, shapes
from stages.materialX import AddNode

_T = Sdf.ValueTypeNames
_PLACE = 6  # units of the world that a cube has for itself
_PIXELS = 4  # of a unit
_IN = {"transformpoint": (0.3, -0.7, 1.1), "transformvector": (0.5, 1.5, -0.25), "transformnormal": (0.2, 0.9, -0.4)}
_CASES = [(kind, *spaces) for kind in _IN for spaces in (("object", "world"), ("world", "model"))]


def _Affine(linear, translation=(0, 0, 0)):
    """A matrix for column vectors, in double precision."""
    return np.block([[np.asarray(linear, float), np.reshape(np.asarray(translation, float), (3, 1))], [0, 0, 0, 1]])


def _Turn(axis, degrees):
    return np.array(Gf.Matrix3d(Gf.Rotation(Gf.Vec3d(*axis), degrees))).T


_TURNED = _Turn((1, 2, 3), 50) @ np.diag([1.5, 0.9, 1.2])
_MIRRORED = _Turn((0, 1, 0), 30) @ np.diag([-1.3, 1.0, 1.1])
_SHEARED = np.array([[1.2, 0.5, 0.0], [0.0, 1.1, -0.4], [0.2, 0.0, 1.3]])
_INSIDE = _Affine(_Turn((2, -1, 1), 70) @ np.diag([0.8, 1.2, 1.0]), (0.25, -0.5, 0.125))  # of nested things, in their parent
# (1, 1, 1) turned by 120 degrees: x goes to y.
_THIRD = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]])


def _Set(prim, matrix):
    UsdGeom.Xformable(prim).AddTransformOp().Set(Gf.Matrix4d(matrix.T.tolist()))


def _Cube(stage, path, material, offset=(0, 0, 0)):
    cube = shapes.Box(2.0, 2.0, 2.0)
    points = Vt.Vec3fArray([Gf.Vec3f(*(np.asarray(p, float) + offset)) for p in cube.points])
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(points)
    mesh.CreateFaceVertexCountsAttr(list(map(int, cube.counts)))
    mesh.CreateFaceVertexIndicesAttr(list(map(int, cube.indices)))
    mesh.CreateSubdivisionSchemeAttr("none")
    author.Bind(mesh, material)
    return mesh


def _AddPlaced(stage, path, material, place):
    _Set(_Cube(stage, path, material), place)
    return place


def _AddNested(stage, path, material, place):
    """A native instance of an Xform with a cube in it."""
    master = f"/Masters{path.replace('/', '_')}"
    stage.CreateClassPrim(master)
    _Set(_Cube(stage, master + "/Cube", material), _INSIDE)
    prim = UsdGeom.Xform.Define(stage, path)
    prim.GetPrim().GetReferences().AddInternalReference(master)
    prim.GetPrim().SetInstanceable(True)
    _Set(prim, place)
    return place @ _INSIDE


def _Instancer(stage, path, scale):
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    instancer.CreatePositionsAttr([(0.5, 0.25, -0.125)])
    instancer.CreateOrientationsAttr([Gf.Quath(0.5, 0.5, 0.5, 0.5)])
    instancer.CreateScalesAttr([Gf.Vec3f(*scale)])
    instancer.CreateProtoIndicesAttr([0])
    return instancer, _Affine(_THIRD @ np.diag(scale), (0.5, 0.25, -0.125))


def _AddInstancers(stage, path, material, place):
    """An instancer of an instancer of an Xform with two cubes, one in the other."""
    outer, first = _Instancer(stage, path, (1.0, -1.25, 1.0))
    inner, second = _Instancer(stage, path + "/Inner", (1.0, 1.5, 0.75))
    UsdGeom.Xform.Define(stage, path + "/Inner/Two")
    _Set(_Cube(stage, path + "/Inner/Two/Cube", material), _INSIDE)
    _Set(_Cube(stage, path + "/Inner/Two/Other", material), _INSIDE @ _Affine(0.5 * np.eye(3)))
    inner.CreatePrototypesRel().SetTargets([path + "/Inner/Two"])
    outer.CreatePrototypesRel().SetTargets([path + "/Inner"])
    within = first @ second @ _INSIDE
    own = _Affine(place[:3, :3], place[:3, 3] - place[:3, :3] @ within[:3, 3])  # the cube is where the column is
    _Set(outer, own)
    return own @ within


_COLUMNS = {
    "plain": (_AddPlaced, np.eye(3)), "turned": (_AddPlaced, _TURNED), "mirrored": (_AddPlaced, _MIRRORED), "sheared": (_AddPlaced, _SHEARED),
    "nested": (_AddNested, _TURNED), "nestedMirrored": (_AddNested, _MIRRORED @ _SHEARED), "instancers": (_AddInstancers, _TURNED),
}


def _Glow(stage, path, source, scale, offset=0.5):
    """A material that shows a vector, times a scale, around 0.5."""
    material = UsdShade.Material.Define(stage, path)
    scaled = AddNode(stage, f"{path}/Scaled", "ND_multiply_vector3FA", _T.Float3, in1=source, in2=scale)
    moved = AddNode(stage, f"{path}/Moved", "ND_add_vector3FA", _T.Float3, in1=scaled, in2=offset)
    color = AddNode(stage, f"{path}/Color", "ND_convert_vector3_color3", _T.Color3f, **{"in": moved})
    surface, _ = AddNode(stage, f"{path}/Surface", "ND_surface_unlit", _T.Token, emission_color=color)
    material.CreateSurfaceOutput("mtlx").ConnectToSource(surface.GetOutput("out"))
    return material


def _Carried(stage, path, kind, fromSpace, toSpace, value):
    return AddNode(stage, path, f"ND_{kind}_vector3", _T.Float3, fromspace=fromSpace, tospace=toSpace, **{"in": value})


def _Geometry(stage, path, category, space):
    return AddNode(stage, path, f"ND_{category}_vector3", _T.Float3, space=space)


def _Difference(stage, path, category, fromSpace, toSpace):
    """What carrying the node `category` gives, less what the node gives in the other space: nothing."""
    kind = "transformpoint" if category == "position" else "transformnormal"
    carried = _Carried(stage, f"{path}/Carried", kind, fromSpace, toSpace, _Geometry(stage, f"{path}/From", category, fromSpace))
    return AddNode(stage, f"{path}/Difference", "ND_subtract_vector3", _T.Float3, in1=carried, in2=_Geometry(stage, f"{path}/To", category, toSpace))


_DIFFERENCES = [(category, *spaces) for category in ("position", "normal") for spaces in (("object", "world"), ("world", "object"))]


class _Board:
    """Rows of cubes, a material each, and columns, a transform each, seen along -z."""

    def __init__(self, path, columns=_COLUMNS):
        self.path, self.columns, self.rows, self.matrices = str(path), columns, [], {}
        self.stage = author.NewStage(self.path)

    def AddRow(self, name, source, scale):
        row = len(self.rows)
        self.rows.append(name)
        path = f"/World/M{row}"
        material = _Glow(self.stage, path, source(self.stage, path), scale)
        for column, (place, linear) in enumerate(self.columns.values()):
            matrix = _Affine(linear, ((column + 0.5) * _PLACE, (row + 0.5) * _PLACE, 0))
            self.matrices[row, column] = place(self.stage, f"/World/C{row}_{column}", material, matrix)

    def Save(self):
        width, height = (len(n) * _PLACE for n in (self.columns, self.rows))
        middle = (width / 2, height / 2)
        author.AddCamera(self.stage, eye=(*middle, 60), target=(*middle, 0), up=(0, 1, 0), width=10.0 * width, aspect=width / height,
                         orthographic=True)
        self.stage.GetRootLayer().Save()
        self.size = (width * _PIXELS, height * _PIXELS)
        return self

    def Render(self, **settings):
        return ours.Render(self.path, *self.size, samples=1, maxDepth=0, **settings)

    def At(self, picture, row, column, scale):
        """The four pixels in the middle of a cube, whose place is whatever its matrix says; as vectors."""
        x, y = self.matrices[row, column][:2, 3] * _PIXELS
        x, y = int(round(x)), int(round(self.size[1] - y))
        return (picture.rgb[y - 1 : y + 1, x - 1 : x + 1].reshape(-1, 3) - 0.5) / scale


def _ScaleOf(kind):
    return 1 / 256 if kind == "transformpoint" else 0.1


def _Expected(kind, toWorld, matrix):
    """By the matrix from object to world space, in double precision."""
    value = np.array(_IN[kind], float)
    m = matrix if toWorld else np.linalg.inv(matrix)
    if kind == "transformpoint":
        return m[:3, :3] @ value + m[:3, 3]
    if kind == "transformvector":
        return m[:3, :3] @ value
    normal = np.linalg.inv(m[:3, :3]).T @ value
    return normal / np.linalg.norm(normal)


@pytest.fixture(scope="module")
def board(tmp_path_factory):
    result = _Board(tmp_path_factory.mktemp("spaces") / "board.usda")
    for kind, fromSpace, toSpace in _CASES:
        result.AddRow((kind, fromSpace, toSpace), lambda stage, path, k=kind, a=fromSpace, b=toSpace: _Carried(
            stage, path + "/Carried", k, a, b, _IN[k]), _ScaleOf(kind))
    result.AddRow("view", lambda stage, path: _Geometry(stage, path + "/View", "viewdirection", "object"), 0.25)
    for case in _DIFFERENCES:
        result.AddRow(case, lambda stage, path, c=case: _Difference(stage, path, *c), 1.0)
    result.Save()
    result.picture = result.Render()
    return result


@pytest.mark.parametrize("column", _COLUMNS)
@pytest.mark.parametrize("case", _CASES, ids="-".join)
def test_what_is_carried_is_that_of_the_matrix(board, case, column):
    row, place = board.rows.index(case), list(_COLUMNS).index(column)
    expected = _Expected(case[0], case[2] == "world", board.matrices[row, place])
    shown = board.At(board.picture, row, place, _ScaleOf(case[0]))
    # A float around 0.5 has steps of 6e-8, and points are of the size of the board.
    assert shown == pytest.approx(np.tile(expected, (4, 1)), abs=1e-4 if case[0] == "transformpoint" else 3e-6)


@pytest.mark.parametrize("case", _DIFFERENCES, ids="-".join)
def test_what_is_known_of_the_hit_is_carried_onto_itself(board, case):
    row = board.rows.index(case)
    for column in range(len(_COLUMNS)):
        shown = board.At(board.picture, row, column, 1.0)
        assert shown == pytest.approx(np.zeros((4, 3)), abs=1e-4 if case[0] == "position" else 2e-6), column


def test_the_direction_of_view_in_object_space(board):
    row = board.rows.index("view")
    for column in range(len(_COLUMNS)):
        expected = np.linalg.inv(board.matrices[row, column][:3, :3]) @ (0, 0, -1)  # the camera is orthographic
        shown = board.At(board.picture, row, column, 0.25)
        assert shown == pytest.approx(np.tile(expected / np.linalg.norm(expected), (4, 1)), abs=2e-6), column


def test_no_node_warns(board):
    assert board.picture.warnings == []


@pytest.mark.parametrize("settings", [
    dict(traversal="scalar"), dict(traversal="simd8"), dict(traversal="flat", residency="resident"),
    dict(residency="stream", geometryMemory="20%", chunkBytes=4096), dict(residency="stream", traversal="scalar"),
], ids=["scalar", "simd8", "flat", "streamed", "streamedScalar"])
def test_bits_are_the_same_however_rays_find_them(board, settings):
    assert board.Render(**settings).layers["color"].tobytes() == board.picture.layers["color"].tobytes()


def _One(path, source, place, scale, offset=(0, 0, 0), eye=(0, 0, 60), aspect=1.0):
    """A stage with one cube, which fills most of the picture."""
    stage = author.NewStage(str(path))
    material = _Glow(stage, "/World/M", source(stage, "/World/M"), scale)
    cube = _Cube(stage, "/World/Cube", material, offset)
    place(cube)
    author.AddCamera(stage, eye=eye, target=(*eye[:2], eye[2] - 60), up=(0, 1, 0), width=20.0, aspect=aspect, orthographic=True)
    return stage


def test_far_from_the_origin(tmp_path):
    """Points of the mesh, and its place, are far away: the renderer keeps both relative to places of its own."""
    inside, outside = np.array([4e5, -3e5, 2e5]), np.array([3e5, 5e5, -4e5])
    matrix = _Affine(_TURNED, outside - _TURNED @ inside)
    eye = tuple(outside + (0, 0, 60))
    cases = {"point": lambda stage, path: _Carried(stage, path + "/Carried", "transformpoint", "object", "world", tuple(inside)),
             "back": lambda stage, path: _Carried(stage, path + "/Carried", "transformpoint", "world", "object", tuple(outside)),
             "vector": lambda stage, path: _Carried(stage, path + "/Carried", "transformvector", "object", "world", (0.5, 0.25, 0.125))}
    expected = {"point": outside, "back": inside, "vector": _TURNED @ (0.5, 0.25, 0.125)}
    for name, source in cases.items():
        scale = 0.25 if name == "vector" else 2.0**-21
        stage = _One(tmp_path / f"{name}.usda", source, lambda cube: _Set(cube, matrix), scale, offset=inside, eye=eye)
        stage.GetRootLayer().Save()
        picture = ours.Render(tmp_path / f"{name}.usda", 8, 8, samples=1, maxDepth=0)
        shown = (picture.rgb[3:5, 3:5].reshape(-1, 3) - 0.5) / scale
        assert shown == pytest.approx(np.tile(expected[name], (4, 1)), abs=1e-5 if name == "vector" else 0.3), name


@pytest.mark.parametrize("name", ["position", "pivot"])
def test_what_moves_is_where_it_is_at_the_time_of_the_ray(tmp_path, name):
    """A cube that slides and turns: what is known of the hit is carried onto itself at any time; and the mean of a place over the
    shutter is that in the middle of a straight way, which is not where the frame has it."""
    def Source(stage, path):
        if name == "position":
            return _Difference(stage, path, "position", "world", "object")
        return _Carried(stage, path + "/Carried", "transformpoint", "object", "world", (0.25, 0.5, 0.0))

    def Place(cube):
        slide = UsdGeom.Xformable(cube).AddTranslateOp()
        slide.Set(Gf.Vec3d(-0.2, 0, 0), 1.0)
        slide.Set(Gf.Vec3d(0.2, 0.1, 0), 2.0)
        if name == "position":
            turn = UsdGeom.Xformable(cube).AddRotateYOp()
            turn.Set(0.0, 1.0)
            turn.Set(70.0, 2.0)
        UsdGeom.Xformable(cube).AddScaleOp().Set(Gf.Vec3f(1.0, 1.5, 1.0))

    scale = 0.5
    stage = _One(tmp_path / "a.usda", Source, Place, scale)
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    camera.CreateShutterOpenAttr(0.0)
    camera.CreateShutterCloseAttr(1.0)
    stage.GetRootLayer().Save()
    picture = hdstream.Renderer(str(tmp_path / "a.usda")).Render(
        1.0, imageWidth=8, imageHeight=8, camera="/World/Camera", pixelFilter="box", pixelFilterWidth=1.0, maxDepth=0, samples=256, noCache=True)
    shown = (picture.aovs["color"][3:5, 3:5, :3].astype(np.float64).reshape(-1, 3) - 0.5) / scale
    expected = (0, 0, 0) if name == "position" else (0.25, 0.75 + 0.05, 0.0)
    assert shown == pytest.approx(np.tile(expected, (4, 1)), abs=1e-6 if name == "position" else 5e-3)


def test_names_that_are_no_space_are_said(tmp_path):
    stage = _One(tmp_path / "a.usda", lambda stage, path: _Carried(stage, path + "/Carried", "transformvector", "tangent", "world", (0.5, 0.25, 1.0)),
                 lambda cube: _Set(cube, _Affine(_TURNED)), 0.25)
    stage.GetRootLayer().Save()
    picture = ours.Render(tmp_path / "a.usda", 8, 8, samples=1, maxDepth=0)
    assert sum("fromspace of /World/M/Carried is tangent, which is no space that is known" in line for line in picture.warnings) == 1
    assert (picture.rgb[4, 4] - 0.5) / 0.25 == pytest.approx((0.5, 0.25, 1.0), abs=1e-6)


def test_displacement_knows_no_world(tmp_path):
    stage = _One(tmp_path / "a.usda", lambda stage, path: (0.1, 0.2, 0.3), lambda cube: None, 1.0)
    place = _Carried(stage, "/World/M/Place", "transformpoint", "object", "world", (1.0, 2.0, 3.0))
    length = AddNode(stage, "/World/M/Length", "ND_magnitude_vector3", _T.Float, **{"in": place})
    moved, _ = AddNode(stage, "/World/M/Displacement", "ND_displacement_float", _T.Token, displacement=length)
    UsdShade.Material(stage.GetPrimAtPath("/World/M")).CreateDisplacementOutput("mtlx").ConnectToSource(moved.GetOutput("out"))
    stage.GetRootLayer().Save()
    picture = ours.Render(tmp_path / "a.usda", 8, 8, samples=1, maxDepth=0)
    assert sum("displacement by a network with the transform of an instance is ignored" in line for line in picture.warnings) == 1
