"""``nrp new``: what it makes is found, runs, and says what is missing yet."""

import json
import os
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path
from runpy import run_path

import nrp_conformance
import pytest
from golden import Golden

from nrp_core.brain.backend import BRAIN_INTERFACE_VERSION
from nrp_core.brain.backends import brains
from nrp_core.brain.interface import Brain
from nrp_core.cli.new_robot import robot_values
from nrp_core.errors import NrpError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.world.backend import WORLD_INTERFACE_VERSION
from nrp_core.world.backends import worlds
from nrp_core.world.engine import Engine

VERSIONS = {"brain": BRAIN_INTERFACE_VERSION, "world": WORLD_INTERFACE_VERSION}
SIDES = {"brain": (brains, Brain), "world": (worlds, Engine)}
ROOT = Path(__file__).parents[3]


@pytest.fixture
def made(nrp, install, tmp_path, monkeypatch):
    """Return a function that makes a distribution and installs it."""

    def make(subject, name):
        folder = tmp_path / name
        done = nrp("new", subject, name, "-o", folder)
        assert done.code == 0, done.err
        project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
        groups = project["entry-points"]
        lines = [
            f"[{group}]\n" + "".join(f"{key} = {value}\n" for key, value in entries.items())
            for group, entries in groups.items()
        ]
        install(project["name"], "".join(lines))
        monkeypatch.syspath_prepend(folder / "src")
        path = os.pathsep.join([str(folder / "src"), os.environ["PYTHONPATH"]])
        monkeypatch.setenv("PYTHONPATH", path)
        return folder

    return make


@pytest.mark.parametrize("side", SIDES)
def test_a_new_backend_is_found_by_its_name_and_has_the_interface_version(made, side):
    made(side, "acme-two")
    registry, _ = SIDES[side]
    backend = registry().load("acme-two")
    assert type(backend).__name__ == "AcmeTwoBackend"
    assert vars(type(backend))["interface_version"] == VERSIONS[side]
    assert backend.capabilities(backend.options())


@pytest.mark.parametrize("side", SIDES)
def test_its_methods_are_the_fewest_and_each_says_what_to_write(made, side):
    folder = made(side, f"acme_{side}")
    registry, base = SIDES[side]
    module = sys.modules[type(registry().load(f"acme_{side}")).__module__]
    written = getattr(module, f"Acme{side.capitalize()}{base.__name__}")
    methods = {name for name in vars(written) if name.startswith("_do_")}
    needed = {name for name in base.__abstractmethods__ if name.startswith("_do_")}
    assert methods == needed | ({"_do_model_motion"} if side == "world" else set())  # unless poses=False
    source = (folder / "src" / f"nrp_{side}_acme_{side}" / f"{base.__name__.lower()}.py").read_text()
    assert source.count("raise NotImplementedError") == len(methods)  # a reset builds anew
    for name in (methods | {"_build"}) - {"_do_reset"}:
        assert f'"{name}: ' in source


@pytest.mark.heavy
def test_its_conformance_fails_and_says_what_to_write_first(made, warm):
    made("brain", "acme")
    command = [warm / "nrp", "conformance", "brain", "acme", "--level", "contract"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 1
    *_, cause, verdict = done.stdout.splitlines()
    assert "failed with the same error: NotImplementedError: _build: make " in cause
    assert "brain acme does not conform" in verdict


@pytest.mark.parametrize("side", SIDES)
def test_its_tests_compare_it_with_every_other_installed_backend(made, side):
    folder = made(side, f"acme_{side}")
    generated = run_path(str(folder / "tests" / "test_conformance.py"))
    suites = {"brain": nrp_conformance.BrainCrossTests, "world": nrp_conformance.WorldCrossTests}
    assert issubclass(generated[f"TestAcme{side.capitalize()}"], suites[side])


def test_a_new_experiment_runs_at_once_and_meets_its_criteria(nrp, tmp_path):
    nrp("new", "experiment", "my_circle", "-o", tmp_path)
    package = tmp_path / "src" / "nrp_experiment_my_circle"
    with Run(load_experiment(package, ["duration=2 s"])) as run:
        run.run()
        assert run.result().passed


@pytest.mark.one_of(3)
@pytest.mark.parametrize("subject", ["sensor", "device"])
def test_a_new_part_passes_its_own_tests_at_once(made, subject, warm):
    folder = made(subject, "acme-own")
    command = [warm / "python", "-m", "pytest", "-q", "-p", "no:cacheprovider", folder / "tests"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout
    assert " passed" in done.stdout


@pytest.mark.parametrize("subject", ["brain", "world", "experiment", "sensor", "device"])
def test_generated_code_follows_the_rules_of_this_project(nrp, tmp_path, subject):
    nrp("new", subject, "acme", "-o", tmp_path / "acme")
    source = ["--config", str(ROOT / "pyproject.toml"), str(tmp_path / "acme" / "src")]
    for command in (["check", "--ignore", "ARG001"], ["format", "--check"]):
        subprocess.run([sys.executable, "-m", "ruff", *command, *source], check=True, capture_output=True)


def test_new_lists_the_files_that_it_made(nrp, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = json.loads(nrp("new", "brain", "acme", "--json").out)
    assert found["folder"] == "nrp-brain-acme"
    assert all((tmp_path / found["folder"] / file).is_file() for file in found["files"])
    assert "pyproject.toml" in found["files"]


def test_a_folder_in_use_is_not_touched(nrp, tmp_path, golden: Golden):
    (tmp_path / "mine.txt").write_text("precious")
    done = nrp("new", "world", "acme", "-o", tmp_path)
    assert done.code == 2
    assert "--overwrite" in done.err
    golden(done.err)
    assert [file.name for file in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize("name", ["Acme", "1st", "a b", "a--b", "../up", ""])
def test_a_name_that_no_package_can_have_is_refused(nrp, tmp_path, name):
    done = nrp("new", "brain", name, "-o", tmp_path / "x")
    assert done.code == 2
    assert "lower-case letters" in done.err


@pytest.mark.parametrize(
    ("subject", "name"),
    [("brain", "event"), ("world", "mujoco"), ("experiment", "braitenberg_husky"), ("sensor", "imu")],
)
def test_a_name_that_is_taken_is_refused_with_its_owner(nrp, tmp_path, subject, name):
    done = nrp("new", subject, name, "-o", tmp_path / "x")
    assert done.code == 3
    assert f"nrp-core {version('nrp-core')} (nrp_" in done.err
    assert f"already provides the {subject} '{name}'" in done.err
    assert not (tmp_path / "x").exists()


def test_a_backend_that_is_not_written_yet_does_not_open_and_says_why(made, golden: Golden):
    made("world", "acme")
    with golden.raises(NrpError, match=r"'acme'.*_build.*self\.scene\.models"):
        Run(load_experiment("braitenberg_husky", ["world.backend=acme"]))


CART = """<robot name="cart"><link name="base"><inertial><mass value="4"/><inertia ixx="0.02" iyy="0.04"
  izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry><box size="0.4 0.2 0.1"/></geometry>
  </collision></link>{wheels}</robot>"""
WHEEL = """<link name="{name}"><collision><origin rpy="1.5708 0 0"/><geometry>
  <cylinder radius="0.1" length="0.04"/></geometry></collision></link>
  <joint name="{name}" type="{kind}"><parent link="base"/><child link="{name}"/><origin xyz="0 {y} 0"/>
  <axis xyz="0 {axis} 0"/><limit lower="-1" upper="1" effort="9" velocity="9"/></joint>"""


@pytest.mark.parametrize("kind", ["continuous", "revolute"])
def test_a_robot_becomes_an_experiment_that_moves_it(nrp, tmp_path: Path, monkeypatch, kind: str) -> None:
    monkeypatch.chdir(tmp_path)
    wheels = (("left", 0.2, 1), ("right", -0.2, -1))
    parts = "".join(WHEEL.format(name=name, y=y, axis=axis, kind=kind) for name, y, axis in wheels)
    Path("cart.urdf").write_text(CART.format(wheels=parts))
    assert nrp("new", "experiment", "tour", "--from", "cart.urdf").code == 0
    experiment = load_experiment(Path("tour"))
    assert experiment.world.robots["robot"].pose[2] == pytest.approx(0.11)  # 1 cm above the ground
    assert ("-0.06 * right.rate" in Path("tour/drive.py").read_text()) == (kind == "continuous")
    with Run(experiment) as run:
        run.run_until(0.5)
        assert run.result().spikes["sides"] > 5


DRIVE = """<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">
  <leftJoint>left_joint</leftJoint><rightJoint>right_joint</rightJoint>
  <wheelSeparation>0.4</wheelSeparation><wheelDiameter>0.2</wheelDiameter><legacyMode>false</legacyMode></plugin></gazebo></robot>"""


def test_a_robot_with_a_drive_is_driven_by_it_and_its_arm_is_held(nrp, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    sides = (("left", 0.2), ("right", -0.2))
    wheels = "".join(WHEEL.format(name=name, y=y, axis=1, kind="continuous") for name, y in sides)
    arm = WHEEL.format(name="arm", y=0.0, axis=1, kind="revolute")
    Path("cart.urdf").write_text(CART.format(wheels=wheels + arm).replace("</robot>", DRIVE))
    assert nrp("new", "experiment", "tour", "--from", "cart.urdf").code == 0
    experiment = load_experiment(Path("tour"))
    assert experiment.world.robots["robot"].control.keys() == {"arm_joint"}
    with Run(experiment) as run:
        run.run_until(2.0)
        assert run.result().passed


@pytest.mark.parametrize("kind", ["continuous", "revolute"])
@pytest.mark.parametrize(
    "name", ["a&quot;, Float64)) if not print(1) else 0 #", "a'b", "a&#10;b", "a\\", "{{ name }}", "[a, b]"]
)
def test_a_name_that_would_be_code_is_refused(nrp, tmp_path: Path, monkeypatch, name: str, kind: str) -> None:
    monkeypatch.chdir(tmp_path)
    for number, base in enumerate(("base", name)):  # of a joint, and of a link
        text = CART.format(wheels=WHEEL.format(name="wheel" if number else name, y=0.2, axis=1, kind=kind))
        Path("cart.urdf").write_text(text.replace('"base"', f'"{base}"'))
        done = nrp("new", "experiment", "tour", "--from", "cart.urdf")
        assert (done.code != 0, "needs a name of letters" in done.err) == (True, True), done.err
        assert not Path("tour").exists()


@pytest.mark.parametrize("name", ["1", "left wheel", "null", "rad: 2"])
def test_a_name_that_yaml_would_read_otherwise_stays_a_name(nrp, tmp_path, monkeypatch, name: str) -> None:
    monkeypatch.chdir(tmp_path)
    wheels = WHEEL.format(name=name, y=0.2, axis=1, kind="revolute")
    Path("cart.urdf").write_text(CART.format(wheels=wheels).replace('"base"', '"true"'))
    assert nrp("new", "experiment", "tour", "--from", "cart.urdf").code == 0
    assert load_experiment(Path("tour")).world.robots["robot"].control.keys() == {f"{name}_joint"}


def test_a_joint_of_an_arm_that_turns_like_a_wheel_is_none(tmp_path: Path) -> None:
    """It is in the middle of a chain, and there is only one such joint at an end."""
    upper = WHEEL.format(name="upper", y=0.2, axis=1, kind="continuous")
    lower = WHEEL.format(name="lower", y=0.2, axis=1, kind="continuous")
    chain = upper + lower.replace('parent link="base"', 'parent link="upper"')
    (tmp_path / "arm.urdf").write_text(CART.format(wheels=chain))
    assert robot_values(tmp_path / "arm.urdf")["mode"] == "position"


@pytest.mark.parametrize(("lower", "upper"), [(1.2, 2.5), (-4.0, -3.0), (-1.0, 1.0), (-0.1, 3.0)])
def test_a_joint_swings_within_its_limits(tmp_path: Path, lower: float, upper: float) -> None:
    wheel = WHEEL.format(name="arm", y=0.2, axis=1, kind="revolute")
    wheel = wheel.replace('lower="-1" upper="1"', f'lower="{lower}" upper="{upper}"')
    (tmp_path / "cart.urdf").write_text(CART.format(wheels=wheel))
    (joint,) = robot_values(tmp_path / "cart.urdf")["driven"]
    swing = 50.0 * joint.gain
    assert 0.2 < swing <= 0.4
    assert lower < joint.centre - swing < joint.centre + swing < upper


def test_only_an_experiment_is_made_of_a_robot(nrp, tmp_path: Path) -> None:
    (tmp_path / "cart.urdf").write_text(CART.format(wheels=""))
    assert nrp("new", "brain", "tour", "--from", tmp_path / "cart.urdf").code == 2
    assert nrp("new", "experiment", "tour", "--from", tmp_path / "cart.urdf").code != 0
