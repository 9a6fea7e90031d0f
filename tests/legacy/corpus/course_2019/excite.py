@nrp.MapSpikeSource("noise", nrp.brain.actors, nrp.poisson, weight=0.05, rate=0.0)
@nrp.Robot2Neuron()
def excite(t, noise):
    noise.rate = 1000.0 if t > 1.0 else 0.0
