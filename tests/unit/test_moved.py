"""Names of modules of version 0.3."""

import subprocess
import sys

import pytest

import nrp_core.world

SCRIPT = """
import warnings
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    from nrp_core.brain.files.script import load_network
    from nrp_core.brain.network.data import Population
    from nrp_core.world import messages, rigid
    from nrp_core.world.scene.sdf import read_model
import nrp_core.messages, nrp_core.network.data, nrp_core.network.files.script
import nrp_core.scene.rigid, nrp_core.scene.sdf
assert Population is nrp_core.network.data.Population
assert messages is nrp_core.messages and rigid is nrp_core.scene.rigid
assert load_network is nrp_core.network.files.script.load_network
assert read_model is nrp_core.scene.sdf.read_model
print([(warning.category.__name__, warning.filename) for warning in caught])
"""


def test_modules_are_found_by_their_names_of_0_3_with_one_warning_at_the_import() -> None:
    run = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[('DeprecationWarning', '<string>')]"


@pytest.mark.parametrize("name", ["nrp_core.world.scenes", "nrp_core.world.scene.absent", "nrp_core.absent"])
def test_a_module_that_never_was_is_not_found(name: str) -> None:
    run = subprocess.run(
        [sys.executable, "-c", f"import {name}"], capture_output=True, text=True, check=False
    )
    assert "ModuleNotFoundError" in run.stderr


def test_a_class_that_became_a_part_of_another_is_found_by_its_old_name_with_a_warning() -> None:
    with pytest.warns(DeprecationWarning, match="nrp_core.world.LiveScene is World since 0.4"):
        assert nrp_core.world.LiveScene is nrp_core.world.World
