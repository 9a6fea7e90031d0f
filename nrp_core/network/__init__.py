"""Networks as data: cells, synapses, limits, and how they are indexed."""
