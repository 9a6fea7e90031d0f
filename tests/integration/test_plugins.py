"""The plugins that live beside the core keep the rules of a third party."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from nrp_core.registry import OPTIONAL

ROOT = Path(__file__).parents[2]
SIMULATORS = {
    "nest",
    "neuron",
    "brian2",
    "spynnaker",
    "pyNN.nest",
    "pyNN.neuron",
    "pyNN.brian2",
    "pyNN.spiNNaker",
}
PLUGINS = sorted((ROOT / "plugins").glob("*/pyproject.toml"), key=str)


def _entry_points(path):
    project = tomllib.loads(path.read_text())["project"]
    groups = project["entry-points"]
    return project["name"], {name: target for group in groups.values() for name, target in group.items()}


@pytest.fixture(params=PLUGINS, ids=lambda path: path.parent.name)
def plugin(request):
    return request.param


def test_a_plugin_is_named_after_its_folder_and_depends_on_the_core(plugin):
    project = tomllib.loads(plugin.read_text())["project"]
    assert project["name"] == plugin.parent.name
    if "entry-points" in project:  # others are programs that share no code with the core
        assert any(line.startswith("nrp-core") for line in project["dependencies"])
    assert (plugin.parent / "README.md").read_text().startswith(f"# {project['name']}")


@pytest.mark.parametrize("name", ["nrp-brain-brian2", "nrp-brain-nest", "nrp-brain-pynn"])
def test_reading_the_capabilities_of_a_plugin_does_not_load_a_simulator(name):
    plugin = ROOT / "plugins" / name
    groups = tomllib.loads((plugin / "pyproject.toml").read_text())["project"]["entry-points"]
    (target,) = groups["nrp_core.brain"].values()
    module, _, attribute = target.partition(":")
    script = f"""
import sys
sys.path.insert(0, {str(plugin / "src")!r})
import {module}
backend = {module}.{attribute}()
assert backend.capabilities(backend.options()).cells
backend.diagnose()
print(*sorted({SIMULATORS!r} & set(sys.modules)))
"""
    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert found.stdout.split() == []


@pytest.mark.parametrize("name", OPTIONAL)
def test_a_distribution_that_messages_name_has_the_plugins_that_they_promise(name):
    groups = tomllib.loads((ROOT / "plugins" / name / "pyproject.toml").read_text())["project"][
        "entry-points"
    ]
    for group, names in OPTIONAL[name].items():
        assert set(names) <= groups[group].keys()


def test_plugins_that_need_no_other_simulator_come_with_nrp_core_all():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    simulators = {name for name in OPTIONAL if name.startswith(("nrp-brain", "nrp-world"))}
    assert set(OPTIONAL) - simulators | {"nrp-brain-composite"} == {
        name for name in extras["all"] if "[" not in name
    }


def test_every_backend_and_command_beside_the_core_is_known_by_name():
    for path in PLUGINS:
        groups = tomllib.loads(path.read_text())["project"].get("entry-points", {})
        for group in ("nrp_core.brain", "nrp_core.world", "nrp_core.commands"):
            known = OPTIONAL.get(path.parent.name, {}).get(group, ())
            assert path.parent.name.endswith("-minimal") or set(known) == set(groups.get(group, ()))
