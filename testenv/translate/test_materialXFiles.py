# SPDX-License-Identifier: Apache-2.0
"""Files of MaterialX: the network of a referenced .mtlx is that of the same nodes as prims; what cannot be read is said."""

import pytest

from hdstream import _core
from hdstream.diagnostics import Diagnostics
from hdstream.stage import OpenStage
from hdstream.translate import TranslateStage

_FILE = """<?xml version="1.0"?>
<materialx version="1.38">
  <nodegraph name="NG">
    <input name="tint" type="color3" value="0.5, 0.25, 0.125"/>
    <image name="image" type="color3">
      <input name="file" type="filename" value="wood.png" colorspace="srgb_texture"/>
    </image>
    <multiply name="product" type="color3">
      <input name="in1" type="color3" nodename="image"/>
      <input name="in2" type="color3" interfacename="tint"/>
    </multiply>
    <output name="color" type="color3" nodename="product"/>
  </nodegraph>
  <standard_surface name="Surface" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="NG" output="color"/>
    <input name="coat" type="float" value="0.5"/>
  </standard_surface>
  <surfacematerial name="Wood" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="Surface"/>
  </surfacematerial>
</materialx>
"""
_STAGE = """#usda 1.0
def "Looks" (
    references = @looks.mtlx@</MaterialX/Materials>
)
{
}
def Sphere "Ball" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    rel material:binding = </Looks/Wood>
}
"""


def _Translate(folder, text, stage=_STAGE):
    (folder / "looks.mtlx").write_text(text)
    (folder / "stage.usda").write_text(stage)
    diagnostics, session = Diagnostics(), _core.Session()
    TranslateStage(OpenStage(str(folder / "stage.usda")), session, 1.0)
    diagnostics.WarnOf(session)
    return session


def test_a_file_gives_the_network_of_its_nodes(tmp_path):
    pytest.importorskip("MaterialX")
    session = _Translate(tmp_path, _FILE)
    network = session.Scene().materials["/Looks/Wood"]
    nodes = {node.path.rpartition("/")[2]: node for node in network.nodes}
    assert {name: node.identifier for name, node in nodes.items()} == {
        "Surface": "ND_standard_surface_surfaceshader", "NG_product": "ND_multiply_color3", "NG_image": "ND_image_color3"}
    assert network.terminals["surface"].upstreamPath == "/Looks/Wood/Surface"
    assert nodes["Surface"].connections["base_color"].upstreamPath == "/Looks/Wood/NG_product"
    assert nodes["NG_product"].parameters["in2"] == [0.5, 0.25, 0.125]  # through the interface
    assert nodes["NG_image"].parameters["colorSpace:file"] == "srgb_texture"
    assert nodes["NG_image"].parameters["file"].authoredPath.endswith("wood.png")
    assert list(session.Warnings()) == []


@pytest.mark.parametrize("isReferenced", [False, True])
def test_a_file_may_be_named_by_an_expression(isReferenced, tmp_path):
    """Variables of the stage count before those of a layer that it refers to, as OpenUSD has it."""
    pytest.importorskip("MaterialX")
    named = _STAGE.replace("@looks.mtlx@", '@`"./${LIBRARY}.mtlx"`@')
    stage = named.replace("#usda 1.0", '#usda 1.0\n(\n    expressionVariables = { string LIBRARY = "looks" }\n)')
    path = "/Looks/Wood"
    if isReferenced:
        path = "/Part/Looks/Wood"
        part = stage.replace('"looks"', '"none"').replace("def ", 'def Scope "Part" {\ndef ', 1).replace("</Looks", "</Part/Looks")
        (tmp_path / "part.usda").write_text(part + "}\n")
        stage = ('#usda 1.0\n(\n    expressionVariables = { string LIBRARY = "looks" }\n)\n'
                 'def Scope "Part" (\n    references = @./part.usda@</Part>\n)\n{\n}\n')
    session = _Translate(tmp_path, _FILE, stage)
    assert session.Scene().materials[path].terminals["surface"].upstreamPath == f"{path}/Surface"
    assert list(session.Warnings()) == []


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    pytest.importorskip("MaterialX")
    warnings = list(_Translate(tmp_path, "<materialx version='1.38'><oops>").Warnings())
    assert any("looks.mtlx cannot be read" in warning for warning in warnings)


def test_an_edited_file_is_read_again(tmp_path):
    """Workers of a farm stay from job to job."""
    pytest.importorskip("MaterialX")
    for coat in ("0.5", "0.25"):
        session = _Translate(tmp_path, _FILE.replace('name="coat" type="float" value="0.5"', f'name="coat" type="float" value="{coat}"'))
        surface = next(node for node in session.Scene().materials["/Looks/Wood"].nodes if node.path.endswith("/Surface"))
        assert surface.parameters["coat"] == float(coat)


@pytest.mark.parametrize("good, bad, line", [
    ('type="color3" value="0.5, 0.25, 0.125"', 'type="color3" value="0.5, x"', 'NG/tint: "0.5, x" is no color3'),
    ('type="float" value="0.5"', 'type="integer" value="99999999999999999999"', 'Surface/coat: "99999999999999999999" is no integer'),
    ('<input name="tint" type="color3" value="0.5, 0.25, 0.125"/>', '<input name="tint" type="color3" interfacename="tint"/>', None)])
def test_broken_values_are_named_and_circles_end(good, bad, line, tmp_path):
    pytest.importorskip("MaterialX")
    assert good in _FILE
    warnings = list(_Translate(tmp_path, _FILE.replace(good, bad)).Warnings())
    assert any(line in warning and "looks.mtlx" in warning for warning in warnings) if line else not warnings, warnings


# Definitions of a file's own: "tinted" of a product and of "halved", "coated" of a surface; what is passed through
# the interfaces is a value, a connection, a default and the geometry that a default names.
_OWN = """<?xml version="1.0"?>
<materialx version="1.38">
  <nodedef name="ND_halved_color3" node="halved">
    <input name="in" type="color3" value="1, 1, 1"/>
    <input name="by" type="float" value="0.5"/>
    <output name="out" type="color3"/>
  </nodedef>
  <nodegraph name="NG_halved" nodedef="ND_halved_color3">
    <multiply name="product" type="color3">
      <input name="in1" type="color3" interfacename="in"/>
      <input name="in2" type="float" interfacename="by"/>
    </multiply>
    <output name="out" type="color3" nodename="product"/>
  </nodegraph>
  <nodedef name="ND_tinted" node="tinted">
    <input name="tint" type="color3" value="0.25, 0.5, 0.75"/>
    <input name="place" type="vector3" defaultgeomprop="Pworld"/>
    <output name="bright" type="color3"/>
    <output name="dark" type="color3"/>
  </nodedef>
  <nodegraph name="NG_tinted" nodedef="ND_tinted">
    <noise3d name="noise" type="color3">
      <input name="position" type="vector3" interfacename="place"/>
    </noise3d>
    <multiply name="product" type="color3">
      <input name="in1" type="color3" nodename="noise"/>
      <input name="in2" type="color3" interfacename="tint"/>
    </multiply>
    <halved name="half" type="color3">
      <input name="in" type="color3" nodename="product"/>
    </halved>
    <output name="bright" type="color3" nodename="product"/>
    <output name="dark" type="color3" nodename="half"/>
  </nodegraph>
  <nodedef name="ND_coated" node="coated">
    <input name="color" type="color3" value="0.5, 0.5, 0.5"/>
    <input name="strength" type="float" value="0.5"/>
    <output name="out" type="surfaceshader"/>
  </nodedef>
  <nodegraph name="NG_coated" nodedef="ND_coated">
    <standard_surface name="inner" type="surfaceshader">
      <input name="base_color" type="color3" interfacename="color"/>
      <input name="coat" type="float" interfacename="strength"/>
    </standard_surface>
    <output name="out" type="surfaceshader" nodename="inner"/>
  </nodegraph>
  <constant name="red" type="color3">
    <input name="value" type="color3" value="0.5, 0.0, 0.0"/>
  </constant>
  <tinted name="mine" type="multioutput">
    <input name="tint" type="color3" nodename="red"/>
  </tinted>
  <coated name="Surface" type="surfaceshader">
    <input name="color" type="color3" nodename="mine" output="dark"/>
  </coated>
  <surfacematerial name="Wood" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="Surface"/>
  </surfacematerial>
</materialx>
"""
_BY_HAND = """<?xml version="1.0"?>
<materialx version="1.38">
  <constant name="red" type="color3">
    <input name="value" type="color3" value="0.5, 0.0, 0.0"/>
  </constant>
  <position name="place" type="vector3"> <input name="space" type="string" value="world"/> </position>
  <noise3d name="noise" type="color3"> <input name="position" type="vector3" nodename="place"/> </noise3d>
  <multiply name="product" type="color3">
    <input name="in1" type="color3" nodename="noise"/>
    <input name="in2" type="color3" nodename="red"/>
  </multiply>
  <multiply name="half" type="color3">
    <input name="in1" type="color3" nodename="product"/>
    <input name="in2" type="float" value="0.5"/>
  </multiply>
  <standard_surface name="Surface" type="surfaceshader">
    <input name="base_color" type="color3" nodename="half"/>
    <input name="coat" type="float" value="0.5"/>
  </standard_surface>
  <surfacematerial name="Wood" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="Surface"/>
  </surfacematerial>
</materialx>
"""


def _Tree(session):
    """The network as its terminal sees it, without the names of nodes."""
    network = session.Scene().materials["/Looks/Wood"]
    nodes = {node.path: node for node in network.nodes}

    def Of(path, output):
        node = nodes[path]
        return (node.identifier, output, dict(node.parameters),
                {name: Of(one.upstreamPath, one.upstreamOutput) for name, one in node.connections.items()})

    return Of(network.terminals["surface"].upstreamPath, "")


def test_nodes_that_a_file_defines_are_the_nodes_of_their_graphs(tmp_path):
    pytest.importorskip("MaterialX")
    folders = [tmp_path / "own", tmp_path / "byHand"]
    for folder in folders:
        folder.mkdir()
    own, byHand = (_Translate(folder, text) for folder, text in zip(folders, (_OWN, _BY_HAND)))
    assert _Tree(own) == _Tree(byHand)
    assert list(own.Warnings()) == []


def test_two_calls_of_one_definition_are_apart(tmp_path):
    pytest.importorskip("MaterialX")
    second = '<tinted name="other" type="multioutput"> <input name="tint" type="color3" nodename="mine" output="dark"/> </tinted>'
    text = _OWN.replace('<coated name="Surface"', f'{second}<coated name="Surface"') \
        .replace('nodename="mine" output="dark"/>\n  </coated>', 'nodename="other" output="bright"/>\n  </coated>')
    product = _Tree(_Translate(tmp_path, text))[3]["base_color"]
    inner = product[3]["in2"]
    assert (product[0], inner[0], inner[3]["in1"][0]) == ("ND_multiply_color3", "ND_multiply_color3FA", "ND_multiply_color3")
    assert inner[3]["in1"][3]["in2"] == ("ND_constant_color3", "out", {"value": [0.5, 0.0, 0.0]}, {})


@pytest.mark.parametrize("good, bad", [
    ('<multiply name="product" type="color3">\n      <input name="in1" type="color3" interfacename="in"/>\n'
     '      <input name="in2" type="float" interfacename="by"/>\n    </multiply>',
     '<halved name="product" type="color3">\n      <input name="in" type="color3" interfacename="in"/>\n    </halved>'),
    ('<nodegraph name="NG_halved" nodedef="ND_halved_color3">', '<nodegraph name="NG_halved">')])
def test_definitions_that_call_themselves_or_have_no_graph_stay_unknown_nodes(good, bad, tmp_path):
    """The core warns of those, once a node."""
    pytest.importorskip("MaterialX")
    assert good in _OWN
    session = _Translate(tmp_path, _OWN.replace(good, bad))
    assert "ND_halved_color3" in str(_Tree(session)) and not _core.IsKnownShader("ND_halved_color3")


def _Doubling(levels):
    """A colour by a definition whose graph has two of the definition below, and so on: 2^levels nodes."""
    graphs = ['<nodedef name="ND_l0" node="l0"><output name="out" type="color3"/></nodedef> <nodegraph name="NG_l0" nodedef="ND_l0">'
              '<constant name="m" type="color3"/><output name="out" type="color3" nodename="m"/></nodegraph>']
    for i in range(1, levels + 1):
        graphs.append(f'<nodedef name="ND_l{i}" node="l{i}"><output name="out" type="color3"/></nodedef>'
                      f'<nodegraph name="NG_l{i}" nodedef="ND_l{i}"><l{i - 1} name="a" type="color3"/><l{i - 1} name="b" type="color3"/>'
                      '<add name="m" type="color3"><input name="in1" type="color3" nodename="a"/>'
                      '<input name="in2" type="color3" nodename="b"/></add><output name="out" type="color3" nodename="m"/></nodegraph>')
    color = f'<l{levels} name="top" type="color3"/>'
    text = _FILE.replace('nodegraph="NG" output="color"', 'nodename="top"')
    return text.replace('<standard_surface', "".join(graphs) + color + "<standard_surface", 1)


def test_definitions_that_multiply_without_end_are_named(tmp_path):
    pytest.importorskip("MaterialX")
    session = _Translate(tmp_path, _Doubling(6))
    assert len(session.Scene().materials["/Looks/Wood"].nodes) == 1 + 2 ** 7 - 1  # the surface, and each graph's own
    assert list(session.Warnings()) == []
    warnings = list(_Translate(tmp_path, _Doubling(40)).Warnings())
    assert any("looks.mtlx" in warning and "Wood: more than 4096 nodes" in warning for warning in warnings), warnings


def _Split(text):
    """(a file of its definitions, one of all else)"""
    begin, end = text.index("  <nodedef"), text.rindex("</nodegraph>") + len("</nodegraph>\n")
    return text[:begin] + text[begin:end] + "</materialx>\n", text[:begin] + text[end:]


def test_definitions_may_lie_in_the_folders_that_usdMtlx_searches(tmp_path, monkeypatch):
    """PXR_MTLX_PLUGIN_SEARCH_PATHS, deep folders too; files that definitions name are beside these."""
    pytest.importorskip("MaterialX")
    definitions, look = _Split(_OWN)
    picture = '<input name="tint" type="color3" value="0.25, 0.5, 0.75"/>\n    <input name="map" type="filename" value="wood.png"/>'
    noise = '<noise3d name="noise" type="color3">\n      <input name="position" type="vector3" interfacename="place"/>\n    </noise3d>'
    image = '<image name="noise" type="color3"> <input name="file" type="filename" interfacename="map"/> </image>'
    assert noise in definitions
    definitions = definitions.replace('<input name="tint" type="color3" value="0.25, 0.5, 0.75"/>', picture).replace(noise, image)
    studio = tmp_path / "studio" / "patterns"
    studio.mkdir(parents=True)
    (studio / "definitions.mtlx").write_text(definitions)
    shot = tmp_path / "shot"
    shot.mkdir()
    monkeypatch.setenv("PXR_MTLX_PLUGIN_SEARCH_PATHS", f"{tmp_path / 'none'}:{studio.parent}")
    surface = _Tree(_Translate(shot, look))
    inner = surface[3]["base_color"][3]["in1"]
    assert (surface[0], surface[3]["base_color"][0]) == ("ND_standard_surface_surfaceshader", "ND_multiply_color3FA")
    assert inner[3]["in1"][2]["file"].authoredPath == str(studio / "wood.png") and inner[3]["in2"][0] == "ND_constant_color3"
    monkeypatch.delenv("PXR_MTLX_PLUGIN_SEARCH_PATHS")
    assert _Tree(_Translate(shot, look))[0] == "ND_coated_surfaceshader"  # not known


def test_definitions_that_cannot_be_read_are_named(tmp_path, monkeypatch):
    """Once, however many files there are; they are drawn without them."""
    pytest.importorskip("MaterialX")
    definitions, look = _Split(_OWN)
    studio = tmp_path / "studio"
    studio.mkdir()
    (studio / "broken.mtlx").write_text("<materialx")
    (studio / "definitions.mtlx").write_text(definitions)
    (tmp_path / "other.mtlx").write_text(_FILE)
    monkeypatch.setenv("PXR_MTLX_PLUGIN_SEARCH_PATHS", str(studio))
    session = _Translate(tmp_path, look, _STAGE + 'def "Others" (references = @other.mtlx@</MaterialX/Materials>) {}\n')
    warnings = list(session.Warnings())
    assert len(warnings) == 1 and all(text in warnings[0] for text in (str(studio / "broken.mtlx"), "PXR_MTLX_PLUGIN_SEARCH_PATHS")), warnings
    assert _Tree(session)[3]["base_color"][0] == "ND_multiply_color3FA"


@pytest.mark.parametrize("order, factor", [(("b", "a"), 0.25), (("a", "b"), 0.5)])
def test_of_definitions_of_one_name_the_first_folder_has_the_say(order, factor, tmp_path, monkeypatch):
    pytest.importorskip("MaterialX")
    definitions, look = _Split(_OWN)
    default = '<input name="by" type="float" value="0.5"/>'
    assert default in definitions
    for folder, text in (("a", definitions), ("b", definitions.replace(default, default.replace("0.5", "0.25")))):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "definitions.mtlx").write_text(text)
    monkeypatch.setenv("PXR_MTLX_PLUGIN_SEARCH_PATHS", ":".join(str(tmp_path / folder) for folder in order))
    assert _Tree(_Translate(tmp_path, look))[3]["base_color"][2]["in2"] == factor


def _Including(*files):
    includes = "".join(f'<xi:include href="{file}"/>' for file in files)
    return f'<materialx version="1.38" xmlns:xi="http://www.w3.org/2001/XInclude">{includes}</materialx>'


def _ImageOf(session):
    return next(node for node in session.Scene().materials["/Looks/Wood"].nodes if "image" in node.identifier).parameters["file"]


@pytest.mark.parametrize("isStudio", [False, True])
def test_materials_and_images_of_included_files(isStudio, tmp_path, monkeypatch):
    """Images lie beside the file that names them, also where one that is included includes another."""
    pytest.importorskip("MaterialX")
    if isStudio:  # folders of definitions change nothing for a file that includes others, and add no materials
        (tmp_path / "studio" / "parts").mkdir(parents=True)
        (tmp_path / "studio" / "all.mtlx").write_text(_Including("parts/more.mtlx"))
        (tmp_path / "studio" / "parts" / "more.mtlx").write_text(_FILE.replace('name="Wood"', 'name="Studio"'))
        monkeypatch.setenv("PXR_MTLX_PLUGIN_SEARCH_PATHS", str(tmp_path / "studio"))
    deep = tmp_path / "sub" / "deep"
    deep.mkdir(parents=True)
    (deep / "wood.mtlx").write_text(_FILE)
    (deep / "wood.png").write_bytes(b"")
    (tmp_path / "sub" / "defs.mtlx").write_text(_Including("deep/wood.mtlx"))
    for href in ("sub/deep/wood.mtlx", "sub/defs.mtlx"):
        session = _Translate(tmp_path, _Including(href))
        stage = OpenStage(str(tmp_path / "stage.usda"))
        assert [prim.GetName() for prim in stage.GetPrimAtPath("/Looks").GetChildren()] == ["Wood"]
        assert (_ImageOf(session).authoredPath, list(session.Warnings())) == (str(deep / "wood.png"), [])


@pytest.mark.parametrize("href", ["graphs.mtlx", "sub/graphs.mtlx"])
def test_images_of_files_that_definitions_include(href, tmp_path, monkeypatch):
    pytest.importorskip("MaterialX")
    definitions, look = _Split(_OWN)
    picture = '<image name="noise" type="color3"> <input name="file" type="filename" value="wood.png"/> </image>'
    begin, end = definitions.index("<noise3d"), definitions.index("</noise3d>") + len("</noise3d>")
    file = tmp_path / "studio" / href
    file.parent.mkdir(parents=True)
    file.write_text(definitions[:begin] + picture + definitions[end:])
    (tmp_path / "studio" / "all.mtlx").write_text(_Including(href))
    (tmp_path / "shot").mkdir()
    monkeypatch.setenv("PXR_MTLX_PLUGIN_SEARCH_PATHS", str(tmp_path / "studio"))
    session = _Translate(tmp_path / "shot", look)
    assert _ImageOf(session).authoredPath == str(file.parent / "wood.png")


@pytest.mark.parametrize("text, line", [(None, "sub/defs.mtlx"), ("<materialx", "sub/defs.mtlx"), (_Including("../looks.mtlx"), "cycle")])
def test_included_files_that_cannot_be_read_are_named(text, line, tmp_path):
    pytest.importorskip("MaterialX")
    (tmp_path / "sub").mkdir()
    if text is not None:
        (tmp_path / "sub" / "defs.mtlx").write_text(text)
    warnings = list(_Translate(tmp_path, _Including("sub/defs.mtlx")).Warnings())
    assert any("looks.mtlx cannot be read" in warning and line in warning for warning in warnings), warnings


_MATRICES = """<?xml version="1.0"?>
<materialx version="1.38">
  <position name="place" type="vector3"/>
  <transformmatrix name="wide" type="vector3">
    <input name="in" type="vector3" nodename="place"/>
    <input name="mat" type="matrix44" value="2, 0, 0, 0,  0, 3, 0, 0,  0, 0, 4, 0,  5, 6, 7, 1"/>
  </transformmatrix>
  <transformmatrix name="turned" type="vector3">
    <input name="in" type="vector3" nodename="wide"/>
    <input name="mat" type="matrix33" value="1, 2, 3, 4, 5, 6, 7, 8, 9"/>
  </transformmatrix>
  <convert name="color" type="color3"><input name="in" type="vector3" nodename="turned"/></convert>
  <standard_surface name="Surface" type="surfaceshader">
    <input name="base_color" type="color3" nodename="color"/>
  </standard_surface>
  <surfacematerial name="Wood" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="Surface"/>
  </surfacematerial>
</materialx>
"""


def test_matrices_are_those_of_prims_with_the_same_values(tmp_path):
    """The oracle is UsdShade: an input of a shader prim of type matrix4d or matrix3d, whose rows USD writes in brackets."""
    pytest.importorskip("MaterialX")
    session = _Translate(tmp_path, _MATRICES)
    found = {node.path.rpartition("/")[2]: node.parameters.get("mat") for node in session.Scene().materials["/Looks/Wood"].nodes}
    stage = """#usda 1.0
def Material "Looks" {
    token outputs:mtlx:surface.connect = </Looks/Surface.outputs:out>
    def Shader "Surface" { uniform token info:id = "ND_standard_surface_surfaceshader"
        color3f inputs:base_color.connect = </Looks/color.outputs:out>
        token outputs:out }
    def Shader "color" { uniform token info:id = "ND_convert_vector3_color3"
        vector3f inputs:in.connect = </Looks/turned.outputs:out>
        color3f outputs:out }
    def Shader "turned" { uniform token info:id = "ND_transformmatrix_vector3"
        vector3f inputs:in.connect = </Looks/wide.outputs:out>
        matrix3d inputs:mat = ((1, 2, 3), (4, 5, 6), (7, 8, 9))
        vector3f outputs:out }
    def Shader "wide" { uniform token info:id = "ND_transformmatrix_vector3M4"
        matrix4d inputs:mat = ((2, 0, 0, 0), (0, 3, 0, 0), (0, 0, 4, 0), (5, 6, 7, 1))
        vector3f outputs:out }
}
def Sphere "Ball" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </Looks> }
""".replace("}", "\n}\n")
    reference = _Translate(tmp_path, _MATRICES, stage)
    expected = {node.path.rpartition("/")[2]: node.parameters.get("mat") for node in reference.Scene().materials["/Looks"].nodes}
    assert found["wide"] == expected["wide"] is not None and found["turned"] == expected["turned"] is not None
    assert not session.Warnings()


def test_matrices_that_are_none_and_inputs_of_other_types_are_named(tmp_path):
    pytest.importorskip("MaterialX")
    for value in ("1, 2, 3", "2", "1, 2, 3, 4, 5, 6, 7, 8, x"):
        warnings = list(_Translate(tmp_path, _MATRICES.replace("1, 2, 3, 4, 5, 6, 7, 8, 9", value)).Warnings())
        assert any(f'turned/mat: "{value}" is no matrix33' in warning for warning in warnings), warnings
    odd = '<input name="list" type="floatarray" value="1, 2"/><input name="base_color"'
    warnings = list(_Translate(tmp_path, _MATRICES.replace('<input name="base_color"', odd)).Warnings())
    assert [warning for warning in warnings if "looks.mtlx has Surface/list of the type floatarray, which is not read" in warning]
    assert len(warnings) == 1
