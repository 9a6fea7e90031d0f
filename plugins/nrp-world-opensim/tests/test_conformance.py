"""The conformance kit puts robots in SDF into a room, which OpenSim cannot move."""

from golden import Golden
from nrp_conformance.proof import Proof
from nrp_core.errors import CapabilityError


def test_the_kit_says_that_it_does_not_apply_and_why(golden: Golden) -> None:
    with golden.raises(CapabilityError, match="'opensim'"):
        Proof("world", "opensim", {}, "contract").report([])
