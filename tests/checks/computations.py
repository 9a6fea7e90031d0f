"""What scripts may do: a program that confines itself, and computes with the libraries that experiments use.

``python -P computations.py SCRATCH`` prints what each of them computed, in JSON.
"""

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from nrp_core._support.confinement import confine

SCRATCH = Path(sys.argv[1])


def numpy() -> Any:
    import numpy as np

    return float(np.linalg.det(np.eye(300) @ np.eye(300)))


def scipy() -> Any:
    from scipy import linalg

    return float(linalg.svdvals([[3.0, 0.0], [0.0, 1.0]])[0])


def opencv() -> Any:
    import cv2
    import numpy as np

    return list(cv2.GaussianBlur(np.zeros((99, 99, 3), np.uint8), (5, 5), 1).shape)


def matplotlib() -> Any:
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    plt.plot([1, 2])
    plt.savefig(SCRATCH / "figure.png")
    return (SCRATCH / "figure.png").read_bytes()[1:4].decode()


def numba() -> Any:
    from numba import njit

    return njit(lambda value: value * 2)(21)


def hdf5() -> Any:
    import h5py

    with h5py.File(SCRATCH / "a.h5", "w") as file:
        file["x"] = [1, 2]
    with h5py.File(SCRATCH / "a.h5") as file:
        return [int(one) for one in file["x"]]


def pynn() -> Any:
    import nrp_core.pynn as sim

    sim.setup(timestep=0.1)
    cells = sim.Population(10, sim.IF_curr_exp())
    return sim.Projection(cells, cells, sim.AllToAllConnector()).size()


def program() -> Any:
    return subprocess.run(["sh", "-c", "echo a | cat"], capture_output=True, text=True, check=True).stdout


def threads() -> Any:
    with ThreadPoolExecutor(4) as pool:
        return list(pool.map(abs, [-1, 2]))


def events() -> Any:
    return asyncio.run(asyncio.sleep(0.001, "slept"))


WORK: tuple[Callable[[], Any], ...] = (
    numpy, scipy, opencv, matplotlib, numba, hdf5, pynn, program, threads, events
)  # fmt: skip

if __name__ == "__main__":
    os.environ |= {"NUMBA_CACHE_DIR": str(SCRATCH), "MPLCONFIGDIR": str(SCRATCH)}
    lacking = confine(cpu_s=100.0, writable=[SCRATCH])
    print(json.dumps({"lacking": lacking, **{work.__name__: work() for work in WORK}}))
