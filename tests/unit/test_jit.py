"""Compiled kernels: borrowed memory, and a cache that knows its sources."""

import os
import subprocess
import sys
from pathlib import Path
from time import perf_counter_ns

import numpy as np
import pytest

from nrp_core._support import jit
from nrp_core._support.jit import borrowed, fma
from nrp_core._support.stopwatch import Stopwatch, work


@jit.jit
def _write_borrowed(array: np.ndarray) -> float:
    view = borrowed(array)
    view[0] = 7.0
    return float(view.sum())


@jit.jit
def _multiply_and_add(x: np.ndarray, sums: np.ndarray) -> None:
    for i in range(len(x)):
        sums[i] = fma(x[i], x[i], -1.0 - 2.0**-29)


def _let_time_pass() -> None:
    begun = perf_counter_ns()
    while perf_counter_ns() == begun:
        pass


def test_a_clock_that_several_have_stopped_goes_on_when_all_are_done() -> None:
    clock = Stopwatch()
    clock.stop()
    still = clock.now_ns()
    clock.stop()
    clock.go_on()
    assert clock.now_ns() == still
    clock.go_on()
    _let_time_pass()
    assert clock.now_ns() > still


def test_a_borrowed_array_is_the_same_memory() -> None:
    array = np.ones(3)
    assert _write_borrowed(array) == 9.0
    assert array.tolist() == [7.0, 1.0, 1.0]


@pytest.mark.skipif(not jit.COMPILED, reason="nothing is compiled")
def test_code_that_cannot_be_kept_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise RuntimeError("no compiled object yet")

    monkeypatch.setattr("numba.core.caching.FunctionCache.save_overload", refuse)
    assert jit.jit(lambda x: x + 1)(2) == 3


@pytest.mark.parametrize("folder", ["package", "package/within"])
def test_code_compiled_from_other_sources_is_kept_apart(folder: str, tmp_path: Path) -> None:
    def directory() -> Path:
        jit._cache_directory.cache_clear()
        return jit._cache_directory(tmp_path / folder, frozenset(), str(tmp_path / "cache"))

    (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "package" / "__init__.py").touch()
    (tmp_path / folder / "one.py").write_text("A = 1\n")
    first = directory()
    assert first.parent == tmp_path / "cache"
    assert first == directory()
    (tmp_path / "package" / "two.py").write_text("B = 2\n")
    assert directory() != first


@pytest.mark.heavy
def test_code_is_compiled_again_when_a_module_it_calls_indirectly_changes_but_not_elsewhere(
    tmp_path: Path,
) -> None:
    pytest.importorskip("numba")
    texts = {
        "below": "def base(x): return x + {number}\nbase = jit(base)\n",
        "between": "from below.kernels import base\n@jit\ndef step(x): return base(x)\n",
        "above": "from between.kernels import step\n@jit\ndef run(x): return 10 * step(x)\nprint(run(1))\n",
    }

    def result(number: int, place: str = "here") -> tuple[str, int, set[str]]:
        for name, text in texts.items():
            (tmp_path / place / name).mkdir(exist_ok=True, parents=True)
            lines = "from nrp_core._support.jit import jit\n" + text.format(number=number)
            (tmp_path / place / name / "kernels.py").write_text(lines)
        cache = tmp_path / "cache"
        done = subprocess.run(
            [sys.executable, "-c", "import above.kernels"], cwd=tmp_path / place, check=True, text=True,
            capture_output=True, env={**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": "."},
        )  # fmt: skip
        said = done.stderr.count("compiling the numeric kernels")
        return done.stdout.strip(), said, {str(file) for file in cache.rglob("*.nbc")}

    first, said, compiled = result(1)
    assert (first, said, len(compiled)) == ("20", 1, 1)  # the code of ``run`` contains that of the others
    assert result(1) == ("20", 0, compiled)
    assert result(1, "elsewhere") == ("20", 0, compiled)
    assert result(2)[:2] == ("30", 1)


def test_the_clock_of_the_work_stands_still_while_something_is_compiled() -> None:
    event = pytest.importorskip("numba.core.event")
    with event.trigger_event("numba:compile"):
        still = work.now_ns()
        _let_time_pass()
        assert work.now_ns() == still
    _let_time_pass()
    assert work.now_ns() > still


def test_the_users_choice_of_a_cache_is_respected() -> None:
    numba = pytest.importorskip("numba")
    before = numba.config.CACHE_DIR
    jit.jit(lambda x: x)
    assert before == numba.config.CACHE_DIR


@pytest.mark.skipif(not jit.COMPILED, reason="Python rounds the product")
def test_a_product_and_a_sum_are_rounded_once_in_vectors_and_in_what_is_left_of_them() -> None:
    sums = np.empty(37)
    _multiply_and_add(np.full(37, 1.0 + 2.0**-30), sums)
    assert (sums == 2.0**-60).all()


@pytest.mark.one_of(3)
@pytest.mark.parametrize("kind", ["jit", "inlined"])
@pytest.mark.parametrize(
    "calls", ["outer(2.0), inner(2.0), inner(2), outer(2)", "inner(2.0), outer(2.0), 4, 5"]
)
def test_python_can_call_a_function_before_and_after_compiled_code_calls_it(
    tmp_path: Path, kind: str, calls: str
) -> None:
    pytest.importorskip("numba")
    (tmp_path / "called.py").write_text(
        "from nrp_core._support.jit import inlined, jit\n"
        f"@{kind}\ndef inner(x): return 2.0 * x\n"
        "@jit\ndef outer(x): return inner(x) + 1.0\n"
        f"print([float(x) for x in ({calls})])\n"
    )
    expected = str([float(x) for x in ((5, 4, 4, 5) if calls.startswith("outer") else (4, 5, 4, 5))])
    for _ in range(2):  # compiled, and from the cache
        done = subprocess.run(
            [sys.executable, "-c", "import called"], cwd=tmp_path, check=True, text=True, capture_output=True,
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": "."},
        )  # fmt: skip
        assert done.stdout.strip() == expected
