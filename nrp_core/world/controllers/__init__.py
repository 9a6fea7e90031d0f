"""Controllers of joints, alone or along trajectories."""
