"""What a run is judged by: named numbers with units that it has at each time, and conditions on them.

An observable is one class or function, found by an entry point of the group ``nrp_core.observables``.
"""

from nrp_core._support.lazy import lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing would take 5 ms
if TYPE_CHECKING:
    from nrp_core.observables.condition import Condition as Condition
    from nrp_core.observables.condition import Sentence as Sentence
    from nrp_core.observables.observable import OBSERVABLES as OBSERVABLES
    from nrp_core.observables.observable import Observable as Observable
    from nrp_core.observables.observable import Surroundings as Surroundings
    from nrp_core.observables.observable import observable_of as observable_of
    from nrp_core.observables.observable import topic_of as topic_of
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
