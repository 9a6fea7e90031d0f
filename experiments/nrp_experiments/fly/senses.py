"""From feet to brain: contacts excite ascending cells, sugar under a foot the taste cells of that side.

Each foot has its share of the cells. 100 mV make a cell fire at each event of its device.
"""

import hbp_nrp_client.tf_framework as nrp
from gazebo_msgs.msg import ContactsState

touch = nrp.parameter(
    "touch", 20.0, unit="Hz", low=0, high=500, doc="rate of ascending cells, foot on the ground"
)
taste = nrp.parameter("taste", 100.0, unit="Hz", low=0, high=500, doc="rate of taste cells, foot on sugar")

PLACES = ("front", "middle", "hind")


def named(name):
    """Give each foot's function a unique name."""

    def name_it(function):
        function.__name__ = name
        return function

    return name_it


for side in ("left", "right"):
    for number, place in enumerate(PLACES):
        foot = f"{place}_{side}_foot"
        ascending = nrp.brain.ascending[number + 3 * (side == "right") :: 6]
        sugar = nrp.brain.group[f"sugar_{side}"][number::3]

        @nrp.MapRobotSubscriber("contacts", nrp.Topic(f"/fly/{foot}/touch", ContactsState))
        @nrp.MapSpikeSource("ascending", ascending, nrp.poisson, weight=100.0)
        @nrp.MapSpikeSource("sugar", sugar, nrp.poisson, weight=100.0)
        @nrp.Robot2Neuron()
        @named(f"feel_with_{foot}")
        def feel(t, contacts, ascending, sugar):
            states = contacts.value.states if contacts.value else ()
            on_sugar = any(state.collision2_name.startswith("sugar::") for state in states)
            ascending.rate = touch if states else 0.0
            sugar.rate = taste if on_sugar else 0.0
