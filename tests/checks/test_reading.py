"""Files of transfer functions are read and not executed."""

from __future__ import annotations

from pathlib import Path

import pytest
from golden import Golden

from nrp_core.checks.code import statements
from nrp_core.checks.validate import validate, validate_file
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.findings import Finding, Level

TWIST = "Topic('/husky/cmd_vel', geometry_msgs.msg.Twist)"


def found_in(husky: Path, text: str, *overrides: str) -> list[Finding]:
    (husky / "own.py").write_text(text)
    found = validate_file(husky / "experiment.yaml", [f"transfer_functions=[{husky}/own.py]", *overrides])
    return [finding for finding in found if finding.code.name != "NRP238"]


def codes(found: list[Finding]) -> list[str]:
    return [finding.code.name for finding in found]


def test_no_transfer_function_is_executed(husky: Path, tmp_path: Path) -> None:
    mark = tmp_path / "executed"
    text = f"open({str(mark)!r}, 'w')\n@nrp.Robot2Neuron()\ndef f(t):\n    open({str(mark)!r}, 'w')\n"
    assert [finding.code.name for finding in found_in(husky, text)] == ["NRP378"]  # it would write a file
    assert not mark.exists()


def test_values_known_only_at_run_time_are_notes_and_cause_no_errors(husky: Path) -> None:
    text = (
        "import os\n"
        "import helpers\n"
        "@nrp.MapSpikeSource('eye', helpers.neurons(), nrp.poisson)\n"
        "@nrp.MapRobotSubscriber('own', Topic('/own', std_msgs.msg.Float64))\n"
        "@nrp.Robot2Neuron()\n"
        "def reads(t, eye, own):\n    eye.rate = own.value.data\n"
        "for side in os.environ['SIDES']:\n"
        "    @nrp.Neuron2Robot(Topic('/own', std_msgs.msg.Float64))\n"
        "    def sends(t):\n        return 1.0\n"
    )
    (husky / "helpers.py").write_text("import os\ndef neurons():\n    return os.environ['NEURONS']\n")
    found = found_in(husky, text)
    assert [finding.level for finding in found if finding.code.name == "NRP239"] == [Level.NOTE] * 2
    assert not [finding for finding in found if finding.level is Level.ERROR]


def test_subclasses_and_wrappers_of_the_user_are_not_guessed(husky: Path) -> None:
    text = (
        "class Own(nrp.CustomDevice):\n"
        "    def apply(self, neurons, brain, tau=20.0):\n        self.level = 1.0\n"
        "def share(image):\n    return 0.5\n"
        "topic = nrp.PreprocessedTopic('/husky/camera', sensor_msgs.msg.Image, share)\n"
        "@nrp.MapSpikeSink('own', nrp.brain.actors, Own(), tau=50.0)\n"
        "@nrp.MapRobotSubscriber('red', topic)\n"
        "@nrp.MapSpikeSource('eye', nrp.brain.sensors, nrp.poisson)\n"
        "@nrp.Robot2Neuron()\n"
        "def f(t, own, red, eye):\n    eye.rate = own.level * red.value.anything\n"
    )
    assert codes(found_in(husky, text)) == ["NRP239"]
    wrong = text.replace("/husky/camera", "/husky/camra")
    assert codes(found_in(husky, wrong)) == ["NRP239", "NRP212"]


def test_a_computed_topic_name_causes_no_errors(husky: Path) -> None:
    text = (
        "import os\n"
        "@nrp.MapRobotSubscriber('a', Topic(os.environ['A'], std_msgs.msg.Float64))\n"
        "@nrp.MapRobotSubscriber('b', nrp.PreprocessedTopic(os.environ['B'], std_msgs.msg.Float64, abs))\n"
        "@nrp.Neuron2Robot(Topic(os.environ['C']))\n"
        "def f(t, a, b):\n    return a.value + b.value\n"
    )
    assert codes(found_in(husky, text)) == ["NRP239"] * 3


def test_a_parameter_that_a_function_has_twice_is_a_finding_at_its_line(husky: Path, golden: Golden) -> None:
    (finding,) = found_in(husky, "@nrp.Robot2Neuron()\ndef f(t, t):\n    pass\n")
    assert (finding.code.name, finding.line, finding.level) == ("NRP210", 2, Level.ERROR)
    assert "'t'" in finding.message
    golden(finding.message)


VARIABLE = "@nrp.MapVariable('n')\n@nrp.Robot2Neuron()\ndef f(t, n):\n"


def test_arguments_that_a_decorator_does_not_take_are_named_with_those_that_it_takes(husky: Path) -> None:
    function = "@nrp.Robot2Neuron()\ndef f(t, n):\n    n.value = t\n"
    cases = {
        "nrp.MapVariable('n', initial=1)": (
            "nrp.MapVariable: got an unexpected keyword argument 'initial'; did you mean 'initial_value'?"
        ),
        "nrp.MapVariable()": (
            "nrp.MapVariable: missing a required argument: 'parameter_name'; it takes parameter_name, "
        ),
    }
    for decorator, message in cases.items():
        (finding,) = [
            found for found in found_in(husky, f"@{decorator}\n{function}") if found.code.name == "NRP240"
        ]
        assert finding.message.startswith(message)


def test_an_infinite_selector_is_abandoned(husky: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(statements, "_MAX_ITEMS", 1000)
    text = (
        "N = 10000000000\n"
        "@nrp.MapSpikeSource('a', nrp.map_neurons(N, lambda i: nrp.brain.sensors[i % 5]), nrp.poisson)\n"
        "@nrp.Robot2Neuron()\ndef f(t, a):\n    a.rate = 1.0\n"
    )
    assert codes(found_in(husky, text)) == ["NRP239"]


def test_selectors_are_evaluated_on_the_network(husky: Path) -> None:
    text = (
        "FIRST, SIZES = 0, [1, 2]\n"
        "@nrp.MapSpikeSource('a', nrp.resolve(lambda brain: brain.sensors[FIRST:SIZES[1]]), nrp.poisson)\n"
        "@nrp.MapSpikeSource('b', nrp.resolve(lambda brain: brain.sensors[9]), nrp.poisson)\n"
        "@nrp.MapSpikeSource('c', nrp.brain.sensors[nrp.brain.sensors.size], nrp.dc_source)\n"
        "@nrp.MapSpikeSource('d', [nrp.brain.sensors[i] for i in range(4, 6)], nrp.ac_source)\n"
        "@nrp.Robot2Neuron()\ndef f(t, a, b, c, d):\n    a.rate = b.rate = 1.0\n"
        "    c.amplitude = d.phase = 0.1\n"
    )
    found = found_in(husky, text)
    assert [(finding.code.name, finding.line) for finding in found] == [
        ("NRP211", 5), ("NRP211", 4), ("NRP211", 3),
    ]  # fmt: skip


def test_a_source_can_be_set_by_a_method(husky: Path, golden: Golden) -> None:
    text = (
        "@nrp.MapSpikeSource('a', nrp.brain.sensors, nrp.injector)\n"
        "@nrp.Robot2Neuron()\ndef f(t, a):\n    a.inject_spikes()\n"
    )
    assert found_in(husky, text) == []
    (finding,) = found_in(husky, text.replace("inject_spikes", "inject_spike"))
    assert finding.code.name == "NRP240"
    assert "'inject_spikes'" in finding.message
    golden(finding.message)
    assert codes(found_in(husky, text.replace("spikes()", "spikes(1, 2, 3)"))) == ["NRP240"]


def test_packages_beside_the_file_are_known(husky: Path) -> None:
    (husky / "lab").mkdir()
    (husky / "lab" / "sizes.py").write_text("N = 3\n")
    text = (
        "import lab.sizes\nfrom lab import sizes\nfrom lab.sizes import N\n"
        "@nrp.Robot2Neuron()\ndef f(t):\n    print(lab.sizes.N, sizes.N, N)\n"
    )
    assert found_in(husky, text) == []
    finding, *_ = found_in(husky, text.replace("import lab.sizes", "import lap.sizes"))
    assert (finding.code.name, finding.line) == ("NRP218", 1)


def test_packages_with_code_of_their_own_have_their_modules(husky: Path) -> None:
    (husky / "lab").mkdir()
    (husky / "lab" / "__init__.py").write_text("UNIT = 'mV'\n")
    (husky / "lab" / "sizes.py").write_text("N = 3\n")
    text = (
        "import lab\nimport lab.sizes\nfrom lab import UNIT, sizes\nfrom lab.sizes import N\n"
        "@nrp.Robot2Neuron()\ndef f(t):\n    print(lab.sizes.N, lab.UNIT, sizes.N, N, UNIT)\n"
    )
    assert found_in(husky, text) == []


def test_a_module_beside_the_file_is_read_for_its_names(husky: Path, golden: Golden) -> None:
    (husky / "helpers.py").write_text("def scaled(x):\n    return x\n")
    text = "from helpers import scaled, scald\n@nrp.Robot2Neuron()\ndef f(t):\n    scaled(t), scald(t)\n"
    (finding,) = found_in(husky, text)
    golden(finding.message)
    assert (finding.code.name, finding.line, finding.column) == ("NRP218", 1, 1)


def test_all_mistakes_of_one_function_are_found_at_once(husky: Path) -> None:
    text = (
        "@nrp.MapSpikeSink('a', nrp.brain.motors, nrp.population_rate)\n"
        "@nrp.MapSpikeSink('b', nrp.brain.actors[7], nrp.population_rate)\n"
        "@nrp.MapRobotSubscriber('c', Topic('/husky/camra'))\n"
        f"@nrp.Neuron2Robot({TWIST})\n"
        "def f(t, a, b, c, d):\n    return a.rate, b.rate, c.value, d, e\n"
    )
    assert sorted(codes(found_in(husky, text))) == [
        "NRP211",
        "NRP211",
        "NRP212",
        "NRP219",
        "NRP240",
        "NRP246",
    ]


def test_a_topic_between_two_functions_needs_nobody_else(husky: Path) -> None:
    text = (
        "@nrp.Neuron2Robot(Topic('/own', std_msgs.msg.Float64))\ndef sends(t):\n    return 1.0\n"
        "@nrp.MapRobotSubscriber('own', Topic('/own', std_msgs.msg.Float64))\n"
        f"@nrp.Neuron2Robot({TWIST})\n"
        "def reads(t, own):\n    return geometry_msgs.msg.Twist() if own.changed else None\n"
    )
    assert found_in(husky, text) == []


def test_an_inactive_function_is_not_a_second_writer(husky: Path) -> None:
    one = f"@nrp.Neuron2Robot({TWIST})\ndef one(t):\n    return geometry_msgs.msg.Twist()\n"
    text = one + one.replace("one", "two")
    assert codes(found_in(husky, text)) == ["NRP229"]
    assert found_in(husky, f"{text}two.active = False\n") == []


def test_a_lenient_experiment_has_no_errors_in_its_functions(husky: Path) -> None:
    text = (
        "@nrp.MapSpikeSink('a', nrp.brain.motors, nrp.poisson)\n"
        "@nrp.Robot2Neuron()\ndef f(t, a):\n    a.x = b\n"
    )
    assert {finding.level for finding in found_in(husky, text, "strict=false")} == {Level.WARNING}


def test_the_latency_of_each_path_is_reported(husky: Path) -> None:
    notes = [str(finding) for finding in validate_file(husky / "experiment.yaml")]
    assert len(notes) == 1
    assert (
        "/husky/camera -> eye_sensor_transmit -> brain -> linear_twist -> /husky/cmd_vel: 2 steps" in notes[0]
    )
    assert "40 ms in all" in notes[0]


def test_a_population_outside_the_circuit_is_found_in_its_own_line(husky: Path, golden: Golden) -> None:
    file = husky / "experiment.yaml"
    text = file.read_text()
    section = 'populations: {sensors: "0:5", actors: "6:8"}'
    assert section in text
    file.write_text(text.replace(section, 'populations:\n    sensors: "0:5"\n    actors: "6:80"'))
    (finding,) = [one for one in validate_file(husky) if one.level is Level.ERROR]
    assert (finding.code.name, finding.column) == ("NRP211", 13)
    assert file.read_text().splitlines()[(finding.line or 0) - 1] == '    actors: "6:80"'
    golden(validate_file(husky, ["brain.populations.actors='0:99'"])[0].message)


def test_an_experiment_made_in_python_can_be_checked(husky: Path) -> None:
    experiment = load_experiment(husky)
    assert {finding.level for finding in validate(experiment.with_source(type(experiment.source)({})))} == {
        Level.NOTE
    }
