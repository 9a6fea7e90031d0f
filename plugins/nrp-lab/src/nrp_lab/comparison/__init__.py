"""Does a finding depend on the simulator? A grid of brains, worlds and seeds is run, measured and judged.

::

    grid ──runs──> recordings ──signals──> metrics ──statistics──> judgement ──> report
                       └──────divergence: where two of them first differ ────────┘

The names that authors of metrics need, each imported at its first use.
"""

from nrp_core.utilities import lazily

TYPE_CHECKING = False  # known to type checkers; typing itself takes 5 ms to import
if TYPE_CHECKING:
    from nrp_lab.comparison.divergence import NOISE as NOISE
    from nrp_lab.comparison.metric import DistanceMetric as DistanceMetric
    from nrp_lab.comparison.metric import Margin as Margin
    from nrp_lab.comparison.metric import ScalarMetric as ScalarMetric
    from nrp_lab.comparison.signals import RunSignals as RunSignals
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
