"""The whole conformance suite, with real Drake."""

from nrp_conformance import FullWorldTests
from nrp_world_drake import DrakeBackend


class TestDrake(FullWorldTests):
    backend_name = "drake"

    @classmethod
    def make_backend(cls) -> DrakeBackend:
        return DrakeBackend()
