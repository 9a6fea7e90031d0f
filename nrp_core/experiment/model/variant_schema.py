"""Interventions in a brain and controls of its wiring, in the form of the experiment file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from nrp_core.clock import seconds
from nrp_core.experiment.model.section import Section
from nrp_core.network.controls import CONTROLS, Control, with_matched_cells_silenced
from nrp_core.network.interventions import Intervention
from nrp_core.quantities import DurationNs, RateHz, TimeNs


class ScaleSection(Section):
    """Weights that are multiplied."""

    sources: str | None = None
    """The cells before the synapses, a population or named group; by default any cell."""
    targets: str | None = None
    """The cells behind the synapses; by default any cell."""
    by: Annotated[float, Field(ge=0)]
    """The factor."""

    @model_validator(mode="after")
    def _some_cells(self) -> ScaleSection:
        if self.sources is None and self.targets is None:
            raise ValueError("needs 'sources', 'targets' or both")
        return self


class ActivateSection(Section):
    """Cells that are driven by Poisson trains of their own."""

    cells: str
    """The cells, a population or named group."""
    rate: Annotated[RateHz, Field(ge=0)]
    """Rate of each train."""
    weight: float
    """Weight of each spike, in the unit of the cells' synapses: uS, nA or mV."""
    duration: DurationNs | None = None
    """How long it lasts; by default to the end."""


class InterventionSection(Section):
    """An intervention in the brain."""

    alternatives = ("silence", "lesion", "scale", "activate")

    silence: str | None = None
    """Cut all synapses from these cells, a population or named group."""
    lesion: str | None = None
    """Cut all synapses from and to these cells."""
    scale: ScaleSection | None = None
    """Multiply weights."""
    activate: ActivateSection | None = None
    """Drive cells."""
    at: TimeNs = 0
    """When: at the first step not before this time; by default from the start."""

    def idle(self, duration_ns: int) -> str:
        """Return why it has no effect in a run of a duration; empty if it may have one."""
        if self.at >= duration_ns:
            return f"acts at {seconds(self.at):g} s, and the run ends at {seconds(duration_ns):g} s"
        if self.scale is not None and self.scale.by == 1:
            return "multiplies weights by 1"
        if self.activate is not None and 0 in (self.activate.rate, self.activate.weight):
            return f"sends {self.activate.rate:g} spikes a second of weight {self.activate.weight:g}"
        return ""

    @property
    def change(self) -> Intervention | None:
        """The change of weights; None if it drives cells."""
        if self.silence is not None:
            return Intervention.silence(self.silence)
        if self.lesion is not None:
            return Intervention.lesion(self.lesion)
        if self.scale is not None:
            return Intervention(self.scale.sources, self.scale.targets, self.scale.by)
        return None

    @property
    def driven(self) -> str | None:
        """The name of the cells that it drives; None if it changes weights."""
        return None if self.activate is None else self.activate.cells

    @property
    def name(self) -> str:
        """The kind of the intervention and its cells."""
        if self.scale is not None:
            ends = (self.scale.sources, self.scale.targets and f"to_{self.scale.targets}")
            return "_".join(["scale", *filter(None, ends)])
        if self.activate is not None:
            return f"activate_{self.activate.cells}"
        return f"silence_{self.silence}" if self.silence is not None else f"lesion_{self.lesion}"


class WiringControl(Section):
    """A control: a network that shares some statistics with the brain, or all but some cells."""

    alternatives = ("rewire", "shuffle", "silence", "silence_matched")

    rewire: Literal["degree_preserving"] | None = None
    """Exchange the targets of the synapses of each projection; every cell keeps its numbers of synapses."""
    shuffle: Literal["signs", "weights"] | None = None
    """Exchange the signs of cells, or the weights of the synapses of each projection."""
    silence: str | None = None
    """Cut all synapses from these cells, a population or named group."""
    silence_matched: str | None = None
    """Cut all synapses from as many other cells of the same population and quarter of out-degrees."""

    @property
    def name(self) -> str:
        """The kind of the control, as in the file."""
        kind = next(kind for kind in self.alternatives if getattr(self, kind) is not None)
        return f"{kind}: {getattr(self, kind)}"

    @property
    def control(self) -> Control:
        """The function that makes the network."""
        if self.silence is not None:
            change = Intervention.silence(self.silence)
            return lambda network, seeds: change.of(network)  # noqa: ARG005
        if (cells := self.silence_matched) is not None:
            return lambda network, seeds: with_matched_cells_silenced(network, cells, seeds)
        kind, _, statistic = self.name.partition(": ")
        return CONTROLS[kind, statistic]
