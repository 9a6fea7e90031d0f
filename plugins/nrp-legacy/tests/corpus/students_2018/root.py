root = nrp.config.brain_root
assert root.gains['right'][2] == 3


@nrp.MapSpikeSource("each", nrp.map_neurons(range(0, len(root.sensors)), lambda i: nrp.brain.sensors[i]), nrp.dc_source)
@nrp.MapCSVRecorder("rows", filename="root.csv", headers=["n", "threshold", "weight", "mean"])
@nrp.Robot2Neuron()
def root_of_brain(t, each, rows):
    each.amplitude = root.gains['left']
    if t > 0.29:
        root.actors.set(v_thresh=-40.0)
        root.static.set(weight=0.03)
    weights = root.static.get('weight', format='array')
    rows.record_entry(root.circuit.size, root.actors[0:1].get('v_thresh'), len(root.static), weights.mean())
