"""Afferents drive the spinal cord and motoneurons the muscles; a load on the hand tests the reflex."""

import hbp_nrp_client.tf_framework as nrp
import numpy as np
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

MUSCLES = "shoulder_flexor", "shoulder_extensor", "elbow_flexor", "elbow_extensor"
FIBRES, MOTONEURONS, IB = 40, 60, 15
FORCE_N, LENGTH_M, LOAD_S = 12.0, 0.3, 1.0  # on the hand, to the left
WINDOW_S = 0.1  # in which a burst of the reflex comes
SETTLED_S = 0.5  # after the load
BIN_MS, SMOOTH = 4.0, 4
BINS = round((LOAD_S + WINDOW_S) * 1e3 / BIN_MS)


def of(cells, size):
    """Return the selectors of the cells of each muscle."""
    return {name: cells[slice(size * n, size * (n + 1))] for n, name in enumerate(MUSCLES)}


SPINDLE = nrp.tf_lib.Spindle(ia_bias=10.0, ia_emg=0.0, dead_zone=2.0)
ORGAN = nrp.tf_lib.TendonOrgan()

nrp.map_afferents("Ia", "/arm/muscles", of(nrp.brain.ia, FIBRES), model=SPINDLE, weight=1.6, delay=12.0)
nrp.map_afferents("Ib", "/arm/muscles", of(nrp.brain.ib, IB), model=ORGAN, weight=0.8, delay=14.0)
nrp.map_motoneurons("/arm/muscles", of(nrp.brain.motoneurons, MOTONEURONS), tau_rise=2.0, tau_fall=10.0)


@nrp.MapRobotPublisher("shoulder", nrp.Topic("/arm/shoulder/cmd_effort", Float64))
@nrp.MapRobotPublisher("elbow", nrp.Topic("/arm/elbow/cmd_effort", Float64))
@nrp.Neuron2Robot()
def load(t, shoulder, elbow):
    """Pull at the hand."""
    force = FORCE_N if t >= LOAD_S else 0.0
    shoulder.send_message(Float64(2 * LENGTH_M * force))
    elbow.send_message(Float64(LENGTH_M * force))


@nrp.MapSpikeSink("pools", nrp.brain.motoneurons, nrp.spike_recorder, use_ids=False)
@nrp.MapVariable("bins", initial_value=())
@nrp.MapRobotPublisher("latency", nrp.Topic("/reflex/latency", Float64))
@nrp.MapRobotPublisher("burst", nrp.Topic("/reflex/burst", Float64))
@nrp.Neuron2Robot()
def judge(t, pools, bins, latency, burst):
    """Publish when the pools of the stretched muscles begin to fire more (ms), and by how much (Hz)."""
    if len(bins.value) >= BINS:
        return  # measured
    muscles = pools.times[:, 0].astype(int) // MOTONEURONS
    bins.value = (*bins.value, int((muscles % 2 == 1).sum()))  # extensors, which the load stretches
    if len(bins.value) < BINS:
        return
    counts = np.convolve(bins.value, np.ones(SMOOTH) / SMOOTH, "valid")  # each ends with its bin
    start = round(LOAD_S * 1e3 / BIN_MS) - SMOOTH + 1
    before, after = counts[start // 2 : start], counts[start : start + round(WINDOW_S * 1e3 / BIN_MS)]
    onsets = np.flatnonzero(after > before.mean() + 4 * before.std())
    latency.send_message(Float64(BIN_MS * (onsets[0] + 1) if len(onsets) else 1e3))
    burst.send_message(Float64((after.mean() - before.mean()) / (2 * MOTONEURONS * BIN_MS * 1e-3)))


@nrp.MapRobotSubscriber("joints", nrp.Topic("/arm/joint_states", JointState))
@nrp.MapVariable("angles", initial_value=())
@nrp.MapRobotPublisher("swing", nrp.Topic("/reflex/swing", Float64))
@nrp.Neuron2Robot()
def watch(t, joints, angles, swing):
    """Publish how much the shoulder swings when it should have settled, as a standard deviation in rad."""
    if joints.value is None or t < LOAD_S + SETTLED_S:
        return
    angles.value = (*angles.value, joints.value.position[joints.value.name.index("shoulder")])
    if t >= LOAD_S + 2 * SETTLED_S - 2e-3 * BIN_MS:
        swing.send_message(Float64(float(np.std(angles.value))))
