"""Monitors in a recording, read by a program of others and by functions of the Neurorobotics Platform."""

import csv
from pathlib import Path

import nrp_experiments
from golden import Golden
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import nrp_core
from nrp_core.recording.layout import MCAP_NAME
from nrp_core.recording.recording import Recording

SHIPPED = Path(nrp_experiments.__file__).parent / "braitenberg_husky"
EXPERIMENT = f"""
name: monitors
timestep: 20 ms
duration: 0.2 s
brain: {{backend: event, model: {SHIPPED}/brain.py, populations: {{sensors: "0:5", actors: "6:8"}}}}
world:
  backend: mujoco
  scene: {SHIPPED}/room.sdf
  robots: {{husky: {{model: {SHIPPED}/husky.sdf, pose: [0, 0, 0.2, 0, 0, 0]}}}}
transfer_functions: [monitors.py]
"""
FUNCTIONS = """
import cle_ros_msgs.msg


@nrp.MapSpikeSource("drive", nrp.brain.sensors, nrp.dc_source)
@nrp.Robot2Neuron()
def excite(t, drive):
    drive.amplitude = 2.0


@nrp.NeuronMonitor(nrp.brain.sensors, nrp.spike_recorder)
def spikes(t):
    return True


@nrp.NeuronMonitor(nrp.brain.sensors, nrp.population_rate)
def rates(t):
    return True


@nrp.MapRobotSubscriber("seen", Topic("/monitor/spike_recorder", cle_ros_msgs.msg.SpikeEvent))
@nrp.MapCSVRecorder("rows", filename="seen.csv", headers=["time", "neurons", "monitor", "population"])
@nrp.Robot2Neuron()
def read_as_of_old(t, seen, rows):
    event = seen.value
    if event is not None:
        rows.record_entry(event.simulationTime, event.neuronCount, event.monitorName, event.populationLabel)
"""


def test_monitors_are_read_by_others_and_keep_their_names_in_experiments(tmp_path: Path) -> None:
    (tmp_path / "monitors.py").write_text(FUNCTIONS)
    (tmp_path / "monitors.yaml").write_text(EXPERIMENT)
    result = nrp_core.run(tmp_path / "monitors.yaml", record=tmp_path / "out")
    assert result.complete
    with (tmp_path / "out" / MCAP_NAME).open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        read = [(channel.topic, message) for _, channel, _, message in reader.iter_decoded_messages()]
    spikes = [message for topic, message in read if topic == "/monitor/spike_recorder"]
    assert {(one.monitor_name, one.neuron_count, one.population_label) for one in spikes} == {
        ("spikes", 5, spikes[0].population_label)
    }
    assert sum(len(one.spikes) for one in spikes) == result.spikes["sensors"] > 0
    rates = [message for topic, message in read if topic == "/monitor/population_rate"]
    assert [round(one.simulation_time / 0.02) for one in rates] == list(range(1, len(rates) + 1))
    with (tmp_path / "out" / "csv" / "seen.csv").open() as table:
        rows = list(csv.DictReader(table))
    assert {(row["neurons"], row["monitor"]) for row in rows} == {("5", "spikes")}
    assert [float(row["time"]) for row in rows] == [one.simulation_time for one in spikes[: len(rows)]]


def test_the_rows_of_functions_are_part_of_the_recording(tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "monitors.py").write_text(FUNCTIONS)
    (tmp_path / "monitors.yaml").write_text(EXPERIMENT)
    out = tmp_path / "out"
    nrp_core.run(tmp_path / "monitors.yaml", record=out)
    check = Recording(out).check()
    assert (check.intact, check.unlisted) == (True, ())
    rows = out / "csv" / "seen.csv"
    rows.write_text(rows.read_text().replace("0.02", "0.03"))
    (flaw,) = Recording(out).check().flaws
    golden(str(flaw))
