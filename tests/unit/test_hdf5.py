"""HDF5 on a full disk: it reads back what it wrote, or it would crash."""

import resource
from pathlib import Path

import numpy as np
import pytest

from nrp_core._support.hdf5 import _Disk, new_file

WRITES = [(0, b"abcdef"), (4, b"XYZ"), (20, b"end"), (2, b"__")]


def test_data_that_the_disk_refused_can_still_be_read(tmp_path: Path) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3, hard))
    try:
        with (tmp_path / "a").open("w+b", buffering=0) as file:
            disk = _Disk(file)
            for at, data in WRITES:
                disk.seek(at)
                assert disk.write(data) == len(data)
            disk.seek(1)
            read = bytearray(b"?" * 24)
            assert disk.readinto(memoryview(read)) == 24
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert disk.failure is not None
    assert bytes(read) == b"b__XYZ" + bytes(13) + b"end" + bytes(2)


def _write_and_read(path: Path) -> None:
    with new_file(path) as root:
        for group in range(300):
            root.create_dataset(f"{group}/names", data=["some text"] * 50)
            root[f"{group}/values"] = np.arange(100)
        assert all(list(root[f"{group}/names"].asstr()) == ["some text"] * 50 for group in range(300))


@pytest.mark.heavy
def test_a_file_whose_structures_are_read_again_ends_with_the_disks_error(tmp_path: Path) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (5000, hard))
    try:
        with pytest.raises(OSError, match="File too large"):
            _write_and_read(tmp_path / "a")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
