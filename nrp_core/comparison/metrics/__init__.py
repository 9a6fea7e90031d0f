"""The metrics of the core: outcomes, ways, spikes, devices. Each is an entry point as any other's."""
