"""The entry points: cheap to import, strict in their options, clear in their errors."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys

import pytest
from golden import Golden
from pydantic import ValidationError

from nrp_core.errors import BackendLoadError, SceneError
from nrp_core.scene.model import Box, Mesh
from nrp_core.simulation import Determinism


def engine_of(backend) -> str:
    return type(backend).__module__.split(".")[0].removeprefix("nrp_world_")


def run_python(script: str, **environment: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr


def test_capabilities_are_reported_without_the_engine(backend):
    run_python(f"""
import sys
from nrp_core.world.backends import worlds
backend = worlds().load("{engine_of(backend)}")
capabilities = backend.capabilities(backend.options(timestep="4 ms", renderer="raster"))
assert capabilities.step_ns == 4_000_000 and capabilities.snapshot
assert capabilities.renderers == ("raster",)
assert not {{"mujoco", "pybullet", "OpenGL", "numba"}} & set(sys.modules)
""")


def test_the_shared_renderer_is_preferred_where_none_is_named(backend):
    capabilities = backend.capabilities(backend.options())
    assert capabilities.renderers[0] == "raster"
    assert capabilities.determinism is Determinism.MACHINE


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"renderr": "raster"}, "renderr"),
        ({"renderer": "gls"}, "raster"),
        ({"timestep": 2}, ""),
        ({"timestep": "0 ms"}, "more than 0"),
        ({"image_scale": 0}, "0.01"),
        ({"image_scale": 1.5}, ""),
    ],
)
def test_a_wrong_option_is_refused(backend, options, message, golden: Golden):
    with golden.raises(ValidationError, match=message):
        backend.options(**options)


def test_an_engine_that_does_not_import_is_a_clear_error(backend, parts, monkeypatch, golden: Golden):
    monkeypatch.setitem(sys.modules, f"{type(backend).__module__.split('.')[0]}.engine", None)
    from nrp_core.scene.model import Scene

    with golden.raises(BackendLoadError):
        backend.open(Scene((parts.floor(),)), seed=1, options=backend.options())


@pytest.mark.parametrize("renderer", ["auto", "raster"])
@pytest.mark.parametrize("content", ["v 0 0 0\nv 1 0 0\nf 1 2 7\n", "nonsense\n"])
def test_a_broken_mesh_is_refused(open_world, parts, tmp_path, renderer, content):
    path = tmp_path / "broken.obj"
    path.write_text(content)
    prop = parts.prop("thing", Mesh(path), solid=False)
    with pytest.raises(SceneError, match=r"broken\.obj"):
        open_world(prop, parts.husky(), renderer=renderer)


def test_a_machine_is_diagnosed(backend):
    for diagnosis in backend.diagnose():
        assert diagnosis.subject
        assert diagnosis.meaning
        assert diagnosis.present or diagnosis.remedy


def test_the_diagnosis_names_the_renderers(backend):
    renderers = next(d for d in backend.diagnose() if d.subject == "renderers of cameras")
    for renderer in backend.capabilities(backend.options()).renderers:
        assert renderer in renderers.meaning


@pytest.mark.parametrize("library", ["egl", "osmesa", "disable"])
def test_mujoco_opens_whatever_its_variable_says(library):
    if importlib.util.find_spec("mujoco") is None:
        pytest.skip("mujoco is not installed")
    run_python(
        f"""
import os
from nrp_world_mujoco.library import mujoco
assert mujoco.MjSpec().compile().nq == 0
assert os.environ["MUJOCO_GL"] == "{library}"
""",
        MUJOCO_GL=library,
    )


def test_worlds_are_opened_and_closed_again_and_again(open_world, parts):
    for _ in range(30):
        world = open_world(parts.floor(), parts.prop("box", Box((1, 1, 1)), mass=1.0))
        world.run_until(20_000_000)
        assert world.now_ns == 20_000_000
        world.close()
