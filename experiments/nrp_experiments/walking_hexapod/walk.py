"""From half centres to joints: a leg lifts while its swing cells fire, and swings by their recent rate.

The rates are smoothed twice: quickly for the lift, slowly for the swing, which therefore lags by a quarter of
a cycle. So a foot is in the air while the leg moves forward, and on the ground while it moves back.
"""

import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Float64

CELLS = 8
LEGS = ("front_left", "middle_left", "rear_left", "front_right", "middle_right", "rear_right")
FULL = 50.0 * CELLS  # Hz, the summed rate of a half centre that fires
QUICK_MS, SLOW_MS = 40.0, 250.0
LIFT, SWING = 0.5, 0.45  # rad


def named(name):
    """Give each leg's function a unique name."""

    def name_it(function):
        function.__name__ = name
        return function

    return name_it


for number, leg in enumerate(LEGS):
    cells = slice(CELLS * number, CELLS * (number + 1))

    @nrp.MapSpikeSink("lifting", nrp.brain.swing[cells], nrp.population_rate, tau_fall=QUICK_MS)
    @nrp.MapSpikeSink("forward", nrp.brain.swing[cells], nrp.population_rate, tau_fall=SLOW_MS)
    @nrp.MapSpikeSink("back", nrp.brain.stance[cells], nrp.population_rate, tau_fall=SLOW_MS)
    @nrp.MapRobotPublisher("alpha", nrp.Topic(f"/hexapod/{leg}_alpha/cmd_pos", Float64))
    @nrp.MapRobotPublisher("beta", nrp.Topic(f"/hexapod/{leg}_beta/cmd_pos", Float64))
    @nrp.Neuron2Robot()
    @named(f"move_{leg}")
    def move(t, lifting, forward, back, alpha, beta):
        alpha.send_message(Float64(SWING * (forward.rate - back.rate) / FULL))
        beta.send_message(Float64(LIFT * min(lifting.rate / FULL, 1.0)))
