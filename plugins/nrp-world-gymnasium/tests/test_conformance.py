"""What every world with its own scene must do, from the platform's own kit."""

from nrp_conformance import OwnSceneTests
from nrp_world_gymnasium import GymnasiumBackend


class TestPendulum(OwnSceneTests):
    """An action that is a number."""

    options = {"env": "Pendulum-v1", "timestep": "50 ms"}  # noqa: RUF012

    @classmethod
    def make_backend(cls) -> GymnasiumBackend:
        return GymnasiumBackend()


class TestCartPole(TestPendulum):
    """An action that is a whole number, and episodes that end."""

    options = {"env": "CartPole-v1", "timestep": "20 ms"}  # noqa: RUF012
