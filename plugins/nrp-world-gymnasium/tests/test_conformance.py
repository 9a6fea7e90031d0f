"""The conformance kit puts robots into a room, which an environment does not have."""

import pytest
from nrp_conformance.proof import Proof

from nrp_core.errors import CapabilityError


@pytest.mark.parametrize("options", [{}, {"env": "CartPole-v1"}])
def test_the_kit_says_that_it_does_not_apply_and_why(installed: None, options: dict[str, str]) -> None:
    with pytest.raises(
        CapabilityError, match=r"do not apply to world 'gymnasium', and none was run: .*own scene"
    ):
        Proof("world", "gymnasium", options, "contract").report([])
