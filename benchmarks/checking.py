"""The speed of a check of a recording: every byte is compared with its digest, and nothing is run.

The recording is one file of images of noise, which nothing can pack, with its digest. The file is in the page
cache: what is measured is the check, not the disk. Each round also reads the file and computes its SHA-256
alone, which is the least that a check takes; without processor instructions for it (``sha_ni``), that may be
below the limit. All rounds are printed in processor time, with the commit, the number of cores and the load.

    python benchmarks/checking.py [MEGABYTES] [ROUNDS]
"""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import TypeVar

import numpy as np
from conditions import conditions

from nrp_core.recording.layout import MCAP_NAME, RUN_NAME
from nrp_core.recording.recording import Recording
from nrp_core.recording.sealing import seal
from nrp_core.recording.writing import encoding
from nrp_core.recording.writing.writer import McapFile
from nrp_core.world.messages.sensor_msgs import Image

LIMIT_MB_PER_S = 300
LIMIT_RATIO = 1.2
BLOCK = 1 << 18
HEIGHT, WIDTH = 480, 640
TOPIC = "/husky/camera"
MB = 10**6

T = TypeVar("T")


def record(folder: Path, size: int) -> None:
    """Write a recording of a size, bytes."""
    file, rng = McapFile(folder / MCAP_NAME), np.random.default_rng(1)
    file.announce(TOPIC, file.codec.name(Image), {"role": "camera"})
    for number in range(size // (HEIGHT * WIDTH * 3)):
        pixels = rng.integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8)
        image = Image(height=HEIGHT, width=WIDTH, encoding="rgb8", step=WIDTH * 3, data=pixels)
        file.write(TOPIC, number, encoding.image(image))
    file.close()
    run = {"format": 4, "state": "finished", "files": {MCAP_NAME: file.digest}}
    (folder / RUN_NAME).write_bytes(seal(run))


def main(megabytes: int, rounds: int) -> int:
    print(conditions())
    speeds, ratios = [], []
    with TemporaryDirectory() as name:
        folder = Path(name)
        record(folder, megabytes * MB)
        for number in range(rounds):
            least_s, _ = timed(lambda: digested(folder / MCAP_NAME))
            took_s, check = timed(lambda: Recording(folder).check())
            assert check.intact
            speeds.append(check.size / MB / took_s)
            ratios.append(took_s / least_s)
            print(
                f"round {number}: {check.size / MB:.0f} MB in {took_s:.3f} CPU s, {speeds[-1]:.0f} MB/s, "
                f"{ratios[-1]:.2f} times its SHA-256 alone"
            )
    print(f"median {median(speeds):.0f} MB/s, at least {LIMIT_MB_PER_S} MB/s")
    print(f"median {median(ratios):.2f} times the SHA-256 alone, at most {LIMIT_RATIO}")
    return 0 if median(speeds) >= LIMIT_MB_PER_S or median(ratios) <= LIMIT_RATIO else 1


def timed(task: Callable[[], T]) -> tuple[float, T]:
    """Return the processor time of a task, s, and its result."""
    began = time.process_time()
    result = task()
    return time.process_time() - began, result


def digested(path: Path) -> str:
    """Return the SHA-256 of a file as plain Python computes it."""
    digest = hashlib.sha256()
    with path.open("rb", buffering=0) as file:
        while block := file.read(BLOCK):
            digest.update(block)
    return digest.hexdigest()


if __name__ == "__main__":
    asked = [int(argument) for argument in sys.argv[1:]]
    sys.exit(main(*(asked + [300, 7][len(asked) :])))
