    # pasted into the editor, and indented as a whole
    import math

    @nrp.MapSpikeSource("eye", nrp.brain.eyes[0], nrp.dc_source, amplitude=0.0)
    @nrp.Robot2Neuron()
    def stimulate(t, eye):
        eye.amplitude = math.sqrt(0.04)
