"""Plugins are found by entry points; what is wrong with one is said, and hides no other."""

import math
import re
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from shutil import copytree

import pytest
from golden import Golden

import nrp_core
from nrp_core.brain import backends
from nrp_core.brain.backend import BrainBackend
from nrp_core.brain.backends import BRAIN_GROUP, brains
from nrp_core.errors import (
    BackendLoadError,
    DuplicateBackendError,
    IncompatibleBackendError,
    UnknownBackendError,
)
from nrp_core.network.files.script import load_network
from nrp_core.registry import OPTIONAL, Registry
from nrp_core.world.backends import worlds

Install = Callable[..., None]

GOOD = """
from nrp_core.brain.backend import BrainBackend
class Backend(BrainBackend):
    def capabilities(self, options): return None
    def open(self, network, *, seed, options): return None
"""


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Put a distribution with one brain backend on the path, as pip would leave it."""
    monkeypatch.syspath_prepend(tmp_path)

    def add(
        name: str, source: str = GOOD, distribution: str = "acme-brain", module: str | None = None
    ) -> None:
        module = module or f"acme_{distribution.replace('-', '_')}_{name}"
        (tmp_path / f"{module}.py").write_text(source)
        info = tmp_path / f"{distribution}-2.0.dist-info"
        info.mkdir(exist_ok=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 2.0\n")
        entries = info / "entry_points.txt"
        text = entries.read_text() if entries.exists() else f"[{BRAIN_GROUP}]\n"
        entries.write_text(f"{text}{name} = {module}:Backend\n")

    return add


def test_our_own_plugins_are_registered_as_those_of_a_third_party() -> None:
    assert {"event", "spinnaker"} <= set(brains().names())
    assert {"mujoco", "pybullet"} <= set(worlds().names())
    assert all(provider.distribution in ("nrp-core", *OPTIONAL) for provider in brains().providers())


def test_an_installed_backend_is_found_at_once_and_made(install: Install) -> None:
    install("acme")
    assert isinstance(brains().load("acme"), BrainBackend)
    assert str(brains().provider("acme")).startswith("acme-brain 2.0 (acme_")


@pytest.mark.skipif(find_spec("nrp_brain_brian2") is not None, reason="the plugin is installed")
def test_a_script_of_brian2_names_the_plugin_that_is_missing(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text("\nfrom brian2 import *\n")
    with pytest.raises(UnknownBackendError, match=r"script\.py:2: .*nrp-brain-brian2"):
        load_network(tmp_path / "script.py")


def test_leftovers_of_an_interrupted_pip_do_no_harm(install: Install, tmp_path: Path) -> None:
    install("acme")
    copytree(tmp_path / "acme-brain-2.0.dist-info", tmp_path / "~cme-brain-2.0.dist-info")
    assert isinstance(brains().load("acme"), BrainBackend)


def test_a_typo_gets_the_nearest_name(golden: Golden) -> None:
    with golden.raises(UnknownBackendError, match="'evnt'.*'event'"):
        brains().load("evnt")


def test_an_empty_group_names_the_package_to_install(golden: Golden) -> None:
    with golden.raises(UnknownBackendError):
        Registry("nobody.has.this", "brain backend", interface_version=1).load("event")


def test_a_broken_plugin_is_named_with_its_cause_and_the_others_are_listed(install: Install) -> None:
    install("good")
    install("broken", "import does_not_exist", distribution="sad-brain")
    with pytest.raises(BackendLoadError) as error:
        brains().load("broken")
    for part in ("'broken'", "sad-brain 2.0", "No module named 'does_not_exist'", "pip install"):
        assert part in str(error.value)
    assert brains().load("good")


@pytest.mark.parametrize(
    ("source", "message", "line"),
    [
        ("x = 1\ndef f(:\n", "SyntaxError: invalid syntax", 2),
        ("x = 1\n\nx = undefined\n", "NameError: name 'undefined' is not defined", 3),
    ],
)
def test_a_mistake_in_a_plugin_is_named_with_its_line_and_not_with_a_command(
    install: Install, tmp_path: Path, source: str, message: str, line: int
) -> None:
    install("wrong", source, module="my_backend_with_a_mistake")
    with pytest.raises(BackendLoadError) as error:
        brains().load("wrong")
    assert str(error.value).endswith(f"{message}, at {tmp_path / 'my_backend_with_a_mistake.py'}:{line}")
    assert "pip" not in str(error.value)


def test_two_distributions_with_one_name_are_both_named_and_only_that_name_is_refused(
    install: Install,
    golden: Golden,
) -> None:
    install("twin", distribution="first-brain")
    install("twin", distribution="second-brain")
    install("single")
    with golden.raises(DuplicateBackendError, match=r"2\.0.*2\.0"):
        brains().load("twin")
    assert brains().load("single")


@pytest.mark.parametrize(("version", "what"), [(0, "acme-brain"), (99, "nrp-core")])
def test_another_interface_version_says_which_side_to_upgrade(
    install: Install, version: int, what: str
) -> None:
    install(f"v{version}", GOOD + f"    interface_version = {version}\n")
    with pytest.raises(IncompatibleBackendError, match=f"interface version {version}.*--upgrade {what}"):
        brains().load(f"v{version}")


def test_a_backend_that_does_not_say_was_written_for_the_first_version_of_the_interface(
    install: Install, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    install("old")
    assert brains().load("old").interface_version == 1
    monkeypatch.setattr(backends, "BRAIN_INTERFACE_VERSION", 2)
    with golden.raises(IncompatibleBackendError, match="--upgrade"):
        brains().load("old")


def test_an_object_that_is_not_a_backend_is_refused(install: Install, golden: Golden) -> None:
    install("odd", "Backend = 42")
    with golden.raises(BackendLoadError, match="BrainBackend"):
        brains().load("odd")


def test_a_class_of_a_group_with_several_bases_names_them_all(install: Install, golden: Golden) -> None:
    install("odd", "class Backend: pass")
    with golden.raises(BackendLoadError):
        Registry[object](BRAIN_GROUP, "thing", [int, str]).load("odd")


def test_all_plugins_of_a_group_are_loaded_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    info = tmp_path / "colors-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: colors\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[acme.colors]\nred = math:pi\nblue = math:e\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert Registry[float]("acme.colors", "color").load_all() == {"blue": math.e, "red": math.pi}


def test_every_group_of_entry_points_is_read_by_the_registry() -> None:
    root = Path(nrp_core.__file__).parent
    readers = {
        str(path.relative_to(root))
        for path in root.rglob("*.py")
        if re.search(r"(?<!_support)\.entry_points\b|entry_points\(", path.read_text())
    }
    assert readers <= {"_support/packages.py", "_support/driver.py"}
    assert "_support/packages.py" in readers
