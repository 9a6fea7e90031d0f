"""A suite that nobody has seen fail proves nothing: each bug is found by exactly the tests named with it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import brains_in_kind
import brains_in_limits
import brains_in_number
import brains_in_precision
import brains_in_time
import pytest
import worlds_in_body
import worlds_in_change
import worlds_in_motion
import worlds_in_sight
from nrp_conformance import BrainBackendTests, WorldBackendTests
from nrp_conformance.base import BackendTests
from nrp_conformance.report import Outcome
from nrp_conformance.run import run_tests
from small_brain import SmallBackend

_BRAINS = brains_in_time, brains_in_kind, brains_in_number, brains_in_precision, brains_in_limits
BRAINS = {brain: tests for module in _BRAINS for brain, tests in module.FOUND_BY.items()}
_WORLDS = worlds_in_motion, worlds_in_sight, worlds_in_change, worlds_in_body
WORLDS = {world: tests for module in _WORLDS for world, tests in module.FOUND_BY.items()}


def failing(suite: type[BackendTests], backend: type, only: Collection[str] = ()) -> set[str]:
    """Return the tests that fail, without their parameters; of all tests, or only of some."""
    tests = type("Wrong", (suite,), {"make_backend": classmethod(lambda cls: backend())})
    results = run_tests(tests, only, traceback="native")
    assert len(results) > 80 or only
    return {r.test.partition("[")[0] for r in results if r.outcome is Outcome.FAILED}


def named(backend: type) -> str:
    return backend.__name__


def test_there_are_enough_wrong_backends():
    assert len(BRAINS) + len(WORLDS) >= 100


@pytest.mark.heavy
def test_a_brain_that_rounds_delays_to_nanoseconds_is_right():
    class RoundsDelaysToNanoseconds(brains_in_precision.RoundsDelaysToMicroseconds):
        def stored(self, projection):
            return replace(projection, delay_ms=projection.delay_ms.round(6))

    assert failing(BrainBackendTests, RoundsDelaysToNanoseconds) == set()


def test_the_brain_that_wrong_ones_are_made_from_is_right():
    assert failing(BrainBackendTests, SmallBackend) == set()  # the minimal brain has tests of its own


@pytest.mark.one_of(8)
@pytest.mark.parametrize("backend", BRAINS, ids=named)
def test_a_wrong_brain_fails_where_it_should(backend: type):
    assert failing(BrainBackendTests, backend, BRAINS[backend]) == BRAINS[backend]


@pytest.mark.one_of(8)
@pytest.mark.parametrize("backend", WORLDS, ids=named)
def test_a_wrong_world_fails_where_it_should(backend: type):
    assert failing(WorldBackendTests, backend, WORLDS[backend]) == WORLDS[backend]


@pytest.mark.heavy
@pytest.mark.parametrize("backend", BRAINS, ids=named)
def test_a_wrong_brain_fails_nowhere_else(backend: type):
    assert failing(BrainBackendTests, backend) == BRAINS[backend]


@pytest.mark.heavy
@pytest.mark.parametrize("backend", WORLDS, ids=named)
def test_a_wrong_world_fails_nowhere_else(backend: type):
    assert failing(WorldBackendTests, backend) == WORLDS[backend]
