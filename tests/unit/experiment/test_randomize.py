"""Ranges of ``world.randomize`` in an experiment file, and the numbers that are drawn from them."""

from pathlib import Path

import numpy as np
import pytest

from nrp_core.experiment.making.prepare import prepare
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.findings import Code, InvalidExperimentError
from nrp_core.scene.devices import JointController, Noise, Pid, TrajectoryController
from nrp_core.scene.model import Inertial, Joint, Light, Link, Model, Scene
from nrp_core.scene.randomization import Distribution, Randomization
from nrp_core.seeds import Seeds
from nrp_core.world.domain_randomization import draw_scene
from nrp_core.world.sensors.laser import Laser


def robot() -> Scene:
    """Return two links with a laser on one, a joint with two controllers, and a light."""
    laser = Laser("laser", "/scan", 10.0, noise=Noise(0.0, 0.5))
    links = (Link("base", inertial=Inertial(4.0), sensors=(laser,)), Link("arm", inertial=Inertial(2.0)))
    single = JointController("elbow", "position", "/elbow", Pid(10.0, 1.0, 2.0, i_limit=3.0))
    leader = TrajectoryController("leader", "/lead", ("elbow",), (("elbow", Pid(4.0)),))
    joint = Joint("elbow", "revolute", "base", "arm")
    model = Model("r", links, (joint,), controllers=(single,), trajectory_controllers=(leader,))
    return Scene((model,), (Light("sun", diffuse=(0.5, 0.4, 0.2, 1.0)),))


def drawn(*ranges: Randomization, seed: int = 1) -> tuple[Scene, dict[str, tuple[float, ...]]]:
    """Return the scene of a seed, and the drawn numbers by part."""
    scene, draws = draw_scene(Scene(robot().models, robot().lights, randomize=ranges), seed)
    return scene, {each.part: each.values for each in draws}


@pytest.mark.parametrize(
    ("distribution", "mean", "deviation"),
    [
        ("uniform", 2.5, 3 / np.sqrt(12)),
        ("log_uniform", 3 / np.log(4), np.sqrt(7.5 / np.log(4) - (3 / np.log(4)) ** 2)),
        ("normal", 2.5, 0.75 * np.sqrt(1 - 2 * 2 * 0.05399096651318806 / 0.9544997361036416)),
    ],
)
def test_numbers_have_the_moments_of_their_distribution(
    distribution: Distribution, mean: float, deviation: float
) -> None:
    """Those of a normal distribution that is cut off at two standard deviations, and of the others."""
    numbers = Randomization("mass", ".*", "range", 1.0, 4.0, distribution).sample(
        Seeds(3).stream("x"), 40_000
    )
    assert numbers.min() >= 1.0
    assert numbers.max() <= 4.0
    assert numbers.mean() == pytest.approx(mean, rel=0.01)
    assert numbers.std() == pytest.approx(deviation, rel=0.01)


def test_inertia_and_all_gains_change_with_what_is_drawn() -> None:
    scene, numbers = drawn(
        Randomization("mass", "r/base", "add", 1.0, 3.0),
        Randomization("gains", "r/elbow", "scale", 0.5, 2.0),
    )
    base, arm = scene.models[0].links
    heavier = 4.0 + numbers["r/base"][0]
    assert base.inertial == Inertial(heavier, inertia=(heavier / 4,) * 3 + (0.0,) * 3)
    assert arm == robot().models[0].links[1]
    p, i, d = numbers["r/elbow"]
    assert scene.models[0].controllers[0].gains == Pid(10 * p, i, 2 * d, i_limit=3.0)
    assert scene.models[0].trajectory_controllers[0].gains == (("elbow", Pid(4 * p)),)


def test_light_noise_and_bias_change() -> None:
    scene, numbers = drawn(
        Randomization("light", "sun", "scale", 0.5, 2.0),
        Randomization("sensor_bias", "r/base/laser", "range", -1.0, 1.0),
    )
    factor = numbers["sun"][0]
    assert scene.lights[0].diffuse == (0.5 * factor, 0.4 * factor, 0.2 * factor, 1.0)
    assert scene.models[0].links[0].sensors[0].noise == Noise(numbers["r/base/laser"][0], 0.5)


def test_a_number_depends_on_seed_and_part_alone() -> None:
    base = Randomization("mass", "r/base", "scale", 0.5, 2.0)
    _, alone = drawn(base)
    _, beside = drawn(
        Randomization("mass", "r/(base|arm)", "scale", 0.5, 2.0), Randomization("light", ".*", "scale", 0, 1)
    )
    assert alone["r/base"] == beside["r/base"] != beside["r/arm"]
    assert drawn(base, seed=2)[1] != alone
    _, together = drawn(Randomization("mass", ".*", "scale", 0.5, 2.0, shared=True))
    assert together["r/base"] == together["r/arm"]


def test_a_scene_without_ranges_is_itself() -> None:
    scene = robot()
    assert draw_scene(scene, 1)[0] is scene


@pytest.mark.usefixtures("fakes")
@pytest.mark.parametrize(
    ("written", "code", "expected"),
    [
        ("mass: {husky/bse_link: {scale: 0.9..1.1}}", Code.NRP202, "husky/base_link"),
        ("mass: {husky/base_link: {scale: 1.1..0.9}}", Code.NRP202, "1.1..0.9"),
        ("mass: {husky/base_link: {scale: 0..2}}", Code.NRP202, "more than 0"),
        ("mass: {husky/base_link: {add: -500..1 kg}}", Code.NRP202, "more than 0"),
        ("mass: {husky/base_link: {add: 0..1 cm}}", Code.NRP202, "kg"),
        ("mass: {husky/base_link: {scale: 1..2 kg}}", Code.NRP202, "without a unit"),
        ("mass: {husky/base_link: {scale: 1..2, add: 1..2}}", Code.NRP202, "exactly one"),
        ("mass: {husky/base_link: {scale: 1..2}, husky/.*: {scale: 1..2}}", Code.NRP202, "two patterns"),
        ("mass: {'husky/(': {scale: 1..2}}", Code.NRP202, "regular expression"),
        ("mass: {husky/base_link: {add: -1..1, distribution: log_uniform}}", Code.NRP202, "above 0"),
        ("mass: {husky/base_link: {scale: 1..2, distribution: gauss}}", Code.NRP202, "log_uniform"),
        ("light: {.*: {add: 1..2}}", Code.NRP202, "'scale'"),
        ("gains: {.*: {scale: 1..2}}", Code.NRP202, "there is none"),
        ("weight: {husky/base_link: {scale: 0.9..1.1}}", Code.NRP201, "weight"),
    ],
)
def test_a_mistake_is_one_error_with_its_line(
    drive_to_the_wall: Path, tmp_path: Path, written: str, code: Code, expected: str
) -> None:
    path = tmp_path / "drawn.yaml"
    path.write_text(f"extends: {drive_to_the_wall}/experiment.yaml\nworld:\n  randomize:\n    {written}\n")
    with pytest.raises(InvalidExperimentError) as raised:
        prepare(load_experiment(path))
    (finding,) = [each for each in raised.value.findings if each.level == "error"]
    assert (finding.code, finding.path, finding.line) == (code, path, 4)
    assert expected in finding.message
