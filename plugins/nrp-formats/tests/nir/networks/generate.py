"""Trains and writes the small reference networks of this folder, with the spikes of snnTorch.

pip install torch snntorch nir nirtorch
python generate.py
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import nir
import numpy as np
import snntorch as snn
import torch
from snntorch.export_nir import _extract_snntorch_module as extract
from snntorch.export_nir import export_to_nir

HERE = Path(__file__).parent
STEPS, SEED = 200, 3


def full(value: float, *shape: int) -> torch.Tensor:
    """Return one value for each cell, which is the form that snnTorch can write."""
    return torch.full(shape, value)


def leaky() -> torch.nn.Module:
    return torch.nn.Sequential(
        torch.nn.Linear(4, 12),
        snn.Leaky(beta=full(0.9, 12), threshold=full(1.0, 12), reset_mechanism="zero", init_hidden=True),
        torch.nn.Linear(12, 3),
        snn.Leaky(beta=full(0.8, 3), threshold=full(0.7, 3), reset_mechanism="zero", init_hidden=True),
    )


def synaptic() -> torch.nn.Module:
    return torch.nn.Sequential(
        torch.nn.Linear(4, 12),
        snn.Synaptic(
            alpha=full(0.6, 12),
            beta=full(0.9, 12),
            threshold=full(2.0, 12),
            reset_mechanism="zero",
            init_hidden=True,
        ),
        torch.nn.Linear(12, 3),
        snn.Synaptic(
            alpha=full(0.5, 3),
            beta=full(0.7, 3),
            threshold=full(1.5, 3),
            reset_mechanism="zero",
            init_hidden=True,
        ),
    )


def convolutional() -> torch.nn.Module:
    return torch.nn.Sequential(
        torch.nn.Conv2d(1, 4, 3, stride=(2, 1), padding=1),
        snn.Leaky(
            beta=full(0.7, 4, 3, 5), threshold=full(1.0, 4, 3, 5), reset_mechanism="zero", init_hidden=True
        ),
        torch.nn.Conv2d(4, 4, 2, padding="same", groups=2, bias=False),
        torch.nn.AvgPool2d(2),
        torch.nn.Flatten(),
        torch.nn.Linear(8, 3),
        snn.Leaky(beta=full(0.8, 3), threshold=full(0.7, 3), reset_mechanism="zero", init_hidden=True),
    )


def written(net: torch.nn.Module, shape: tuple[int, ...]) -> nir.NIRGraph:
    """Return a network as a graph; snnTorch itself cannot write convolutions."""
    if not any(isinstance(layer, torch.nn.Conv2d) for layer in net):
        return export_to_nir(net, torch.zeros(1, *shape))
    nodes: dict[str, nir.NIRNode] = {"input": nir.Input(np.array(shape))}
    x = torch.zeros(1, *shape)
    for index, layer in enumerate(net):
        node = extract(layer)
        if isinstance(layer, torch.nn.Conv2d):
            node = nir.Conv2d(
                tuple(x.shape[2:]),
                layer.weight.detach().numpy(),
                layer.stride,
                layer.padding,
                layer.dilation,
                layer.groups,
                np.zeros(layer.out_channels) if layer.bias is None else layer.bias.detach().numpy(),
            )
        elif isinstance(layer, torch.nn.AvgPool2d):
            node = nir.AvgPool2d(np.array([2, 2]), np.array([2, 2]), np.array([0, 0]))
        elif isinstance(layer, torch.nn.Flatten):
            node = nir.Flatten({"input": np.array(x.shape[1:])}, 0)
        nodes[str(index)] = node
        x = layer(x)
    nodes["output"] = nir.Output(np.array(x.shape[1:]))
    names = list(nodes)
    return nir.NIRGraph(nodes, list(pairwise(names)), type_check=False)


def run(net: torch.nn.Module, inputs: torch.Tensor) -> dict[str, np.ndarray]:
    """Return the spikes of each layer of neurons, shape (steps, cells)."""
    found: dict[str, list[np.ndarray]] = {}
    with torch.no_grad():
        for x in inputs:
            for index, layer in enumerate(net):
                x = layer(x)
                if isinstance(layer, snn.SpikingNeuron):
                    found.setdefault(str(index), []).append(x.numpy().ravel().astype(bool))
    return {name: np.array(spikes) for name, spikes in found.items()}


def main() -> None:
    for make, shape in ((leaky, (4,)), (synaptic, (4,)), (convolutional, (1, 6, 5))):
        torch.manual_seed(SEED)
        net = make()
        for parameter in net.parameters():
            if parameter.ndim > 1:
                parameter.data *= 3.0
        inputs = (torch.rand(STEPS, 1, *shape) < 0.3).float()
        spikes = run(net, inputs)
        for layer in net:
            if isinstance(layer, snn.SpikingNeuron):
                layer.reset_hidden()
        graph = written(net, shape)
        nir.write(HERE / f"{make.__name__}.nir", graph)
        np.savez_compressed(
            HERE / f"{make.__name__}.npz", inputs=inputs.numpy().reshape(STEPS, -1).astype(bool), **spikes
        )
        print(
            make.__name__,
            {n: (type(m).__name__) for n, m in graph.nodes.items()},
            graph.edges,
            {k: int(v.sum()) for k, v in spikes.items()},
        )


if __name__ == "__main__":
    main()
