"""What is wrong with an experiment is found before any engine starts, all of it, each at its place."""

from collections.abc import Callable
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.checks.validate import validate, validate_file
from nrp_core.errors import BackendLoadError, ExperimentError, UnknownBackendError
from nrp_core.experiment.making.prepare import prepare
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.findings import Code, InvalidExperimentError, Level

pytestmark = pytest.mark.usefixtures("fakes")

Edit = Callable[..., Path]


@pytest.fixture
def edit(drive_to_the_wall: Path) -> Edit:
    """Replace a text in a file of the experiment."""

    def edited(old: str, new: str, file: str = "experiment.yaml") -> Path:
        path = drive_to_the_wall / file
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))
        return drive_to_the_wall

    return edited


def errors_of(folder: Path) -> list[str]:
    errors = [finding for finding in validate_file(folder) if finding.level is Level.ERROR]
    return [str(error).replace(f"{folder}/", "") for error in errors]


def test_validate_takes_an_experiment_or_its_name_or_path(edit: Edit, golden: Golden) -> None:
    folder = edit("seed: 7", "seed: 7\nsede: 4")
    assert errors_of(folder)
    assert validate(folder) == validate(str(folder)) == validate_file(folder)
    shipped = validate("braitenberg_husky/no_red")
    assert shipped == validate(load_experiment("braitenberg_husky/no_red"))
    with golden.raises(ExperimentError, match=r"load_experiment\('...'\)"):
        validate(3)  # type: ignore[arg-type]


def test_a_working_experiment_has_no_errors_and_repairs_are_warnings(
    drive_to_the_wall: Path,
) -> None:
    findings = [finding for finding in validate_file(drive_to_the_wall) if finding.level is not Level.NOTE]
    assert {finding.level for finding in findings} == {Level.WARNING}
    assert {finding.path.name for finding in findings if finding.path} == {"husky.sdf"}
    assert all(finding.line for finding in findings)


MISTAKES = [
    ("backend: counting", "backend: countin", "countin,", "NRP205",
     "no brain backend is called 'countin'; did you mean 'counting'?"),
    ("backend: counting", "backend: broken", "broken,", "NRP205",
     "brain backend 'broken' of fakes 1.0 (no_such_module:Backend) does not import: ModuleNotFoundError"),
    ("backend: disc", "backend: disk", "disk", "NRP205",
     "no world backend is called 'disk'; did you mean 'disc'?"),
    ("timestep: 2 ms", "timestep: 3 ms", "3 ms", "NRP372",
     "the loop's period of 20 ms must be a positive multiple of the brain's step (any) and of the world's "
     "step (3 ms)"),
    ('actors: "2:4"', 'actors: "2:9"', '"2:9"', "NRP211", "'2:9' reaches outside the circuit"),
    ("/speed: std_msgs/Float64", "/husky/cmd_vel: std_msgs/Float64", "std_msgs", "NRP212",
     "the topic '/husky/cmd_vel' already exists"),
    ("/glass: /wall/body/glass/color", "/glass: /wall/body/glas/color", "/wall/body/glas/", "NRP212",
     "no topic '/wall/body/glas/color'; did you mean '/wall/body/glass/color'?"),
    ("topic: /speed, value: 1", "topic: /spee, value: 1", "{topic", "NRP212",
     "no topic '/spee'; did you mean '/speed'?"),
    ("topic: /speed, value: 1", "topic: /speed, value: fast", "{topic", "NRP212",
     "/speed carries std_msgs/msg/Float64: 'fast' is not of type float"),
    ("topic: /speed, value: 1", "topic: /gazebo/model_states, value: {}", "{topic", "NRP212",
     "the topic '/gazebo/model_states' (gazebo_msgs/msg/ModelStates) only gives messages"),
    ("event: red, near", "event: rde, near", "rde", "NRP213",
     "there is no event 'rde'; did you mean 'red'?"),
    ("near: {model: husky", "near: {model: robot", "{event: red, near", "NRP213",
     "the scene has no model 'robot'; valid: husky, wall"),
    ("glass, within: 1 m}}\n    pub", "glas, within: 1 m}}\n    pub", "{event: red, near", "NRP213",
     "the scene has no visual 'wall/body/glas'; did you mean 'wall/body/glass'?"),
    ("{event: red, time", "{event: blue, time", "blue", "NRP213",
     "there is no event 'blue'; valid: arrived, go, red"),
    ("stays_within: {model: husky", "stays_within: {model: husk", "{model: husk,", "NRP213",
     "the scene has no model 'husk'; did you mean 'husky'?"),
    ("of: [0, 0]", "during: {until: go_away}", "go_away", "NRP213",
     "there is no event 'go_away'; valid: arrived, go, red"),
]  # fmt: skip


@pytest.mark.one_of(8)
@pytest.mark.parametrize(("old", "new", "at", "code", "message"), MISTAKES)
def test_a_mistake_in_the_experiment_is_found_at_its_place(
    edit: Edit, old: str, new: str, at: str, code: str, message: str
) -> None:
    folder = edit(old, new)
    (finding,) = [finding for finding in validate_file(folder) if finding.level is Level.ERROR]
    assert message in finding.message
    assert finding.code.name == code
    assert finding.line
    assert finding.column
    line = (folder / "experiment.yaml").read_text().splitlines()[finding.line - 1]
    assert line[finding.column - 1 :].startswith(at)


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("file", "old", "new", "where", "code"),
    [
        ("drive.py", "nrp.brain.actors[0]", "nrp.brain.motors[0]", "drive.py:8", "NRP211"),
        ("drive.py", "nrp.brain.actors[0]", "nrp.brain.actors[2]", "drive.py:8", "NRP211"),
        ("drive.py", '"/speed"', '"/spede"', "drive.py:6", "NRP212"),
        ("drive.py", "std_msgs.msg.Float64", "std_msgs.msg.Bool", "drive.py:6", "NRP212"),
        ("drive.py", '"/husky/cmd_vel"', '"/huskie/cmd_vel"', "drive.py:6", "NRP212"),
        ("drive.py", '"speed", nrp', '"sped", nrp', "drive.py:6", "NRP210"),
        ("drive.py", "def drive", "def def drive", "drive.py:10", "NRP210"),
        ("drive.py", "@nrp.Neuron2Robot(", "@nrp.Neuron2Robt(", "drive.py:9", "NRP210"),
        ("brain.py", "sim.setup", "sim.setpu", "brain.py:3", "NRP208"),
        ("brain.py", "IF_curr_exp", "Izhikevich", "experiment.yaml:5:18", "NRP216"),
        ("room.sdf", "<size>0.02 2 1</size>", "<size>0.02 2</size>", "room.sdf:10", "NRP209"),
        ("husky.sdf", "<leftJoint>left</leftJoint>", "<leftJoint>lft</leftJoint>", "husky.sdf:", "NRP209"),
    ],
)
def test_a_mistake_in_a_file_is_found_in_that_file(
    edit: Edit, file: str, old: str, new: str, where: str, code: str
) -> None:
    errors = errors_of(edit(old, new, file))
    assert len(errors) == 1, errors
    assert errors[0].startswith(where)
    assert errors[0].endswith(f"[{code}]")


def test_a_script_is_refused_whose_time_step_does_not_divide_the_loop(edit: Edit, golden: Golden) -> None:
    (error,) = errors_of(edit("timestep=0.1", "timestep=0.3", "brain.py"))
    golden(error)


def test_mistakes_in_different_files_are_found_at_once(edit: Edit) -> None:
    edit("backend: counting", "backend: countin")
    edit("actors[0]", "motors[0]", "drive.py")
    edit("visual: wall/body/glass", "visual: wall/body/glas")
    codes = [error[-7:-1] for error in errors_of(edit("event: red, near", "event: rde, near"))]
    assert codes == ["NRP205", "NRP213", "NRP213", "NRP211"]


def test_reading_errors_are_findings_too(edit: Edit) -> None:
    assert errors_of(edit("duration: 3 s", "duration: 3"))[0].endswith("[NRP202]")


def test_an_experiment_that_does_not_exist_is_a_finding(tmp_path: Path) -> None:
    (finding,) = validate_file(tmp_path / "nothing.yaml")
    assert finding.code is Code.NRP204
    assert finding.message.startswith("there is no experiment")


def test_a_backend_whose_capabilities_cannot_be_read_is_named(
    drive_to_the_wall: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from experiment_fakes import CountingBackend

    def fail(self: object, options: object) -> None:
        raise OSError("no such library")

    monkeypatch.setattr(CountingBackend, "capabilities", fail)
    (error,) = errors_of(drive_to_the_wall)
    assert "the backend 'counting' does not report its capabilities: OSError: no such library" in error


def test_an_unreadable_robot_causes_no_errors_about_its_topics(edit: Edit) -> None:
    (error,) = errors_of(edit("<joint", "<jiont", "husky.sdf"))
    assert "NRP209" in error


def test_a_file_that_no_loader_knows_is_refused(edit: Edit, drive_to_the_wall: Path) -> None:
    (drive_to_the_wall / "drive.txt").touch()
    (error,) = errors_of(edit("[drive.py]", "[drive.txt]"))
    assert "no transfer functions are read from 'drive.txt'" in error


def test_two_functions_of_one_name_are_refused(edit: Edit, drive_to_the_wall: Path) -> None:
    (drive_to_the_wall / "again.py").write_text((drive_to_the_wall / "drive.py").read_text())
    (error,) = errors_of(edit("[drive.py]", "[drive.py, again.py]"))
    assert "the transfer function 'drive' already exists" in error


# -- what a run does with them


def test_a_run_of_a_wrong_experiment_raises_all_findings(edit: Edit) -> None:
    edit("actors[0]", "motors[0]", "drive.py")
    experiment = load_experiment(edit("event: red, near", "event: rde, near"))
    with pytest.raises(InvalidExperimentError) as error:
        prepare(experiment)
    assert {finding.code.name for finding in error.value.findings} == {"NRP211", "NRP213", "NRP264", "NRP384"}


@pytest.mark.parametrize(("name", "kind"), [("countin", UnknownBackendError), ("broken", BackendLoadError)])
def test_a_missing_backend_is_an_error_of_its_own_that_says_where_it_is_named(
    edit: Edit, name: str, kind: type[Exception]
) -> None:
    experiment = load_experiment(edit("backend: counting", f"backend: {name}"))
    with pytest.raises(kind, match=rf"experiment\.yaml:5:18: .*{name}"):
        prepare(experiment)


def test_a_backend_missing_because_of_an_override_names_the_override(
    drive_to_the_wall: Path, golden: Golden
) -> None:
    with golden.raises(UnknownBackendError, match=r"'world\.backend=disk'"):
        prepare(load_experiment(drive_to_the_wall, ["world.backend=disk"]))


def test_a_plan_holds_what_the_engines_need(drive_to_the_wall: Path) -> None:
    plan = prepare(load_experiment(drive_to_the_wall))
    assert plan.network.size == 4
    assert [model.name for model in plan.scene.models] == ["wall", "husky"]
    assert [function.name for function in plan.functions] == ["drive"]
    assert not plan.functions[0].is_bound
    assert plan.world.capabilities.step_ns == 2_000_000


def notes_of(folder: Path, code: Code) -> list[str]:
    return [finding.message for finding in validate_file(folder) if finding.code is code]


READER = """

@nrp.MapSpikeSink("rate", nrp.brain.lonely, nrp.population_rate)
@nrp.Robot2Neuron()
def read(t, rate):
    assert rate.rate >= 0.0
"""
DRIVER = """
@nrp.MapSpikeSource("source", nrp.brain.lonely, nrp.poisson)
@nrp.Robot2Neuron()
def push(t, source):
    source.rate = 50.0
"""


def never_firing(edit: Edit, more: str, cells: str = "sim.IF_curr_exp()", functions: str = READER) -> bool:
    """Return whether it is found that no cell of a population fires that a function reads."""
    population = f"\nlonely = sim.Population(3, {cells}, label='lonely')\n{more}\n"
    folder = edit('label="circuit")', f'label="circuit"){population}', "brain.py")
    with (folder / "drive.py").open("a") as file:
        file.write(functions)
    return any(
        "no cell of the population 'lonely' can fire" in said for said in notes_of(folder, Code.NRP377)
    )


def synapses(weight: float, receptor: str = "excitatory") -> str:
    law = f"sim.StaticSynapse(weight={weight}, delay=1.0), receptor_type={receptor!r}"
    return f"sim.Projection(circuit, lonely, sim.AllToAllConnector(), {law})"


@pytest.mark.one_of(2)
@pytest.mark.parametrize(
    ("more", "cells"),
    [
        ("", "sim.IF_curr_exp()"),
        (synapses(-20.0, "inhibitory"), "sim.IF_curr_exp()"),
        (synapses(0.1, "inhibitory"), "sim.IF_cond_exp()"),
        ("", "sim.IF_curr_exp(i_offset=0.7)"),  # 14 mV above rest; the threshold is 15 mV above it
    ],
)
def test_a_population_that_is_read_and_that_nothing_excites_is_found(
    edit: Edit, more: str, cells: str
) -> None:
    assert never_firing(edit, more, cells)


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("more", "cells", "functions"),
    [
        (synapses(20.0), "sim.IF_curr_exp()", READER),
        ("", "sim.IF_curr_exp(i_offset=0.8)", READER),  # 16 mV
        ("", "sim.IF_curr_exp(v_rest=-45.0)", READER),  # above its threshold of -50 mV
        ("", "sim.IF_curr_exp()", READER + DRIVER),
        (
            "",
            "sim.IF_curr_exp()",
            READER.replace("population_rate", "voltage_recorder").replace("rate.rate", "t"),
        ),
        (synapses(0.1, "inhibitory"), "sim.IF_cond_exp(e_rev_I=-40.0)", READER),
        (
            "",
            "sim.IF_curr_exp()",
            READER + DRIVER.replace("brain.lonely", "brain.lonely[: len(open(__file__).name)]"),
        ),
        ("sim.DCSource(amplitude=0.8).inject_into(lonely)", "sim.IF_curr_exp()", READER),
    ],
)
def test_a_population_that_may_fire_or_whose_voltage_is_read_is_not_found(
    edit: Edit, more: str, cells: str, functions: str
) -> None:
    assert not never_firing(edit, more, cells, functions)


def test_a_delay_that_the_backend_refuses_is_found_before_the_run(edit: Edit, golden: Golden) -> None:
    synapses = "sim.AllToAllConnector(), sim.StaticSynapse(delay=0)"
    projection = f'label="circuit")\nsim.Projection(circuit, circuit, {synapses})\n'
    folder = edit('label="circuit")', projection, "brain.py")
    edit("backend: counting", "backend: event")
    (error,) = errors_of(folder)
    assert error.startswith("experiment.yaml:5:")
    assert "has a delay of 0 ms; from one neuron to another a spike takes at least 1e-06 ms" in error
    with golden.raises(InvalidExperimentError, match=r"experiment\.yaml:5"):
        prepare(load_experiment(folder))


@pytest.mark.parametrize(
    ("old", "new"), [("timestep: 20 ms", "timestep: -20 ms"), ("at: 0.5 s", "at: -0.5 s")]
)
def test_a_negative_time_is_refused_as_it_is_written(edit: Edit, old: str, new: str) -> None:
    (error,) = errors_of(edit(old, new))
    assert error.split(" [")[0].endswith(f", not {new.split(': ')[1]}")
