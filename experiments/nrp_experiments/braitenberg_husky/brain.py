"""The brain of a Braitenberg vehicle: eight cells that search for red and drive to it.

::

    0, 1   red in the left, right half of the image: silence 4 and 5
    2, 3   red in the left, right half of the image: drive the wheel of the other side
    4      colours other than red: drives the right wheel
    5      fires spontaneously: drives the right wheel
    6, 7   the left and the right wheel

Without red, cells 4 and 5 turn only the right wheel and the robot spins on the spot. With red
on one side, the wheel of the other side is faster, so the robot turns to the red and drives on.

An ordinary PyNN script; units are PyNN's: mV, ms, nF, uS.
"""

import nrp_core.pynn as sim

sim.setup(timestep=0.1)

circuit = sim.Population(
    8,
    sim.IF_cond_alpha(
        cm=0.025, tau_m=10.0, tau_refrac=10.0, v_rest=-60.5, v_thresh=-60.0, v_reset=-60.5,
        tau_syn_E=2.5, tau_syn_I=2.5, e_rev_E=0.0, e_rev_I=-75.0,
    ),
    initial_values={"v": -60.5},
    label="circuit",
)  # fmt: skip

# Cell 5 does not need input: its threshold is below its resting potential.
circuit[5:6].set(v_thresh=-60.51, v_reset=-61.6)


def connect(pre, post, weight, receptor_type="excitatory"):
    """Connect each cell in ``pre`` to each in ``post``.

    A spike uses up the whole synapse (U = 1), which then recovers within a few milliseconds.
    """
    sim.Projection(
        circuit[pre],
        circuit[post],
        sim.AllToAllConnector(),
        sim.TsodyksMarkramSynapse(weight=weight, delay=0.1, U=1.0, tau_rec=1.0, tau_facil=1.0),
        receptor_type=receptor_type,
        label=f"{pre} to {post}",
    )


connect([2], [7], weight=1.5e-4)
connect([3], [6], weight=1.5e-4)
connect([4], [7], weight=1.05e-4)
connect([5], [7], weight=1.4e-4)
connect([0, 1], [4, 5], weight=1.2e-3, receptor_type="inhibitory")
