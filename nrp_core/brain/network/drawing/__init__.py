"""Random values of synapses that are drawn again when they are read, instead of kept in memory."""
