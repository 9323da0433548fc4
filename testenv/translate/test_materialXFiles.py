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


def _Translate(folder, text):
    (folder / "looks.mtlx").write_text(text)
    (folder / "stage.usda").write_text(_STAGE)
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
