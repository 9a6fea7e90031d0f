"""What cells and synapses share that users write as equations: sources of kernels, and their compilation."""
