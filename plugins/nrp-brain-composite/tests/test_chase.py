"""Two robots with brains of their own, on different backends, meet."""

import pytest

from nrp_core.experiment import Run, load_experiment


@pytest.mark.parametrize("backend", ["spinnaker", "event"])
def test_two_robots_with_brains_on_two_backends_meet(backend: str) -> None:
    given = [f"brain.options.parts.dog.backend={backend}", "duration=6 s"]
    if backend == "event":
        given.append("brain.options.parts.dog.options={resolution: 0.1 ms}")
    with Run(load_experiment("chase", given)) as run:
        run.run()
        assert run.result().passed
