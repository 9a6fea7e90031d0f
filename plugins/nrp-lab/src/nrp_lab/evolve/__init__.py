"""Search for the settings of an experiment that are best by an objective.

::

    file ──ranges──> optimiser ──points──> sweep ──rows──> objective ──values──> optimiser ──> ... ──> best

A generation is a sweep that grows by the points of the optimiser. So it runs where sweeps run, and its
journal is the checkpoint: a search that was stopped is repeated, without the runs that are in the journal.
"""

from nrp_core.utilities import lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing takes 5 ms
if TYPE_CHECKING:
    from nrp_lab.evolve.evolution import Evolved as Evolved
    from nrp_lab.evolve.evolution import evolve as evolve
    from nrp_lab.evolve.optimisers import Optimiser as Optimiser
    from nrp_lab.evolve.optimisers import Space as Space
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
