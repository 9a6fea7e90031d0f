"""What a world need not offer it can leave out: the four methods that cannot be derived are enough."""

from dataclasses import replace

from nrp_world_minimal.world import MinimalBackend, MinimalWorld

from nrp_core.conformance import WorldBackendTests
from nrp_core.world.interface import World


class FewestWorld(MinimalWorld):
    _do_save = World._do_save
    _do_restore = World._do_restore


class FewestBackend(MinimalBackend):
    def capabilities(self, options):
        return replace(super().capabilities(options), snapshot=False, links=False, renderers=())

    def open(self, scene, *, seed, options):
        return FewestWorld(scene, seed=seed, capabilities=self.capabilities(options))


class TestFewest(WorldBackendTests):
    @classmethod
    def make_backend(cls):
        return FewestBackend()
