"""Trains the network of ``trained.nir``: python train.py

A teacher drives away from the nearest obstacle. The network learns its wheel speeds from random scans, by
gradients through time with a surrogate for the derivative of a spike (Neftci et al. 2019, IEEE Signal
Process. Mag. 36:51). NumPy suffices for 34 cells; it takes some seconds. The file is the same each time on a
machine, and differs in its last digits between machines.
"""

from itertools import pairwise
from pathlib import Path

import nir
import numpy as np

from nrp_experiments.slalom_pioneer.sectors import REACH, SECTORS, sectors

HERE = Path(__file__).parent
SEED, BATCHES, BATCH, STEPS, SETTLING = 1, 400, 64, 60, 20
HIDDEN, WHEEL = 24, 5  # cells, and those of each wheel
STEP_S, TAU_S = 1e-3, 10e-3
KEPT = 1.0 - STEP_S / TAU_S
RATE = 600.0 * STEP_S  # spikes in a step of a feeler at contact
LEARNING = 0.005  # of Adam, at first
STEEP = 5.0  # of the derivative that stands for that of a spike
CRUISE = 0.12  # spikes in a step of a wheel's cell without obstacles
ANGLES = np.linspace(-np.pi / 2, np.pi / 2, 181)


def scans(rng, n):
    """Return the ranges of random scenes with up to three pillars and a wall, m, shape ``(n, 181)``."""
    ranges = np.full((n, len(ANGLES)), 2 * REACH)
    for chance in (0.8, 0.4, 0.2):
        distance, angle = rng.uniform(0.25, 1.5, (n, 1)), rng.uniform(-1.7, 1.7, (n, 1))
        aside, radius = ANGLES - angle, rng.uniform(0.1, 0.3, (n, 1))
        inside = radius**2 - (distance * np.sin(aside)) ** 2
        ahead = (inside > 0) & (np.cos(aside) > 0) & (rng.random((n, 1)) < chance)
        reached = distance * np.cos(aside) - np.sqrt(np.maximum(inside, 0.0))
        ranges = np.where(ahead, np.minimum(ranges, np.maximum(reached, 0.05)), ranges)
    distance, normal = rng.uniform(0.25, 1.5, (n, 1)), rng.uniform(-2.5, 2.5, (n, 1))
    toward = np.cos(ANGLES - normal)
    wall = np.where(toward > 0.05, distance / np.maximum(toward, 0.05), np.inf)
    return np.where(rng.random((n, 1)) < 0.5, np.minimum(ranges, wall), ranges)


def taught(felt):
    """Return the spikes in a step of the left and right wheel: the one beside the nearest obstacle is faster.

    Of two that are equally near, the robot turns away from the left one.
    """
    right, left = felt[:, : SECTORS // 2].max(axis=1), felt[:, SECTORS // 2 :].max(axis=1)
    near = np.maximum(right, left)
    faster, slower = CRUISE * (1.0 + 0.5 * near), CRUISE * np.maximum(0.0, 1.0 - 4.0 * near)
    to_the_right = (1.0 + np.tanh((left - right + 0.05) / 0.05)) / 2.0
    away = np.stack([to_the_right, 1.0 - to_the_right], axis=1)
    return slower[:, None] + (faster - slower)[:, None] * away


def emitted(weights, biases, inputs):
    """Return the voltages before resets and the spikes of both layers; shapes ``(steps, batch, cells)``."""
    volts, spikes = [], [inputs]
    for weight, bias in zip(weights, biases, strict=True):
        v, layer_v, layer_s = np.zeros((inputs.shape[1], len(bias))), [], []
        for x in spikes[-1] @ weight.T + bias:
            v = KEPT * v + x
            layer_v.append(v)
            layer_s.append((v > 1.0).astype(float))
            v = v * (1.0 - layer_s[-1])
        volts.append(np.array(layer_v))
        spikes.append(np.array(layer_s))
    return volts, spikes


def gradients(weights, volts, spikes, wanted):
    """Return the gradients of the squared error of the rates, and that error."""
    n, steps = wanted.shape[0], len(spikes[0]) - SETTLING
    rates = spikes[-1][SETTLING:].mean(axis=0).reshape(n, 2, WHEEL).mean(axis=2)
    error = rates - wanted
    onto = np.zeros_like(spikes[-1])
    onto[SETTLING:] = np.repeat(error, WHEEL, axis=1) * (2.0 / (n * steps * WHEEL))
    found = []
    for layer in reversed(range(len(weights))):
        slope = 1.0 / (1.0 + STEEP * np.abs(volts[layer] - 1.0)) ** 2
        later, each = np.zeros_like(onto[0]), np.zeros_like(onto)
        for step in reversed(range(len(onto))):
            later = onto[step] * slope[step] + KEPT * (1.0 - spikes[layer + 1][step]) * later
            each[step] = later
        found.append((np.einsum("tbo,tbi->oi", each, spikes[layer]), each.sum(axis=(0, 1))))
        onto = each @ weights[layer]
    return found[::-1], float(np.square(error).mean())


def trained(rng):
    """Return the weights and biases of both layers."""
    sizes = (SECTORS, HIDDEN, 2 * WHEEL)
    weights = [rng.normal(0.0, 1.0 / np.sqrt(n), (m, n)) for n, m in pairwise(sizes)]
    biases = [np.full(m, 0.1) for m in sizes[1:]]
    values = [*weights, *biases]
    errors = []
    first, second = ([np.zeros_like(value) for value in values] for _ in range(2))
    for batch in range(1, BATCHES + 1):
        felt = sectors(scans(rng, BATCH), ANGLES)
        inputs = (rng.random((STEPS, BATCH, SECTORS)) < 1.0 - np.exp(-RATE * felt)).astype(float)
        volts, spikes = emitted(weights, biases, inputs)
        found, error = gradients(weights, volts, spikes, taught(felt))
        for i, gradient in enumerate([w for w, _ in found] + [b for _, b in found]):  # Adam
            first[i] += 0.1 * (gradient - first[i])
            second[i] += 0.001 * (gradient**2 - second[i])
            step = first[i] / (1 - 0.9**batch) / (np.sqrt(second[i] / (1 - 0.999**batch)) + 1e-12)
            values[i] -= LEARNING * (1.0 - 0.95 * batch / BATCHES) * step
        errors.append(error)
        if batch % 100 == 0:
            print(f"{batch}: the rates are wrong by {np.sqrt(np.mean(errors[-100:])) / STEP_S:.1f} Hz")
    return weights, biases


def main():
    """Train, and write the file."""
    weights, biases = trained(np.random.default_rng(SEED))
    nodes = {"feelers": nir.Input(np.array([SECTORS])), "output": nir.Output(np.array([2 * WHEEL]))}
    for name, weight, bias in zip(("hidden", "wheels"), weights, biases, strict=True):
        each = np.ones(len(bias))
        nodes[f"to {name}"] = nir.Affine(weight, bias)
        nodes[name] = nir.LIF(TAU_S * each, TAU_S / STEP_S * each, 0 * each, each, 0 * each)
    names = ["feelers", "to hidden", "hidden", "to wheels", "wheels", "output"]
    metadata = {"dt": STEP_S, "method": "euler"}
    edges = list(pairwise(names))
    nir.write(HERE / "trained.nir", nir.NIRGraph(nodes, edges, metadata))


if __name__ == "__main__":
    main()
