"""``nrp benchmark learning``: tasks, baselines, and learners by name and by file."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_lab.learning import TASKS, Trial, find_learner, perform
from nrp_lab.learning.ladder import BASELINES, Ladder, Standing
from nrp_lab.learning.learner import LEARNERS, read_learner

from nrp_core import InvalidExperimentError
from nrp_core.errors import ExperimentError

RSTDP = find_learner("rstdp")

CONSTANT = """
import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Int32

nrp.parameter("observed", 2)
nrp.parameter("actions", 2)


@nrp.Neuron2Robot(nrp.Topic("/task/action", Int32))
def choose(t):
    return Int32(0)
"""

CHEAT = """
import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Int32

nrp.parameter("observed", 2)
nrp.parameter("actions", 2)


@nrp.MapWeights("w", nrp.brain.projection("policy"))
@nrp.Robot2Neuron()
def change(t, w):
    w.values += 1e-6


@nrp.Neuron2Robot(nrp.Topic("/task/action", Int32))
def choose(t):
    return Int32(0)
"""


def scores(outcomes: list[Any]) -> dict[str, float]:
    return {one.condition: one.score for one in outcomes}


def own(folder: Path, functions: str) -> Path:
    """Return the file of a learner with the brain that ships and other functions."""
    (folder / "own.py").write_text(functions)
    path = folder / "learner.yaml"
    path.write_text(f"model: {RSTDP.parent / 'brain.py'}\ntransfer_functions: [own.py]\n")
    return path


HEAVY = [name if name in ("maze", "pole") else pytest.param(name, marks=pytest.mark.heavy) for name in TASKS]


@pytest.mark.one_of(6)
@pytest.mark.parametrize("world", ["mujoco", "pybullet"])
@pytest.mark.parametrize("name", HEAVY)
def test_a_known_controller_solves_a_task_that_chance_does_not(name: str, world: str) -> None:
    found = scores(perform(Trial(name, RSTDP, 1, world=world), ("random", "controller")))
    assert found["controller"] > 0.75, found
    assert found["random"] < 0.7 * found["controller"], found


@pytest.mark.heavy
def test_networks_learn_a_maze_and_a_pole_from_rewards_alone() -> None:
    maze = scores(perform(Trial("maze", RSTDP, 1), ("learned", "unlearned", "random")))
    assert maze["learned"] > 0.9 > max(maze["unlearned"], maze["random"])
    pole = scores(perform(Trial("pole", RSTDP, 1), ("learned", "unlearned", "random")))
    assert pole["learned"] > 0.7 > 0.2 > max(pole["unlearned"], pole["random"])


@pytest.mark.heavy
@pytest.mark.parametrize("name", TASKS)
def test_every_task_is_learned_from_rewards_alone(name: str) -> None:
    for seed in (1, 2, 3):
        found = scores(perform(Trial(name, RSTDP, seed)))
        assert found["learned"] > max(found[baseline] for baseline in BASELINES), (seed, found)


def test_a_trial_is_repeated_bit_by_bit() -> None:
    trial = Trial("pole", RSTDP, 3, training=60)
    one, other = (perform(trial, ("learned", "shuffled")) for _ in range(2))
    assert [each.episodes for each in one] == [each.episodes for each in other]
    assert one[0].rewards == other[0].rewards


def test_training_lasts_for_its_steps_and_the_test_is_the_same_for_all(tmp_path: Path) -> None:
    learned, random = perform(Trial("pole", own(tmp_path, CONSTANT), 1, training=100), ("learned", "random"))
    trained = [one.steps for one in learned.episodes if one.trains]
    assert sum(trained[:-1]) < 100 <= sum(trained) == len(learned.rewards)
    assert not any(one.trains for one in random.episodes)
    for outcome in (learned, random):
        assert sum(not one.trains for one in outcome.episodes) == TASKS["pole"].tests


def test_shuffled_rewards_are_those_of_the_learner_in_another_order(tmp_path: Path) -> None:
    path = own(tmp_path, CONSTANT + TELLING)
    learned, _ = perform(Trial("pole", path, 1, training=100), ("learned", "shuffled"))
    heard = [float(line) for line in (tmp_path / "heard.txt").read_text().split()]
    assert set(heard) == set(learned.rewards) == {0.0, -1.0}


TELLING = """
from pathlib import Path
from std_msgs.msg import Bool, Float64

HEARD = Path(__file__).with_name("heard.txt")


@nrp.MapRobotSubscriber("reward", nrp.Topic("/task/reward", Float64))
@nrp.MapRobotSubscriber("learning", nrp.Topic("/task/learning", Bool))
@nrp.Robot2Neuron()
def listen(t, reward, learning):
    if learning.value.data:
        with HEARD.open("a") as file:
            file.write(f"{reward.value.data}\\n")
"""


def test_weights_that_change_in_the_test_are_an_error(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(ExperimentError):
        perform(Trial("pole", own(tmp_path, CHEAT), 1, training=20), ("learned",))


def test_an_action_that_does_not_exist_is_an_error(tmp_path: Path, golden: Golden) -> None:
    path = own(tmp_path, CONSTANT.replace("Int32(0)", "Int32(7)"))
    with golden.raises(ExperimentError):
        perform(Trial("pole", path, 1, training=20), ("learned",))


def test_a_learner_is_installed_or_a_file_or_a_folder(tmp_path: Path, golden: Golden) -> None:
    assert "rstdp" in LEARNERS.names()
    path = own(tmp_path, CONSTANT)
    assert find_learner(path) == find_learner(tmp_path) == path
    with golden.raises(ExperimentError, match="'rstdp'"):
        find_learner("rstpd")
    path.write_text("model: nothing.py\n")
    with pytest.raises(InvalidExperimentError):
        read_learner(path)


def test_a_seed_counts_if_it_beats_all_baselines_by_more_than_their_spread() -> None:
    learned, one, other = (
        Standing("pole", "", scores, (), 0.0, 0.0)
        for scores in ((0.9, 0.52, 0.45), (0.4, 0.5, 0.45), (0.42, 0.44, 0.5))
    )
    assert learned.better_than([one, other]) == 1


def test_the_command_trains_and_goes_on(nrp: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(TASKS["pole"], "training", 50)
    out, given = tmp_path / "out", own(tmp_path, CONSTANT)
    command = ("benchmark", "learning", "pole", "--learner", given, "--out", out, "--workers", 1)
    assert nrp(*command, "--seeds", 1).code == 0
    first = (out / "pole-1.json").read_bytes()
    found = nrp(*command, "--seeds", 2, "--json")
    assert (out / "pole-1.json").read_bytes() == first
    rows = {row["condition"]: row for row in json.loads(found.out)["rows"]}
    assert rows["learned"]["seeds"] == 2
    assert rows["learned"]["median"] == pytest.approx(rows["unlearned"]["median"]), "it does not learn"
    with (out / "learning.csv").open() as file:
        assert [float(row["median"]) for row in csv.DictReader(file)] == [
            row["median"] for row in rows.values()
        ]
    assert b"<svg" in (out / "learning.svg").read_bytes()
    kept = json.loads(first)["outcomes"][0]
    tests = [one["score"] for one in kept["episodes"] if not one["trains"]]
    assert kept["score"] == pytest.approx(np.mean(tests))
    refused = nrp(*command[:3], "--out", out, "--workers", 1)
    assert refused.code == 3
    assert "another learner" in refused.err
    assert nrp("benchmark", "learning", "poel", "--out", out).code == 3


def test_a_trial_is_made_again_when_its_learner_changes(tmp_path: Path) -> None:
    given = own(tmp_path, "from chosen import choose\n")
    (tmp_path / "chosen.py").write_text(CONSTANT)

    def ladder() -> Ladder:
        return Ladder(["pole"], given, "event", "mujoco", 1, tmp_path / "out", training=20)

    made = ladder()
    made.run(1)
    assert (made.pending, made.news) == ([], "")
    assert ladder().pending == []
    (tmp_path / "chosen.py").write_text(CONSTANT.replace("Int32(0)", "Int32(1)"))
    again = ladder()
    assert [trial.seed for trial in again.pending] == [1]
    assert again.news == f"1 earlier outcomes do not count: the file {tmp_path / 'chosen.py'} changed"
    assert again.standings() == []
