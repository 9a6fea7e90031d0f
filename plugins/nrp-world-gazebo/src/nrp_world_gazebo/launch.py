"""Start Gazebo: on this system, or in another one that lies in a folder."""

from __future__ import annotations

import os
import shlex
import socket
from collections.abc import Mapping, Sequence
from pathlib import Path
from shutil import which

from nrp_core.errors import BackendLoadError
from nrp_world_gazebo.display import display_for, on_display
from nrp_world_gazebo.options import GazeboOptions

REMEDY = "scripts/gazebo, which makes a system with Gazebo 11"
DISPLAY = "apt-get install xvfb"
_PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"


def command_line(
    options: GazeboOptions, world: Path, folders: Sequence[Path], *, draws: bool = False
) -> list[str]:
    """Return the command that runs a world file.

    A root gets this system's ``/dev``, ``/proc`` and the folders that Gazebo reads, at the same paths. These
    mounts are seen by the new process only and end with it.

    Args:
        options: the options of the backend.
        world: the world file.
        folders: the folders that it needs, including the world file's.
        draws: whether it draws images; then it begins paused, until its renderer is ready.

    Raises:
        BackendLoadError: the program, the root or a display to draw for does not exist.
    """
    own = [*options.command, "--verbose", *(["-u"] if draws else []), str(world)]
    if draws and not display_for(options.root):
        raise BackendLoadError("Gazebo draws images only for a display, and there is none", remedy=DISPLAY)
    program = options.command[0] if options.command else ""
    if options.root is None:
        if not program or which(program) is None:
            raise BackendLoadError(
                f"there is no program '{program}' for the world backend 'gazebo'; options: command and root "
                f"say where it is",
                remedy=REMEDY,
            )
        return on_display(own, None, world.parent) if draws else own
    own = on_display(own, options.root, world.parent) if draws else own
    root = options.root.absolute()
    if not (root / "usr").is_dir():
        raise BackendLoadError(f"the root of Gazebo {root} is not the folder of a system", remedy=REMEDY)
    if which("unshare") is None:
        raise BackendLoadError("a root of Gazebo needs unshare", remedy="apt-get install util-linux")
    script = " && ".join(_entering(root, folders))
    as_root = [] if os.geteuid() == 0 else ["--map-root-user"]
    namespaces = ["--mount", "--pid", "--fork", "--kill-child", "--propagation", "private"]
    return [
        "unshare",
        *as_root,
        *namespaces,
        "sh",
        "-c",
        f"{script} && exec chroot {shlex.quote(str(root))} {shlex.join(own)}",
    ]


def _entering(root: Path, folders: Sequence[Path]) -> list[str]:
    """Return the commands that mount folders of this system in a root."""
    at = shlex.quote(str(root))
    commands = [f"mount --rbind /dev {at}/dev", f"mount -t proc proc {at}/proc"]
    for folder in sorted(set(folders)):
        there = shlex.quote(f"{root}{folder}")
        commands.append(f"mkdir -p {there} && mount --rbind {shlex.quote(str(folder))} {there}")
    return commands


def environment(options: GazeboOptions, model_path: Sequence[Path]) -> Mapping[str, str]:
    """Return the environment of Gazebo: an own master, no model database, and the paths of models."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    paths = os.pathsep.join(map(str, model_path))
    own = {
        "GAZEBO_MASTER_URI": f"http://127.0.0.1:{port}",
        "GAZEBO_IP": "127.0.0.1",
        "GAZEBO_MODEL_DATABASE_URI": "",
        "IGN_PARTITION": f"nrp-{port}",
        "GAZEBO_MODEL_PATH": os.pathsep.join(filter(None, [paths, os.environ.get("GAZEBO_MODEL_PATH")])),
        "HOME": "/tmp",
    }
    if options.root is not None:
        return {"PATH": _PATH, "LC_ALL": "C.UTF-8", **own}
    return {**os.environ, **own}
