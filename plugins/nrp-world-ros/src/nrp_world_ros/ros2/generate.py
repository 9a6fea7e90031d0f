"""Make a package of messages and services with ROS's own generators and a C compiler.

``python -m nrp_world_ros.ros2.generate FOLDER PACKAGE DEPENDENCY...`` reads the files ``*.msg`` and ``*.srv``
in ``FOLDER/share/PACKAGE/``, and writes libraries to ``FOLDER/lib`` and Python modules to ``FOLDER/python``.
It is a program of its own because the generators print and change their standard output. CMake is not used,
because its files in the wheels name folders of the machine that built them.
"""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from shutil import copy
from typing import Any

_C, _CPP = os.environ.get("CC", "cc"), os.environ.get("CXX", "c++")

LIBRARIES = (
    ("rosidl_generator_c", "GenerateC", _C),
    ("rosidl_typesupport_introspection_c", "GenerateIntrospectionCTypesupport", _C),
    ("rosidl_typesupport_fastrtps_c", "GenerateFastRTPSCTypesupport", _CPP),
    ("rosidl_typesupport_c", "GenerateCTypesupport", _CPP),
    ("rosidl_generator_py", "GeneratePython", _C),
)
"""The libraries of a package in the order of their dependence: generator, its class, and compiler."""

_GENERATORS = tuple(generator for generator, *_ in LIBRARIES)

_RUNTIME = (
    "rosidl_runtime_c", "rosidl_typesupport_introspection_c", "rosidl_typesupport_fastrtps_c",
    "rosidl_typesupport_fastrtps_cpp", "rosidl_typesupport_c", "fastcdr", "rcutils",
)  # fmt: skip


class Maker:
    """Makes one package.

    Args:
        folder: receives the package, and has its definitions.
        package: its name.
        dependencies: the packages of the types in its messages.
    """

    def __init__(self, folder: Path, package: str, dependencies: Iterable[str]) -> None:
        self._folder, self._package = folder, package
        self._prefixes = [folder, *map(Path, os.environ["AMENT_PREFIX_PATH"].split(os.pathsep))]
        self._dependencies = [package, *dependencies]

    def make(self) -> None:
        """Generate and compile the package.

        Raises:
            OSError: no compiler was found.
            CalledProcessError: it failed.
        """
        idl = list(self._translated())
        shares = [str(where) for where in self._find(*(f"share/{each}" for each in self._dependencies))]
        for generator, name, _ in LIBRARIES:
            generate = getattr(import_module(f"{generator}.cli"), name)(generator)
            generate.generate(self._package, idl, shares, self._sources(generator))
        for generator, _, compiler in LIBRARIES:
            self._compile(compiler, self._name(generator), self._unity(generator, compiler))
        self._finish_python()
        described = self._sources("rosidl_generator_c")
        for each in described.rglob("*.json"):  # for packages with messages of this one
            copy(each, self._folder / "share" / self._package / each.relative_to(described))

    def _translated(self) -> Iterator[str]:
        """Yield the definitions in IDL, each as ``folder:file``."""
        adapter: Any = import_module("rosidl_adapter.cli")
        share = self._folder / "share" / self._package
        for kind, translator in (("msg", adapter.TranslateMsgToIDL), ("srv", adapter.TranslateSrvToIDL)):
            files = [f"{share}:{each.relative_to(share)}" for each in sorted(share.glob(f"{kind}/*.{kind}"))]
            if files:
                yield from translator(kind).translate(self._package, files, [], share)

    def _sources(self, generator: str) -> Path:
        return self._folder / "source" / generator / self._package

    def _unity(self, generator: str, compiler: str) -> list[Path]:
        """Return the files to compile: one that includes the others, so that headers are read once."""
        folder = self._sources(generator)
        sources = sorted(folder.rglob("*.cpp" if compiler == _CPP else "*.c"))
        sources = [each for each in sources if "_s.ep." not in each.name]
        alone = [each for each in sources if each.name.endswith("__description.c")]  # with names of their own
        unity = folder / f"unity{sources[0].suffix}"
        unity.write_text("".join(f'#include "{each}"\n' for each in sources if each not in alone))
        return [unity, *alone]

    def _name(self, generator: str) -> Path:
        return self._folder / "lib" / f"lib{self._package}__{generator}.so"

    def _compile(self, compiler: str, library: Path, sources: Iterable[Path]) -> None:
        library.parent.mkdir(exist_ok=True)
        mine = [each for each in map(self._name, _GENERATORS) if each.exists()]  # ROS loads them by name
        names = [f"{each}__{generator}" for each in self._dependencies[1:] for generator in _GENERATORS]
        libraries = list(self._find(*(f"lib/lib{name}.so" for name in (*names, *_RUNTIME))))
        folders = {str(each.parent) for each in libraries if each.parent != self._folder / "lib"}
        folders |= {"$ORIGIN", "$ORIGIN/../../lib"}  # of a library, and of the module, because they are moved
        subprocess.run(
            [
                compiler, "-shared", "-fPIC", "-w", f"-Wl,-soname,{library.name}", "-o", library,
                *(f"-I{each}" for each in self._headers()), *sources,
                "-Wl,--no-as-needed", *mine, "-Wl,--as-needed", *libraries,
                *(f"-Wl,-rpath,{each}" for each in sorted(folders)),
            ],
            check=True,
        )  # fmt: skip

    def _headers(self) -> Iterator[Path]:
        import numpy as np

        for generator, *_ in LIBRARIES:
            yield self._sources(generator).parent
        for prefix in self._prefixes:
            yield prefix / "include"
            yield from (each for each in (prefix / "include").glob("*") if each.is_dir())
        yield Path(np.get_include())
        yield Path(sysconfig.get_path("include"))

    def _find(self, *names: str) -> Iterator[Path]:
        """Yield the present files of these names, each below the first prefix that has it."""
        for name in names:
            yield from [prefix / name for prefix in self._prefixes if (prefix / name).exists()][:1]

    def _finish_python(self) -> None:
        """Compile the module with the pointers to the libraries, and move the package to its place."""
        sources = self._sources("rosidl_generator_py")
        (sources / "__init__.py").touch()
        module = f"{self._package}_s__rosidl_typesupport_c{sysconfig.get_config_var('EXT_SUFFIX')}"
        pointers = sources / f"_{self._package}_s.ep.rosidl_typesupport_c.c"
        self._compile(_C, sources / module, [pointers])
        sources.parent.rename(self._folder / "python")


if __name__ == "__main__":
    Maker(Path(sys.argv[1]), sys.argv[2], sys.argv[3:]).make()
