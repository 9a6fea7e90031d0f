"""Motoneurons drive the legs and afferents their spinal cord; a pull at the left hip tests the rhythm.

A step begins when the flexor half centre of its leg becomes active. The pull extends the left hip at the
same phase of the rhythm in each run, shortly after the leg's flexion ends. If afferents set the phase, the
next step comes early and the following ones are short.
"""

import hbp_nrp_client.tf_framework as nrp
import numpy as np
from std_msgs.msg import Float64

LEGS = "left", "right"
KINDS = "hip_flexor", "knee_flexor", "ankle_flexor", "hip_extensor", "knee_extensor", "ankle_extensor"
CELLS, FIBRES, MOTONEURONS = 20, 20, 20
ACTIVE_HZ, SILENT_HZ = 20.0, 5.0  # rates of a cell at which flexion begins and ends
SETTLED_S, PULL_S = (
    2.5,
    6.0,
)  # the rhythm counts from one time on; the pull comes in the first step after the other
TORQUE_NM, DELAY_S, DURATION_S = 150.0, 0.15, 0.2  # of the pull, which comes after the end of flexion
SHIFTED = 2  # further steps until the shift is measured again


def of(cells, size, names):
    """Return the selectors of the cells of each muscle."""
    return {name: cells[slice(size * n, size * (n + 1))] for n, name in enumerate(names)}


SPINDLE = nrp.tf_lib.Spindle(ia_bias=-20.0, ia_emg=0.0, dead_zone=2.0)
ORGAN = nrp.tf_lib.TendonOrgan(gain=30.0, scale=50.0)
HIPS, ANKLES = ([f"{leg}_{kind}" for leg in LEGS] for kind in ("hip_flexor", "ankle_extensor"))
POOLS = of(nrp.brain.motoneurons, MOTONEURONS, [f"{leg}_{kind}" for leg in LEGS for kind in KINDS])

nrp.map_afferents(
    "Ia", "/legs/muscles", of(nrp.brain.ia, FIBRES, HIPS), model=SPINDLE, weight=1.6, delay=12.0
)
nrp.map_afferents(
    "Ib", "/legs/muscles", of(nrp.brain.ib, FIBRES, ANKLES), model=ORGAN, weight=0.8, delay=14.0
)
nrp.map_motoneurons("/legs/muscles", POOLS, tau_rise=5.0, tau_fall=20.0)


def follow(leg, rate, t):
    """Note when flexion begins and ends; two thresholds keep noise from counting."""
    flexes = rate > (SILENT_HZ if leg["flexes"] else ACTIVE_HZ)
    if flexes != leg["flexes"]:
        leg["begins" if flexes else "ends"].append(t)
    leg["flexes"] = flexes


@nrp.MapSpikeSink("left", nrp.brain.flexors[0:20], nrp.population_rate, tau_fall=30.0)
@nrp.MapSpikeSink("right", nrp.brain.flexors[20:40], nrp.population_rate, tau_fall=30.0)
@nrp.MapVariable("memory", initial_value=None)
@nrp.MapRobotPublisher("hip", nrp.Topic("/legs/left_hip/cmd_effort", Float64))
@nrp.MapRobotPublisher("frequency", nrp.Topic("/rhythm/frequency", Float64))
@nrp.MapRobotPublisher("alternation", nrp.Topic("/rhythm/alternation", Float64))
@nrp.MapRobotPublisher("advance", nrp.Topic("/rhythm/advance", Float64))
@nrp.MapRobotPublisher("reset", nrp.Topic("/rhythm/reset", Float64))
@nrp.Neuron2Robot()
def judge(t, left, right, memory, hip, frequency, alternation, advance, reset):
    """Pull once, and publish the rhythm before (Hz, phase of the right leg) and its shift after (periods)."""
    legs = memory.value or {leg: {"flexes": False, "begins": [], "ends": []} for leg in LEGS}
    memory.value = legs
    if legs.get("measured"):
        return
    for leg, sink in zip(LEGS, (left, right), strict=True):
        follow(legs[leg], sink.rate / CELLS, t)
    ends = [each for each in legs["left"]["ends"] if each >= PULL_S]
    pull = ends[0] + DELAY_S if ends else t + 1.0
    hip.send_message(Float64(-TORQUE_NM if pull <= t < pull + DURATION_S else 0.0))
    if t < pull:
        return
    begins = np.array(legs["left"]["begins"])
    before, after = begins[(begins >= SETTLED_S) & (begins < pull)], begins[begins >= pull]
    period = np.diff(before).mean()
    frequency.send_message(Float64(1 / period))
    others = [each for each in legs["right"]["begins"] if before[0] <= each < before[-1]]
    phases = np.interp(others, before, np.arange(len(before))) % 1.0
    alternation.send_message(Float64(phases.mean()))
    shifts = (before[-1] - after) / period + np.arange(1, len(after) + 1)
    if len(after):
        advance.send_message(Float64(shifts[0]))
    if len(after) > SHIFTED and t >= pull + DURATION_S:
        reset.send_message(Float64(shifts[SHIFTED]))
        legs["measured"] = True
