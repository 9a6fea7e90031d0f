"""The conformance kit puts robots into a room, which an environment does not have."""

import pytest
from golden import Golden
from nrp_conformance.proof import Proof

from nrp_core.errors import CapabilityError


@pytest.mark.parametrize("options", [{}, {"env": "CartPole-v1"}])
def test_the_kit_says_that_it_does_not_apply_and_why(
    installed: None, options: dict[str, str], golden: Golden
) -> None:
    with golden.raises(CapabilityError, match="'gymnasium'"):
        Proof("world", "gymnasium", options, "contract").report([])
