"""The figures that scripts of NEST draw with Matplotlib: rasters, voltages, and nodes with positions."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

# ruff: noqa: N802 - the names of NEST


def plot_modules(nest: ModuleType) -> dict[str, Any]:
    """Return ``raster_plot``, ``voltage_trace``, ``visualization`` and the functions that draw positions."""
    drawing = _Drawing(nest)
    raster, trace, graph = (ModuleType(f"nest.{name}") for name in _MODULES)
    vars(raster).update(from_device=drawing.raster, show=_show)
    vars(trace).update(from_device=drawing.voltages, show=_show)
    vars(graph).update(plot_network=lambda *_nodes, **_options: None)
    names = ("PlotLayer", "PlotTargets", "PlotSources", "PlotProbabilityParameter")
    functions = {name: getattr(drawing, name) for name in names}
    return {"raster_plot": raster, "voltage_trace": trace, "visualization": graph, **functions}


_MODULES = ("raster_plot", "voltage_trace", "visualization")


def _show() -> None:
    import matplotlib.pyplot as plt

    plt.show()


class _Drawing:
    def __init__(self, nest: ModuleType) -> None:
        self._nest = nest

    def raster(
        self, detec: Any, hist: bool = False, hist_binwidth: float = 5.0, title: str = "", **_: Any
    ) -> Any:
        """Draw the spikes of a recorder, with a histogram of rates if ``hist``."""
        import matplotlib.pyplot as plt

        events = self._nest.GetStatus(detec)[0]["events"]
        times, senders = (np.asarray(events.get(name, ())) for name in ("times", "senders"))
        figure, axes = plt.subplots(1 + hist, 1, sharex=True, squeeze=False)
        axes[0, 0].plot(times, senders, ".")
        axes[0, 0].set(ylabel="neuron", title=title)
        if hist and len(times):
            bins = np.arange(times.min(), times.max() + 2 * hist_binwidth, hist_binwidth)
            counts = np.histogram(times, bins)[0]
            rates = counts / (len(np.unique(senders)) * hist_binwidth * 1e-3)
            axes[1, 0].bar(bins[:-1], rates, hist_binwidth, align="edge")
            axes[1, 0].set(ylabel="rate (Hz)")
        axes[-1, 0].set(xlabel="time (ms)")
        return figure

    def voltages(self, detec: Any, neurons: Any = None, title: str = "", **_: Any) -> Any:
        """Draw the voltages that a recorder has of each neuron."""
        import matplotlib.pyplot as plt

        events = self._nest.GetStatus(detec)[0]["events"]
        senders = np.asarray(events["senders"])
        for sender in np.unique(senders):
            chosen = senders == sender
            plt.plot(
                np.asarray(events["times"])[chosen], np.asarray(events["V_m"])[chosen], label=str(sender)
            )
        plt.xlabel("time (ms)")
        plt.ylabel("V_m (mV)")
        plt.title(title)
        return plt.gcf()

    def PlotLayer(
        self, layer: Any, fig: Any = None, nodecolor: str = "b", nodesize: float = 20, **_: Any
    ) -> Any:
        """Draw the positions of nodes."""
        return self._scatter(np.atleast_2d(self._nest.GetPosition(layer)), fig, nodecolor, nodesize)

    def PlotTargets(
        self, src_nrn: Any, tgt_layer: Any, syn_type: Any = None, fig: Any = None, src_color: str = "red",
        src_size: float = 50, tgt_color: str = "blue", tgt_size: float = 20, **_options: Any,
    ) -> Any:  # fmt: skip
        """Draw a node and its targets."""
        figure = self._scatter(np.atleast_2d(self._nest.GetPosition(src_nrn)), fig, src_color, src_size)
        found = self._nest.GetTargetPositions(src_nrn, tgt_layer, syn_type)[0]
        return self._scatter(_rows(found), figure, tgt_color, tgt_size)

    def PlotSources(
        self, src_layer: Any, tgt_nrn: Any, syn_type: Any = None, fig: Any = None, **_: Any
    ) -> Any:
        """Draw a node and its sources."""
        figure = self._scatter(np.atleast_2d(self._nest.GetPosition(tgt_nrn)), fig, "red", 50)
        found = self._nest.GetSourcePositions(src_layer, tgt_nrn, syn_type)[0]
        return self._scatter(
            np.array(found).reshape(-1, 2 if not found else len(found[0])), figure, "blue", 20
        )

    def PlotProbabilityParameter(self, source: Any, *_values: Any, **_options: Any) -> None:
        """Draw nothing."""

    def _scatter(self, positions: Any, figure: Any, color: str, size: float) -> Any:
        import matplotlib.pyplot as plt

        figure = figure or plt.figure()
        if not figure.axes:
            figure.add_subplot(111, **({"projection": "3d"} if positions.shape[1] == 3 else {}))
        figure.axes[0].scatter(*positions.T, s=size, c=color)
        return figure


def _rows(positions: Any) -> Any:
    return np.array(positions) if positions else np.empty((0, 2))
