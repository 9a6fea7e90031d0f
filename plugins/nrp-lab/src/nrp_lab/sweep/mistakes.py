"""Collect mistakes in a file of many runs with their places."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.tree import Key
from nrp_core.findings import Code, InvalidExperimentError


class Mistakes(Collector):
    """Collects errors, those of the experiment as well, with their places in a file that varies it."""

    @contextmanager
    def at(self, *keys: Key) -> Iterator[None]:
        """Collect the error of a block; findings without a place get the place of these keys."""
        with self.during(Code.NRP202, *keys):
            try:
                yield
            except InvalidExperimentError as error:
                self.place((one for one in error.findings if one not in self.findings), *keys)
