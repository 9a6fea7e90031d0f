"""A brain may leave out optional methods: the six methods that cannot be derived are enough."""

from dataclasses import replace

from nrp_brain_minimal.brain import MinimalBackend, MinimalBrain
from nrp_conformance import BrainContractTests

from nrp_core.brain import Brain


class FewestBrain(MinimalBrain):
    _do_read_state = Brain._do_read_state
    _do_save = Brain._do_save
    _do_restore = Brain._do_restore


class FewestBackend(MinimalBackend):
    def capabilities(self, options):
        return replace(super().capabilities(options), state_variables=frozenset(), snapshot=False)

    def open(self, network, *, seed, options):
        return FewestBrain(network, seed=seed, capabilities=self.capabilities(options))


class TestFewest(BrainContractTests):
    @classmethod
    def make_backend(cls):
        return FewestBackend()
