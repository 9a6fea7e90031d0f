"""Engines get the source of each model and the elements that are meant for them; digests exclude sources."""

from dataclasses import replace

from nrp_core.dsl.testing import MockEngine
from nrp_core.scene.model import Box, Collision, Link, Model, Plane, Scene
from nrp_core.scene.origin import Native
from nrp_core.scene.sdf import read_model

LINK = '<link name="base"><inertial><mass>1</mass></inertial></link>'
BODY = f"""<model name="tram" xmlns:mujoco="urn:mujoco" xmlns:gz="urn:gz">{LINK}
<mujoco:option cone="pyramidal"><flag>warmstart</flag></mujoco:option>
<gz:note>no engine is called so</gz:note></model>"""


def test_the_engine_gets_the_file_and_the_element_of_each_model(write):
    file = write(BODY)
    engine = MockEngine(Scene((read_model(file, name="car"),)))
    source = engine.scene.model("car").source
    assert (source.file, source.element, source.line) == (file, "tram", source.line)
    assert '<model name="tram"' in file.read_text().splitlines()[source.line - 1]


def test_elements_of_an_engines_namespace_reach_it_as_they_stand(write):
    engine = MockEngine(Scene((read_model(write(BODY)),)))
    (option,) = engine.scene.models[0].native
    flag = Native("", "flag", text="warmstart")
    assert option == Native("mujoco", "option", (("cone", "pyramidal"),), children=(flag,))


def test_native_elements_count_in_digests_and_sources_do_not(write):
    scene = Scene((read_model(write(BODY)),))
    (model,) = scene.models
    assert Scene((replace(model, source=None),)).digest == scene.digest
    assert Scene((replace(model, native=()),)).digest != scene.digest


def test_shapes_of_equal_sizes_but_other_kinds_have_other_digests():
    def digest(shape):
        return Scene((Model("m", (Link("l", collisions=(Collision("c", shape),)),), static=True),)).digest

    class Renamed(Box):
        """A class of another name, with the same tag."""

    assert digest(Plane((1.0, 1.0))) != digest(Box((1.0, 1.0, 1.0)))
    assert digest(Renamed((1.0, 1.0, 1.0))) == digest(Box((1.0, 1.0, 1.0)))
