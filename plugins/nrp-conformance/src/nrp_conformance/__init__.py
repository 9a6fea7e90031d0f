"""The conformance kit: one suite for any brain and one for any world, using only their interfaces.

Three lines in the tests of a backend run it::

    from nrp_conformance import BrainBackendTests

    class TestMine(BrainBackendTests):
        backend_name = "mine"

or, once it is installed, by ``nrp conformance brain mine``. The kit needs pytest and hypothesis.
"""

from nrp_core.utilities import lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing takes 5 ms
if TYPE_CHECKING:
    from nrp_conformance.brain import BrainBackendTests as BrainBackendTests
    from nrp_conformance.brain import BrainContractTests as BrainContractTests
    from nrp_conformance.brain import FullBrainTests as FullBrainTests
    from nrp_conformance.brain.comparison import BrainCrossTests as BrainCrossTests
    from nrp_conformance.world import FullWorldTests as FullWorldTests
    from nrp_conformance.world import OwnSceneTests as OwnSceneTests
    from nrp_conformance.world import WorldBackendTests as WorldBackendTests
    from nrp_conformance.world import WorldContractTests as WorldContractTests
    from nrp_conformance.world.comparison import WorldCrossTests as WorldCrossTests
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
