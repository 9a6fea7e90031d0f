"""``nrp_client`` for scripts that steer NRP-core 4: the same calls on a run in this process.

::

    from nrp_client import NrpCore

    nrp = NrpCore("localhost:50051", experiment_folder="tf_exchange")
    nrp.initialize()
    done, trajectory = nrp.run_loop(10)
    nrp.shutdown()
"""

from __future__ import annotations

from pathlib import Path
from threading import Thread
from typing import Any, NamedTuple

from nrp_ebrains.datapacks import DataPack, JsonData, copied, plain
from nrp_ebrains.maker import ConfigurationMaker
from nrp_ebrains.reader import read_json

from nrp_core.errors import NrpError
from nrp_core.experiment import Run


class Reply(NamedTuple):
    """What a call that runs the simulation answers.

    Args:
        done: whether the status function said that the run is done.
        timeout: whether the time of the experiment is over.
        trajectory: the data of the status function, if the run is done or over.
    """

    done: bool
    timeout: bool
    trajectory: list[Any]


class NrpCore:
    """An experiment of NRP-core 4.

    Args:
        address: ``host:port``, not used, because nothing listens.
        experiment_folder: the folder of the experiment.
        config_file: its configuration, in this folder or absolute.
        args, log_output, server_timeout, docker_daemon_address, image_name, get_archives, compose_file: not
            used, because no other process exists.

    Raises:
        ConnectionError: the address has no port.
        FileNotFoundError: the configuration does not exist.
        NrpError: it is not valid.
    """

    def __init__(
        self, address: str, experiment_folder: str = "", config_file: str = "simulation_config.json",
        args: str = "", log_output: str = "", server_timeout: int = 10, docker_daemon_address: str = "",
        image_name: str = "", get_archives: Any = (), compose_file: str = "",
    ) -> None:  # fmt: skip
        if not address.rpartition(":")[2].isdecimal():
            raise ConnectionError(f"an address is 'host:port', not '{address}'")
        path = Path(experiment_folder) / config_file
        if not path.is_file():
            raise FileNotFoundError(f"there is no configuration {path}")
        self._experiment = read_json(path)
        self._run: Run | None = None
        self._state = "Created"
        self._json_datapack_out_buffer: list[DataPack] = []  # scripts read the lengths of both
        self._proto_datapack_out_buffer: list[DataPack] = []

    # -- life

    def current_state(self) -> str:
        """Return ``Created``, ``Initialized``, ``Running``, ``Stopped`` or ``Failed``."""
        return self._state

    def initialize(self) -> list[Any]:
        """Open the engines; return the datapacks that functions ask for."""
        self._require("initialize", "Created")
        try:
            self._run = Run(self._experiment)
        except NrpError as error:
            self._fail(error)
        self._maker.stops_when_done = False
        self._state = "Initialized"
        return self._requested()

    def reset(self) -> list[Any]:
        """Return to time 0; return the datapacks that functions ask for."""
        self._require("reset", "Initialized", "Stopped")
        self._send()
        self._guarded(lambda: self._opened.reset())
        self._state = "Initialized"
        return self._requested()

    def stop(self) -> None:
        """End an asynchronous call after its current iteration."""
        if self._run is not None:
            self._run.loop.stop()

    def shutdown(self) -> None:
        """Close the engines."""
        self._require("shutdown", "Initialized", "Stopped", "Failed")
        run, self._run = self._run, None
        self._state = "Created"
        if run is not None:
            run.close()

    def __del__(self) -> None:
        """Close the engines of an experiment that is no longer used."""
        if getattr(self, "_run", None) is not None:
            self.shutdown()

    # -- running

    def run_loop(self, num_iterations: int, run_async: bool = False, response: Any = None) -> Any:
        """Run some iterations.

        Args:
            num_iterations: how many steps of the fastest engine.
            run_async: whether to return a thread at once, which appends the reply to ``response``.
            response: a list.

        Returns:
            whether the run is done, and if so the data of the status function since the last time.
        """
        self._require("run_loop", "Initialized", "Stopped")
        self._send()
        if run_async:
            return self._in_thread(lambda: self._iterate(num_iterations), response)
        reply = self._iterate(num_iterations)
        return reply.done, reply.trajectory

    def run_until_timeout(self, run_async: bool = False, response: Any = None) -> Any:
        """Run until the status function reports that the run is done, or until the timeout.

        Returns:
            whether it is done, whether the time is over, and the data of the status function.
        """
        self._require("run_until_timeout", "Initialized", "Stopped")
        if run_async:
            return self._in_thread(self._to_the_end, response)
        return tuple(self._to_the_end())

    def unpack_thread_results(self, reply: Reply) -> tuple[bool, list[Any]]:
        """Return whether the run is done, and the data of the status function, of an asynchronous reply."""
        return reply.done, reply.trajectory

    # -- datapacks

    def set_json_datapack(self, name: str, engine: str, data: dict[str, Any]) -> None:
        """Send a datapack with the next :meth:`run_loop` or :meth:`reset`, and in all later iterations."""
        self._json_datapack_out_buffer.append(DataPack(name, engine, JsonData(plain(data))))

    def set_proto_datapack(self, name: str, engine: str, message: Any) -> None:
        """Send a datapack with a message; as :meth:`set_json_datapack`."""
        self._proto_datapack_out_buffer.append(DataPack(name, engine, copied(message)))

    # -- helpers

    @property
    def _opened(self) -> Run:
        assert self._run is not None
        return self._run

    @property
    def _maker(self) -> ConfigurationMaker:
        maker = self._opened.experiment.maker
        assert isinstance(maker, ConfigurationMaker)
        return maker

    def _require(self, call: str, *states: str) -> None:
        if self._state not in states:
            raise ConnectionError(f"{call}() is not possible in the state {self._state}")

    def _send(self) -> None:
        for buffer in (self._json_datapack_out_buffer, self._proto_datapack_out_buffer):
            for pack in buffer:
                self._maker.loop.set_datapack(pack)
            buffer.clear()

    def _requested(self) -> list[Any]:
        return [one.value if isinstance(one, JsonData) else one for one in self._maker.loop.requested()]

    def _in_thread(self, call: Any, response: Any) -> Thread:
        replies: list[Reply] = [] if response is None else response
        thread = Thread(target=lambda: replies.append(call()))
        thread.start()
        return thread

    def _iterate(self, n: int) -> Reply:
        run, loop = self._opened, self._maker.loop
        loop.done = False
        until_ns = run.loop.now_ns + n * run.experiment.timestep
        self._advance(lambda: run.run_until_ns(until_ns))
        return self._reply()

    def _to_the_end(self) -> Reply:
        run, loop = self._opened, self._maker.loop
        loop.done = False

        def advance() -> None:
            while not loop.done and not self._is_over:
                run.run_until_ns(run.loop.now_ns + run.experiment.timestep)

        self._advance(advance)
        return self._reply()

    @property
    def _is_over(self) -> bool:
        return self._opened.loop.now_ns >= self._opened.experiment.duration

    def _advance(self, call: Any) -> None:
        self._state = "Running"
        self._guarded(call)
        self._state = "Stopped"

    def _reply(self) -> Reply:
        loop, is_over = self._maker.loop, self._is_over
        trajectory: list[Any] = []
        if loop.done or is_over:
            trajectory, loop.trajectory = loop.trajectory, []
        return Reply(loop.done, is_over and not loop.done, trajectory)

    def _guarded(self, call: Any) -> None:
        try:
            call()
        except NrpError as error:
            self._fail(error)

    def _fail(self, error: NrpError) -> None:
        self._state = "Failed"
        raise RuntimeError(
            f'Request failed with error "{error}". The only possible action now is "shutdown()".'
        ) from error
