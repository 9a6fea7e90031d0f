"""A world may leave out optional methods: the four methods that cannot be derived are enough."""

from dataclasses import replace

from nrp_conformance import WorldContractTests
from nrp_world_minimal.engine import MinimalBackend, MinimalEngine

from nrp_core.world import Engine


class FewestEngine(MinimalEngine):
    _do_save = Engine._do_save
    _do_restore = Engine._do_restore


class FewestBackend(MinimalBackend):
    def capabilities(self, options):
        return replace(super().capabilities(options), snapshot=False, links=False, renderers=())

    def engine(self, scene, *, seed, options):
        return FewestEngine(scene, self.capabilities(options), seed=seed)


class TestFewest(WorldContractTests):
    @classmethod
    def make_backend(cls):
        return FewestBackend()
