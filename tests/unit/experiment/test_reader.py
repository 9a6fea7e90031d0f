"""Reading an experiment file: what it means, and every way in which it can be wrong."""

from collections.abc import Callable
from math import pi
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.experiment.reading.reader import read_yaml
from nrp_core.findings import Finding, InvalidExperimentError
from nrp_core.scene.rigid import Pose

pytestmark = pytest.mark.usefixtures("fakes")

GOOD = """\
name: braitenberg
timestep: 20 ms
duration: 60 s
seed: 7
brain:
  backend: counting
  model: brain.py
  populations: {sensors: "0:5", actors: [6, 7]}
  options: {resolution: 1 ms}
world:
  backend: disc
  scene: room.sdf
  robots: {husky: {model: husky.sdf, pose: [0, 0, 20 cm, 0, 0, 180 deg]}}
  options: {timestep: 2 ms}
transfer_functions: [listing1.py]
topics: {/mood: std_msgs/Float64}
aliases: {/screens/left/color: /left/body/glass/color}
events:
  left_red: {at: 5 s, publish: {topic: /screens/left/color, value: red}}
  left_blue: {when: {near: {model: husky, visual: left/body/glass, within: 1.2 m}}}
criteria:
  reaches:
    near: {model: husky, visual: left/body/glass, within: 1.2 m}
    within_of: {event: left_red, time: 15 s}
  waits: {stays_within: {model: husky, distance: 0.5 m, during: {until: left_red}}}
"""

Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write an experiment beside the files that it names."""
    for name in ("brain.py", "room.sdf", "husky.sdf", "listing1.py"):
        (tmp_path / name).touch()

    def file(text: str = GOOD, name: str = "experiment.yaml") -> Path:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return file


def findings_of(path: Path, *overrides: str) -> list[Finding]:
    with pytest.raises(InvalidExperimentError) as error:
        read_yaml(path, overrides)
    assert str(error.value) == str(error.value.findings[0].as_error())
    return list(error.value.findings)


def only_finding(path: Path, *overrides: str) -> str:
    (finding,) = findings_of(path, *overrides)
    return str(finding).replace(str(path.parent) + "/", "")


def test_a_good_file_becomes_typed_data_in_base_units(write: Write, tmp_path: Path) -> None:
    experiment = read_yaml(write())
    assert (experiment.timestep, experiment.duration, experiment.seed) == (20_000_000, 60_000_000_000, 7)
    assert experiment.brain.model == tmp_path / "brain.py"
    assert experiment.brain.populations == {"sensors": "0:5", "actors": [6, 7]}
    assert experiment.world.robots["husky"].start == Pose.from_rpy((0, 0, 0.2), 0, 0, pi)
    assert experiment.topics["/mood"].__name__ == "Float64"
    assert experiment.events["left_red"].publish[0].topic == "/screens/left/color"
    assert (experiment.on_error, experiment.tf_time, experiment.pace) == ("stop", "end", "max")


MISTAKES = [
    ("60 s", "60 sek", "60 sek", "NRP202",
     "duration: 'sek' is not a unit of a time; valid: h, min, ms, ns, s, us"),
    ("60 s", "60", "60", "NRP202", "duration: a time needs a unit: '60 ms' or '60 s'?"),
    ("60 s", "61 ms", "61 ms", "NRP202", "duration: 61 ms must be a multiple of the time step, 20 ms"),
    ("duration: 60 s", "", "name:", "NRP201", "an experiment needs the key 'duration'"),
    ("7", "seven", "seven", "NRP202",
     "seed: should be a valid integer, not 'seven'"),
    ("7", "true", "true", "NRP202", "seed: should be a valid integer, not True"),
    ("seed: 7", "sede: 7", "sede", "NRP201", "an experiment has no key 'sede'; did you mean 'seed'?"),
    ("brain.py", "brian.py", "brian.py", "NRP204",
     "brain.model: no file 'brian.py' in .; did you mean 'brain.py'?"),
    ("brain.py", "nowhere/brain.py", "nowhere", "NRP204",
     "brain.model: no file 'nowhere/brain.py': there is no folder ./nowhere"),
    ("brain.py", ".", ".", "NRP204", "brain.model: '.' is a folder, not a file"),
    ("backend: counting\n  ", "", "model: brain.py", "NRP201", "'brain' needs the key 'backend'"),
    ('"0:5"', "zero", "zero", "NRP202",
     "brain.populations.sensors: neurons are '0:5', '0:6:2', 3 or [0, 2], not 'zero'"),
    ("sensors:", "my sensors:", "my sensors", "NRP202",
     "brain.populations.my sensors: a name has letters, digits and '_', and no digit first: "
     "not 'my sensors'"),
    ("resolution", "resoluton", "resoluton", "NRP202",
     "'brain.options' has no key 'resoluton'; did you mean 'resolution'?"),
    ("1 ms}", "1 m}", "1 m}", "NRP202",
     "brain.options.resolution: 'm' is not a unit of a time; did you mean 'ms'?"),
    ("2 ms}", "-2 ms}", "-2 ms", "NRP202", "world.options.timestep: must be more than 0, not -2 ms"),
    ("0, 0, 180", "180", "[0, 0", "NRP202",
     "world.robots.husky.pose: a pose is [x, y, z, roll, pitch, yaw], 6 values, not 4"),
    ("180 deg", "180 degrees", "180 degrees", "NRP202",
     "world.robots.husky.pose.5: 'degrees' is not a unit of an angle; did you mean 'deg'?"),
    ("Float64", "Flaot64", "std_msgs", "NRP202",
     "topics./mood: unknown message type 'std_msgs/Flaot64'; did you mean 'Float64'?"),
    ("/screens/left/color:", "screens/left:", "screens/left", "NRP202",
     "aliases.screens/left: a topic reads like '/husky/camera', not 'screens/left'"),
    ("value: red", "value: red, colour: red", "colour", "NRP201",
     "'events.left_red.publish' has no key 'colour'; valid: topic, value"),
    (", value: red", "", "{topic", "NRP201", "'events.left_red.publish' needs the key 'value'"),
    ("at: 5 s, ", "", "{publish", "NRP202", "events.left_red: needs exactly one of at, when; it has none"),
    ("at: 5 s", "at: 5 s, when: {event: left_blue}", "{at: 5 s", "NRP202",
     "events.left_red: needs exactly one of at, when; it has 'at' and 'when'"),
    ("1.2 m}}}\ncrit", "1.2 s}}}\ncrit", "1.2 s", "NRP202",
     "events.left_blue.when.near.within: 's' is not a unit of a length; valid: cm, km, m, mm"),
    ("{near: {model: husky, visual: left/body/glass, within: 1.2 m}}}\ncrit", "{}}\ncrit", "{}}", "NRP202",
     "events.left_blue.when: needs 'near', 'event', 'topic' or 'observable'"),
    ("until: left_red", "until: 5", "5}}}", "NRP202",
     "criteria.waits.stays_within.during.until: a time needs a unit: '5 ms' or '5 s'?; or the name of an "
     "event, 'start' or 'end'"),
    ("7", "7\non_error: ignore", "ignore", "NRP202",
     "on_error: should be 'stop' or 'quarantine', not 'ignore'"),
    ("7", "7\npace: 0", "0\n", "NRP202",
     "pace: a pace is 'max', 'realtime' or a factor of at least 0.0001, not 0"),
    ("7", "7\npace: 0.00009", "0.00009", "NRP202",
     "pace: a pace is 'max', 'realtime' or a factor of at least 0.0001, not 9e-05"),
    ("7", "7\nfunction_time_limit: 999 us", "999 us", "NRP202",
     "function_time_limit: a time limit is at least 1 ms, or 'off', not '999 us'"),
    ("brain:", "brain:\n  time_limit: 0 s", "0 s", "NRP202",
     "brain.time_limit: a time limit is at least 1 ms, or 'off', not '0 s'"),
    ("7", "7\nseed: 8", "seed: 8", "NRP200", "the key 'seed' is given twice"),
    ("7", "7\ncompatibility:  # none", "compatibility:", "NRP200",
     "the key 'compatibility' has no value; 'null' removes what is inherited"),
    ("[listing1.py]", "[listing1.py, listing1.py]", "[listing1.py, ", "NRP202",
     "transfer_functions: items 0 and 1 of the list are the same"),
    ("[listing1.py]", "[listing1.py]\ncomparison: {controls: [shuffle: signs, shuffle: signs]}",
     "{controls", "NRP202", "comparison: controls: items 0 and 1 of the list are the same"),
    ("[listing1.py]", "listing1.py", "listing1.py", "NRP202",
     "transfer_functions: should be a valid list, not 'listing1.py'"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "at", "code", "message"), MISTAKES)
def test_each_mistake_gets_one_finding_at_its_place(
    write: Write, tmp_path: Path, old: str, new: str, at: str, code: str, message: str
) -> None:
    assert old in GOOD
    text = GOOD.replace(old, new, 1)
    (finding,) = findings_of(write(text))
    assert finding.message.replace(str(tmp_path), ".") == message
    assert finding.code.name == code
    assert finding.line
    assert finding.column
    assert "\n".join([text.splitlines()[finding.line - 1][finding.column - 1 :], ""]).startswith(at)


def test_all_mistakes_are_found_at_once_in_the_order_of_the_file(write: Write) -> None:
    text = GOOD.replace("60 s", "60").replace("2 ms", "2 m").replace("listing1", "listing9")
    text = text.replace("value: red", "value: red, x: 1")
    findings = findings_of(write(text))
    assert [(f.line, f.code.name) for f in findings] == [
        (3, "NRP202"), (14, "NRP202"), (15, "NRP204"), (19, "NRP201"),
    ]  # fmt: skip


def test_an_experiment_can_be_read_where_its_backend_is_not_installed(write: Write) -> None:
    experiment = read_yaml(write(GOOD.replace("counting", "elsewhere")))
    assert experiment.brain.backend == "elsewhere"


# -- overrides


def test_an_override_replaces_a_value_and_its_later_twin_counts(write: Write) -> None:
    experiment = read_yaml(write(), ["seed=8", "brain.options.resolution=2 ms", "seed=9", "duration=20s"])
    assert (experiment.seed, experiment.duration) == (9, 20_000_000_000)
    assert experiment.brain.options == {"resolution": "2 ms"}


def test_an_override_reaches_into_lists_and_takes_any_yaml(write: Write) -> None:
    experiment = read_yaml(write(), ["world.robots.husky.pose.5=90 deg", "events.left_red={at: 1 s}"])
    assert experiment.world.robots["husky"].pose[5] == pytest.approx(pi / 2)
    assert experiment.events["left_red"].at == 1_000_000_000


def test_an_override_of_null_takes_a_key_away(write: Write) -> None:
    assert set(read_yaml(write(), ["criteria.waits=null"]).criteria) == {"reaches"}


def test_a_file_named_by_an_override_lies_below_the_current_folder(
    write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write()
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "other.py").touch()
    monkeypatch.chdir(tmp_path / "here")
    assert read_yaml(path, ["brain.model=other.py"]).brain.model == tmp_path / "here" / "other.py"


@pytest.mark.parametrize(
    ("override", "finding"),
    [
        ("seed", "in the override 'seed': it must read 'dotted.key=value' [NRP202]"),
        (None, "in the override 'None': it must read 'dotted.key=value' [NRP202]"),
        ("seed= ", "in the override 'seed= ': there is no value; write 'seed=null' to remove it [NRP202]"),
        ("brain..model=x", "in the override 'brain..model=x': it must read 'dotted.key=value' [NRP202]"),
        ("seed=x", "in the override 'seed=x': seed: should be a valid integer, not 'x' [NRP202]"),
        ("sede=1",
         "in the override 'sede=1': an experiment has no key 'sede'; did you mean 'seed'? [NRP201]"),
        ("brain.options.resoluton=1 ms",
         "in the override 'brain.options.resoluton=1 ms': 'brain.options' has no key 'resoluton'; did you "
         "mean 'resolution'? [NRP202]"),
        ("world.robots.husky.pose.9=1", "in the override 'world.robots.husky.pose.9=1': the list has no item "
         "'9'; valid: 0, 1, 2, 3, 4, 5 [NRP202]"),
        ("events.left_rde.at=1 s", "in the override 'events.left_rde.at=1 s': there is no event 'left_rde'; "
         "did you mean 'left_red'? (a new event is given whole: "
         "'events.left_rde={at: ..., publish: ...}') [NRP202]"),
        ("seed.x=1", "in the override 'seed.x=1': 'x' cannot be set: the value above it is 7, "
         "not a mapping [NRP202]"),
        ("events={}", "in the override 'events={}': it changes nothing: mappings are merged; 'events=null' "
         "removes it [NRP202]"),
        ("events=[", "in the override 'events=[': not YAML: a list in [ ] or a mapping in { } is "
         "not complete [NRP202]"),
    ],
)  # fmt: skip
def test_a_wrong_override_is_named(write: Write, override: str, finding: str) -> None:
    assert only_finding(write(), override) == finding


# -- extends


def test_a_variant_is_laid_over_what_it_extends(write: Write) -> None:
    write()
    variant = (
        "extends: experiment.yaml\nname: variant\nevents: {left_red: {at: 1 s}}\ncriteria: {waits: null}\n"
    )
    experiment = read_yaml(write(variant, "variant.yaml"))
    assert (experiment.name, experiment.seed) == ("variant", 7)
    assert experiment.events["left_red"].at == 1_000_000_000
    assert experiment.events["left_red"].publish[0].value == "red"
    assert set(experiment.criteria) == {"reaches"}


def test_the_description_of_another_experiment_is_not_that_of_a_variant(write: Write) -> None:
    write()
    own = write("extends: experiment.yaml\nname: w\ndescription: A screen turns red.", "w.yaml")
    assert read_yaml(own).description == "A screen turns red."
    assert not read_yaml(write("extends: w.yaml\nname: v", "v.yaml")).description


def test_variants_can_be_combined_and_their_common_base_comes_once(write: Write) -> None:
    write()
    write("extends: experiment.yaml\nseed: 8\nevents: null", "a.yaml")
    write("extends: experiment.yaml\ncriteria: {waits: null}", "b.yaml")
    experiment = read_yaml(write("extends: [a.yaml, b.yaml]\nname: both", "both.yaml"))
    assert (experiment.name, experiment.seed, experiment.events) == ("both", 8, {})
    assert set(experiment.criteria) == {"reaches"}


@pytest.mark.parametrize(
    ("change", "code", "message"),
    [
        (
            "events: {}",
            "NRP202",
            "'events' is empty, which changes nothing: mappings are merged; 'events: null'",
        ),
        ("brain: {populations: {}}", "NRP202", "'populations' is empty, which changes nothing"),
        ("sed: null", "NRP201", "there is no 'sed' to remove; did you mean 'seed'?"),
        ("events: {left_blue: {when: {evnt: null}}}", "NRP201", "there is no 'evnt' to remove"),
        ("comparison: {vary: {}}", "", ""),
        ("events: {left_red: {publish: []}}", "", ""),
        ("criteria: null", "", ""),
    ],
)
def test_a_variant_that_changes_nothing_by_what_it_says_is_refused(
    write: Write, change: str, code: str, message: str
) -> None:
    write()
    variant = write(f"extends: experiment.yaml\nname: variant\n{change}\n", "variant.yaml")
    if not code:
        read_yaml(variant)
        return
    (finding,) = findings_of(variant)
    assert (finding.code.name, finding.line) == (code, 3)
    assert finding.message.startswith(message)


def test_of_several_bases_the_later_counts(write: Write) -> None:
    write()
    write("extends: experiment.yaml\nseed: 8", "a.yaml")
    write("extends: experiment.yaml\nseed: 9", "b.yaml")
    assert read_yaml(write("extends: [a.yaml, b.yaml]", "both.yaml")).seed == 9


def test_each_file_names_paths_relative_to_itself(write: Write, tmp_path: Path) -> None:
    write()
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "own.py").touch()
    experiment = read_yaml(
        write("extends: ../experiment.yaml\ntransfer_functions: [own.py]", "sub/variant.yaml")
    )
    assert experiment.transfer_functions == (tmp_path / "sub" / "own.py",)
    assert experiment.brain.model == tmp_path / "brain.py"


def test_errors_point_into_the_file_that_is_wrong(write: Write) -> None:
    write(GOOD.replace("seed: 7", "seed: x"))
    findings = findings_of(
        write("extends: experiment.yaml\nbrain: {options: {resolution: 5}}", "variant.yaml")
    )
    assert [(f.path.name, f.line) for f in findings if f.path] == [
        ("experiment.yaml", 4),
        ("variant.yaml", 2),
    ]


@pytest.mark.parametrize(
    ("base", "message"),
    [
        ("experimnt.yaml", "there is no experiment or file 'experimnt.yaml'"),
        ("variant.yaml", "an experiment cannot extend itself: variant.yaml -> variant.yaml"),
        ("other.yaml", "an experiment cannot extend itself: variant.yaml -> other.yaml -> variant.yaml"),
        ("3", "'extends' takes files or names of experiments, one or a list"),
        ("[base.yaml, base.yaml]", "'extends' names 'base.yaml' twice"),
        ("[base.yaml, 3]", "'extends' takes files or names of experiments, one or a list"),
        ("[base.yaml, other.yaml]", "extend itself: variant.yaml -> other.yaml -> variant.yaml"),
    ],
)
def test_a_base_that_cannot_be_extended_is_named(write: Write, base: str, message: str) -> None:
    write("extends: variant.yaml", "other.yaml")
    write("name: base", "base.yaml")
    finding = findings_of(write(f"name: v\nextends: {base}", "variant.yaml"))[0]
    assert finding.code.name == "NRP200"
    assert message in finding.message


def test_a_base_that_is_not_yaml_is_reported_where_it_is(write: Write) -> None:
    write("name: [", "base.yaml")
    assert only_finding(write("extends: base.yaml", "variant.yaml")).startswith("base.yaml:1:")


def test_a_misspelt_extends_is_one_mistake_that_names_it(tmp_path: Path) -> None:
    path = tmp_path / "variant.yaml"
    path.write_text("extend: braitenberg_husky\nduration: 1 s\n")
    with pytest.raises(InvalidExperimentError) as caught:
        read_yaml(path)
    (finding,) = caught.value.findings
    assert (finding.code.name, finding.line, "'extends'" in finding.message) == ("NRP201", 1, True)


@pytest.mark.parametrize(("more", "command"), [("", "sweep"), ("objective: {degree.reaches: 1}\n", "evolve")])
def test_the_file_of_a_sweep_is_one_mistake_that_names_the_command(
    tmp_path: Path, more: str, command: str, golden: Golden
) -> None:
    path = tmp_path / "sweep.yaml"
    path.write_text(f"experiment: slalom_pioneer\nvary: {{seed: {{from: 1, to: 2}}}}\n{more}")
    with pytest.raises(InvalidExperimentError) as caught:
        read_yaml(path)
    (finding,) = caught.value.findings
    golden(finding.message)
    assert "command that the message suggests" in finding.code.suggestion
