# two cells, one for each wheel
import logging

from hbp_nrp_cle.brainsim import simulator as sim

logger = logging.getLogger(__name__)


def create_brain():
    cells = sim.Population(
        2,
        sim.IF_cond_alpha(
            cm=0.025,
            tau_m=10.0,
            tau_refrac=10.0,
            v_rest=-60.5,
            v_thresh=-60.0,
            v_reset=-60.5,
            tau_syn_E=2.5,
            tau_syn_I=2.5,
        ),
    )
    sim.initialize(cells, v=-60.5)
    logger.debug(cells)
    return cells


circuit = create_brain()
circuit.initialize(v=-60.5)
