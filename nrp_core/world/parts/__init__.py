"""The parts of a scene that serve topics: cameras, drives, visuals, joints, the models themselves."""
