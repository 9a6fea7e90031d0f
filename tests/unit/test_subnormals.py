"""Subnormal numbers are zero where that is asked for, and nowhere else."""

import sys
from threading import Event, Thread

import numpy as np

from nrp_core.brain import flushing_subnormals

SMALLEST = np.full(64, sys.float_info.min)


def test_they_are_zero_inside_and_as_before_outside() -> None:
    assert (SMALLEST * 0.5 > 0).all()
    with flushing_subnormals():
        assert (SMALLEST * 0.5 == 0).all()
        with flushing_subnormals():
            pass
        assert (SMALLEST * 0.5 == 0).all()
    assert (SMALLEST * 0.5 > 0).all()


def test_an_error_restores_them() -> None:
    try:
        with flushing_subnormals():
            raise RuntimeError
    except RuntimeError:
        pass
    assert (SMALLEST * 0.5 > 0).all()


def test_threads_that_began_before_keep_them() -> None:
    halves: list[bool] = []
    inside = Event()

    def halve() -> None:
        inside.wait()
        halves.append(bool((SMALLEST * 0.5 > 0).all()))

    thread = Thread(target=halve)
    thread.start()
    with flushing_subnormals():
        inside.set()
        thread.join()
    assert halves == [True]


def test_normal_numbers_are_computed_to_the_last_bit() -> None:
    values = np.geomspace(1e-300, 1e300, 1000)
    expected = np.sqrt(values) * 3.7
    with flushing_subnormals():
        found = np.sqrt(values) * 3.7
    assert np.array_equal(found, expected)
