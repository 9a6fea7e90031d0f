@nrp.NeuronMonitor(nrp.brain.actors, nrp.population_rate)
def actors_rate(t):
    return True
