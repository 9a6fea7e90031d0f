"""The experiment of the how-to page: two spiking cells balance a pole; mistakes in it are found before."""

import re
from pathlib import Path

import pytest

from nrp_core import InvalidExperimentError, Run, load_experiment, run
from nrp_core.checks.validate import validate_file
from nrp_core.findings import Code, Level

PLUGIN = Path(__file__).parents[1]
PAGE = PLUGIN.parents[1] / "docs" / "howto" / "drive-a-gymnasium-environment.md"
FILE = re.compile(r"^```\w+\n# (cart_pole/[\w.]+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture
def cart_pole(installed, tmp_path):
    """The experiment."""
    for name, text in FILE.findall(PAGE.read_text()):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path / "cart_pole" / "experiment.yaml"


def test_two_spiking_cells_balance_the_pole_of_the_page(cart_pole):
    with Run(load_experiment(cart_pole)) as simulation:
        simulation.run()
        assert simulation.result().passed
        total = simulation.world.engine.episodes.total
    assert total == 500, "every step of the episode is rewarded"


def test_the_step_of_an_environment_differs_from_a_step_of_physics(cart_pole):
    assert [str(one) for one in validate_file(cart_pole) if one.level is Level.WARNING] == []


def test_without_its_brain_the_pole_falls(cart_pole):
    assert not run(cart_pole, ["brain.interventions=[{silence: pushers}]"], until_s=2.0).passed


@pytest.mark.parametrize(
    ("overrides", "code", "message"),
    [
        (["world.options.env=CartPol-v1"], Code.NRP202, "Did you mean: `CartPole`"),
        (["criteria.balances.topic_stays.name=/env/terminatd"], Code.NRP212, "/env/terminated"),
        (["world.options.timestep=30 ms"], Code.NRP372, "30 ms"),
        (["world.options.envs=CartPole-v1"], Code.NRP202, "did you mean 'env'"),
        (["world.backend=mujoco", "world.options=null"], Code.NRP201, "'world' needs the key 'scene'"),
    ],
)
def test_a_mistake_is_found_before_the_run(cart_pole, overrides, code, message):
    with pytest.raises(InvalidExperimentError) as caught:
        run(cart_pole, overrides)
    (finding,) = (each for each in caught.value.findings if each.level is Level.ERROR)
    assert finding.code is code
    assert message in finding.message
