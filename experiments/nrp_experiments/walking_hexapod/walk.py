"""From the half centres to the joints: the slow rates swing the legs, the quick ones lift them."""

import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Float64

CELLS = 8
LEGS = ("front_left", "middle_left", "rear_left", "front_right", "middle_right", "rear_right")
FULL_RATE = 45.0 * CELLS  # Hz, of a half centre that fires
SWING, LIFT = 0.4, 0.45  # rad


def of_leg(population):
    """Return what picks a leg's cells."""
    return lambda leg: population[slice(CELLS * leg, CELLS * (leg + 1))]


def joints(joint):
    """Return, for each leg, what commands a joint of it."""
    return [
        nrp.MapRobotPublisher(f"{leg}_{joint}", nrp.Topic(f"/hexapod/{leg}_{joint}/cmd_pos", Float64))
        for leg in LEGS
    ]
