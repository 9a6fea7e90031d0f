"""Files of transfer functions in an experiment: imports, topics between functions, latencies."""

from __future__ import annotations

from pathlib import Path

from golden import Golden

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


def test_a_parameter_that_a_function_has_twice_is_a_finding_at_its_line(husky: Path, golden: Golden) -> None:
    (finding,) = found_in(husky, "@nrp.Robot2Neuron()\ndef f(t, t):\n    pass\n")
    assert (finding.code.name, finding.line, finding.level) == ("NRP210", 2, Level.ERROR)
    assert "'t'" in finding.message
    golden(finding.message)


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
        "import lab.sizes\nfrom lab.sizes import N\n"
        "@nrp.Robot2Neuron()\ndef f(t):\n    print(lab.sizes.N, N)\n"
    )
    assert found_in(husky, text) == []
    finding, *_ = found_in(husky, text.replace("import lab.sizes", "import lap.sizes"))
    assert (finding.code.name, finding.line) == ("NRP210", 1)


def test_packages_with_code_of_their_own_have_their_modules(husky: Path) -> None:
    (husky / "lab").mkdir()
    (husky / "lab" / "__init__.py").write_text("UNIT = 'mV'\n")
    (husky / "lab" / "sizes.py").write_text("N = 3\n")
    text = (
        "import lab\nimport lab.sizes\nfrom lab import UNIT, sizes\nfrom lab.sizes import N\n"
        "@nrp.Robot2Neuron()\ndef f(t):\n    print(lab.sizes.N, lab.UNIT, sizes.N, N, UNIT)\n"
    )
    assert found_in(husky, text) == []


def test_a_topic_between_two_functions_needs_no_other_publisher(husky: Path) -> None:
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
        "@nrp.MapSpikeSource('a', nrp.brain.motors, nrp.poisson)\n"
        "@nrp.Robot2Neuron()\ndef f(t, a):\n    a.rate = 1.0\n"
        "@nrp.Robot2Neuron()\ndef g(t):\n    b\n"
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
