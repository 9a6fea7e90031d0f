# Imported Python Transfer Function
import hbp_nrp_cle.tf_framework as nrp


@nrp.MapSpikeSource("dc", nrp.brain.record[0], nrp.dc_source, amplitude=0.0)
@nrp.MapSpikeSource("ac", nrp.brain.record[0], nrp.ac_source, offset=0.01)
@nrp.MapSpikeSource("noise", nrp.brain.record[1], nrp.nc_source, std=0.001)
@nrp.MapSpikeSource(
    "fixed", nrp.brain.record, nrp.fixed_frequency, connector={"mode": "AllToAll", "weights": 0.001}
)
@nrp.MapSpikeSource(
    "many",
    nrp.map_neurons(range(2), lambda i: nrp.brain.record[i]),
    nrp.poisson,
    synapse_type=None,
    label="p",
)
@nrp.Robot2Neuron(throttling_rate=50.0)
def currents(t, dc, ac, noise, fixed, many):
    dc.amplitude = 0.2
    ac.amplitude = 0.05
    noise.mean = 0.2
    fixed.rate = 100.0
    many.rate = np.array([10.0, 20.0])
    assert t >= 0
