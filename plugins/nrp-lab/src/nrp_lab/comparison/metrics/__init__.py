"""The metrics of the core: outcomes, trajectories, spikes, devices. All are found by entry points."""
