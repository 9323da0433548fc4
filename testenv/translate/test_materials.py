# SPDX-License-Identifier: Apache-2.0
"""Bound materials are those UsdShade computes for every drawn prim, instances included; assets are
found inside packages at the byte where they are stored."""

import zipfile

import numpy as np
import pytest
from pxr import Ar, Sdf, Usd, UsdGeom, UsdShade

from hdstream import _core
from hdstream.translate.assets import AssetResolver
from translateCase import StageOf, Translate


def RandomBindings(seed):
    """Instances of one prototype below parents that bind in every way UsdShade knows."""
    rng = np.random.default_rng(seed)
    stage = Usd.Stage.CreateInMemory()
    materials = []
    for index in range(4):
        material = UsdShade.Material.Define(stage, f"/Looks/M{index}")
        shader = UsdShade.Shader.Define(stage, f"/Looks/M{index}/S")
        shader.SetShaderId("UsdPreviewSurface")
        material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", Sdf.ValueTypeNames.Token))
        materials.append(material)
    stage.CreateClassPrim("/_proto")
    for index in range(3):
        UsdGeom.Sphere.Define(stage, f"/_proto/ball{index}")
    BindSome(stage, ["/_proto/ball0", "/_proto/ball1"], materials, rng, 0.5)
    paths = ["/World"]
    UsdGeom.Xform.Define(stage, "/World")
    for group in range(2):
        UsdGeom.Xform.Define(stage, f"/World/g{group}")
        paths.append(f"/World/g{group}")
        for index in range(4):
            path = f"/World/g{group}/i{index}"
            prim = UsdGeom.Xform.Define(stage, path).GetPrim()
            prim.GetReferences().AddInternalReference("/_proto")
            prim.SetInstanceable(True)
            # The position names the instance.
            UsdGeom.Xformable(prim).AddTranslateOp().Set((group * 10 + index, 0, 0))
            paths.append(path)
    BindSome(stage, paths, materials, rng, 0.4)
    if seed % 2:
        root = stage.GetPrimAtPath("/World")
        api = Usd.CollectionAPI.Apply(root, "some")
        api.CreateIncludesRel().AddTarget("/World/g1/i1")
        api.CreateIncludesRel().AddTarget("/World/g0/i2/ball2")
        UsdShade.MaterialBindingAPI.Apply(root).Bind(api, materials[3])
    return stage


def BindSome(stage, paths, materials, rng, share):
    for path in paths:
        if rng.random() > share:
            continue
        binding = UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath(path))
        strength = (UsdShade.Tokens.strongerThanDescendants if rng.random() < 0.3
                    else UsdShade.Tokens.weakerThanDescendants)
        purpose = "full" if rng.random() < 0.4 else UsdShade.Tokens.allPurpose
        binding.Bind(materials[int(rng.integers(0, 3))], strength, purpose)


def FoundMaterials(scene):
    """(instance number, leaf name, material) of every placed mesh."""
    found = set()
    for path, mesh in scene.geometry.items():
        instancer = scene.instancers[mesh.placement.instancerPath]
        for index in mesh.placement.instances:
            found.add((int(instancer.instanceTransforms[index][12]), path.rpartition("/")[2], mesh.materialPath))
    return found


@pytest.mark.parametrize("seed", range(40))
def test_every_instance_has_its_bound_material(seed):
    stage = RandomBindings(seed)
    expected = set()
    for prim in stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
        if prim.IsA(UsdGeom.Sphere):
            material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("full")
            number = int(prim.GetParent().GetAttribute("xformOp:translate").Get()[0])
            expected.add((number, prim.GetName(), str(material.GetPath()) if material else ""))
    scene = Translate(stage).Scene()
    assert FoundMaterials(scene) == expected
    assert set(scene.materials) == {material for *_, material in expected if material}


def test_equal_looking_instances_share_an_instancer():
    """Primvars of one value may differ: the instancer has them, also those that say who sees a prim. Arrays may not."""
    stage = StageOf("""
        class "P" { def Sphere "S" {} }
        def Xform "A" (instanceable = true; references = </P>) { color3f[] primvars:displayColor = [(1, 0, 0)] }
        def Xform "B" (instanceable = true; references = </P>) { color3f[] primvars:displayColor = [(1, 0, 0)] }
        def Xform "C" (instanceable = true; references = </P>) { color3f[] primvars:displayColor = [(0, 1, 0)] }
        def Xform "D" (instanceable = true; references = </P>) {
            color3f[] primvars:displayColor = [(1, 0, 0)]
            bool primvars:hdstream:holdout = 1
        }
        def Xform "E" (instanceable = true; references = </P>) {
            color3f[] primvars:displayColor = [(0, 0, 1)]
            bool primvars:hdstream:holdout = 0
        }
        def Xform "F" (instanceable = true; references = </P>) { color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0)] }
    """)
    scene = Translate(stage).Scene()
    assert sorted(scene.instancers) == ["/A", "/D", "/F"]
    (primvar,) = scene.instancers["/A"].primvars
    assert (primvar.name, primvar.numComponents) == ("displayColor", 3)
    assert np.array_equal(primvar.values.reshape(-1, 3), [[1, 0, 0], [1, 0, 0], [0, 1, 0]])
    assert not [one for one in scene.geometry["/A/S"].geometry.primvars if one.name == "displayColor"]
    rows = {primvar.name: list(primvar.values.reshape(-1)) for primvar in scene.instancers["/D"].primvars}
    assert rows == {"displayColor": [1, 0, 0, 0, 0, 1], "hdstream:holdout": [1, 0]}
    assert not scene.instancers["/F"].primvars
    assert [one for one in scene.geometry["/F/S"].geometry.primvars if one.name == "displayColor"]


def test_linked_instances_have_the_values_of_their_own():
    """Links make several instancers of native instances; each has what its own instances inherit."""
    stage = StageOf("""
        class "P" { def Sphere "S" {} }
        def Xform "A" (instanceable = true; references = </P>) { color3f[] primvars:displayColor = [(1, 0, 0)] }
        def Xform "B" (instanceable = true; references = </P>) { color3f[] primvars:displayColor = [(0, 1, 0)] }
        def SphereLight "L" (prepend apiSchemas = ["CollectionAPI:lightLink"]) {
            uniform bool collection:lightLink:includeRoot = 0
            rel collection:lightLink:includes = </A>
        }
    """)
    scene = Translate(stage).Scene()
    found = {path: [list(one.values.reshape(-1)) for one in prim.geometry.primvars if one.name == "displayColor"]
             for path, prim in scene.geometry.items()}
    assert found == {"/A/S": [[1, 0, 0]], "/B/S": [[0, 1, 0]]}


def MakePackage(folder, nested):
    """A usdz file with an image and a stage, inside a second package when `nested`."""
    image = bytes(range(256)) * 5
    (folder / "tex").mkdir()
    (folder / "tex" / "image.png").write_bytes(image)
    text = """#usda 1.0
def Material "M" {
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader "S" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>
        token outputs:surface
    }
    def Shader "T" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @tex/image.png@
        float3 outputs:rgb
    }
}
def Sphere "Ball" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    rel material:binding = </M>
}
"""
    (folder / "scene.usda").write_text(text, encoding="utf-8")
    package = folder / "inner.usdz"
    with Sdf.ZipFileWriter.CreateNew(str(package)) as writer:
        writer.AddFile(str(folder / "scene.usda"), "scene.usda")
        writer.AddFile(str(folder / "tex" / "image.png"), "tex/image.png")
    if not nested:
        return str(package), image
    outer = folder / "outer.usdz"
    (folder / "root.usda").write_text('#usda 1.0\ndef "R" (references = @inner.usdz@</M>) {}\n'
                                      'def "B" (references = @inner.usdz@</Ball>) {}\n', encoding="utf-8")
    with Sdf.ZipFileWriter.CreateNew(str(outer)) as writer:
        writer.AddFile(str(folder / "root.usda"), "root.usda")
        writer.AddFile(str(package), "inner.usdz")
    return str(outer), image


@pytest.mark.parametrize("nested", [False, True])
def test_textures_in_packages_are_byte_ranges(tmp_path, nested):
    package, image = MakePackage(tmp_path, nested)
    stage = Usd.Stage.Open(package)
    attribute = stage.GetPrimAtPath("/R/T" if nested else "/M/T").GetAttribute("inputs:file")
    if nested:
        # The reference reaches the material only: its texture is at /R/T.
        assert attribute.Get().resolvedPath == Ar.JoinPackageRelativePath([package, "inner.usdz", "tex/image.png"])
    reference = AssetResolver().Resolve(attribute, attribute.Get())
    assert reference.file == package and reference.size == len(image)
    with open(reference.file, "rb") as stream:
        stream.seek(reference.offset)
        assert stream.read(reference.size) == image
    if not nested:
        info = Sdf.ZipFile.Open(package).GetFileInfo("tex/image.png")
        assert (reference.offset, reference.size) == (info.dataOffset, info.size)


def test_what_packages_do_not_have_is_not_found(tmp_path):
    package, image = MakePackage(tmp_path, False)
    file, offset, size = _core.FindInPackage(f"{package}[tex/image.png]")
    assert (file, size) == (package, len(image)) and offset > 0
    assert _core.FindInPackage(f"{package}[tex/none.png]") is None
    assert _core.FindInPackage(package) is None
    (tmp_path / "broken.usdz").write_bytes(b"no zip")
    assert _core.FindInPackage(f"{tmp_path}/broken.usdz[a.png]") is None


@pytest.mark.parametrize("utf8Flag", [False, True])
@pytest.mark.parametrize("folder", ["plain", "odd [v2] folder"])
def test_names_that_are_not_ascii_are_found_in_packages(tmp_path, folder, utf8Flag):
    """OpenUSD writes UTF-8 without the flag that says so; other programs set it. Brackets of folders are no package's."""
    (tmp_path / folder).mkdir()
    package = f"{tmp_path}/{folder}/names.usdz"
    names = ["tex/Grün 木.png", "tex/a[1].png"]
    text = "#usda 1.0\n" + "".join(f'def Shader "T{i}" {{\nasset inputs:file = @{name}@\n}}\n'
                                    for i, name in enumerate(names))
    contents = {"s.usda": text.encode(), names[0]: b"first image", names[1]: b"second"}
    if utf8Flag:
        with zipfile.ZipFile(package, "w") as archive:
            for name, content in contents.items():
                archive.writestr(name, content)
    else:
        with Sdf.ZipFileWriter.CreateNew(package) as writer:
            for name, content in contents.items():
                (tmp_path / "file").write_bytes(content)
                writer.AddFile(str(tmp_path / "file"), name)
    stage = Usd.Stage.Open(package)
    for i, name in enumerate(names):
        attribute = stage.GetPrimAtPath(f"/T{i}").GetAttribute("inputs:file")
        reference = AssetResolver().Resolve(attribute, attribute.Get())
        assert reference.file == package
        with open(package, "rb") as stream:
            stream.seek(reference.offset)
            assert stream.read(reference.size) == contents[name]


def test_udim_pattern_is_resolved(tmp_path):
    (tmp_path / "t.1001.png").write_bytes(b"x")
    (tmp_path / "s.usda").write_text('#usda 1.0\ndef Shader "T" {\nasset inputs:file = @./t.<UDIM>.png@\n}\n',
                                     encoding="utf-8")
    stage = Usd.Stage.Open(str(tmp_path / "s.usda"))
    attribute = stage.GetPrimAtPath("/T").GetAttribute("inputs:file")
    reference = AssetResolver().Resolve(attribute, attribute.Get())
    assert reference.file == str(tmp_path / "t.<UDIM>.png")


_STANDARD, _PREVIEW, _UNKNOWN = "ND_standard_surface_surfaceshader", "UsdPreviewSurface", "ND_ours_surfaceshader"
_ARNOLD = "arnold:standard_surface"


@pytest.mark.parametrize("surfaces, drawn, told", [
    ({"mtlx": _STANDARD, "": _PREVIEW}, "mtlx", None), ({"mtlx": "ND_lama_surface", "": _PREVIEW}, "mtlx", None),
    ({"mtlx": _UNKNOWN, "": _PREVIEW}, "", "the universal surface"), ({"mtlx": "", "": _PREVIEW}, "", "the universal surface"),
    ({"kma": _STANDARD, "": _PREVIEW}, "kma", None), ({"mtlx": _STANDARD, "kma": _STANDARD}, "mtlx", None),
    ({"kma": "kma_ours", "": _PREVIEW}, "", "the universal surface"), ({"mtlx": _UNKNOWN, "kma": _STANDARD}, "kma", "the surface of kma"),
    ({"": _PREVIEW, "glslfx": _PREVIEW}, "", None), ({"": "PxrSurface", "glslfx": _PREVIEW}, "glslfx", "the surface of glslfx"),
    ({"ri": "PxrSurface", "glslfx": _PREVIEW}, "glslfx", None), ({"mtlx": _UNKNOWN, "": "PxrSurface"}, "mtlx", None),
    ({"arnold": _ARNOLD, "": _PREVIEW}, "", None), ({"arnold": _ARNOLD, "": "PxrSurface"}, "arnold", "the surface of arnold"),
    ({"arnold": _ARNOLD}, "arnold", None), ({"arnold": "arnold:two_sided", "": _PREVIEW}, "", None)])
def test_a_surface_that_is_drawn_is_preferred_to_one_that_is_not(surfaces, drawn, told):
    """Of contexts in the order of docs/materials.md."""
    outputs = "".join(f"token outputs:{f'{context}:' if context else ''}surface.connect = </M/S{context}.outputs:out>\n" for context in surfaces)
    shaders = "".join(f"""def Shader "S{context}" {{ {f'uniform token info:id = "{surface}"' if surface else ''}
        token outputs:out }}\n""" for context, surface in surfaces.items())
    session = Translate(StageOf(f"""def Material "M" {{ {outputs}{shaders} }}
    def Sphere "S" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ rel material:binding = </M> }}"""))
    assert session.Scene().materials["/M"].terminals["surface"].upstreamPath == f"/M/S{drawn}"
    lines = [line for line in session.Warnings() if "is not supported; " in line]
    assert [line.rpartition("; ")[2] for line in lines] == ([f"{told} is used"] if told else []) and all(line.startswith("/M: ") for line in lines)


_SOURCE = """uniform token info:implementationSource = "sourceAsset"
    uniform asset info:mdl:sourceAsset = @OmniPBR.mdl@
    token outputs:out\n"""


@pytest.mark.parametrize("body, expected", [
    ("token outputs:surface", ["/M: material has no surface shader; displayColor is used"]),
    ("token outputs:mtlx:surface", ["/M: material has no surface shader; displayColor is used"]),
    ("token outputs:mtlx:surface\ntoken outputs:ri:surface",
     ["/M: material has no UsdPreviewSurface or MaterialX surface, only ri: not supported yet",
      "/M: material has no surface shader; displayColor is used"]),
    (f'token outputs:surface.connect = </M/A.outputs:out>\ndef Shader "A" {{ {_SOURCE} }}',
     ["/M: surface shader /M/A, which has no shader id, is not supported; displayColor is used"]),
    (f"""token outputs:surface.connect = </M/P.outputs:surface>\ndef Shader "A" {{ {_SOURCE} }}
        def Shader "P" {{ uniform token info:id = "UsdPreviewSurface"\ncolor3f inputs:diffuseColor.connect = </M/A.outputs:out>
        token outputs:surface }}""", ["/M: shader /M/A, which has no shader id, is not supported here"]),
])
def test_what_is_not_drawn_is_told_once(body, expected):
    session = Translate(StageOf(f"""def Material "M" {{ {body} }}
    def Sphere "S" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ rel material:binding = </M> }}"""))
    session.Info()
    assert [line for line in session.Warnings() if "no lights" not in line] == expected


def test_nodes_that_ask_for_the_frame_are_told_it():
    stage = StageOf("""
def Material "Look" {
    token outputs:mtlx:surface.connect = </Look/Surface.outputs:out>
    def Shader "Surface" {
        uniform token info:id = "ND_surface_unlit"
        float inputs:emission.connect = </Look/Graph.outputs:seconds>
        token outputs:out
    }
    def NodeGraph "Graph" {
        float outputs:seconds.connect = </Look/Graph/Time.outputs:out>
        def Shader "Time" {
            uniform token info:id = "ND_time_float"
            float outputs:out
        }
    }
}
def Sphere "Ball" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </Look> }
""")
    for timeCode in (2.5, 7.0):
        assert f"node /Look/Graph/Time: ND_time_float\n    frame: {timeCode:g}\n" in Translate(stage, timeCode).Dump()
    for timeCode in (Usd.TimeCode.Default(), Usd.TimeCode.EarliestTime()):
        assert "frame:" not in Translate(stage, timeCode).Dump()
