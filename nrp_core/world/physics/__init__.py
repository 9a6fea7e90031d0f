"""What every physics engine needs of a scene, prepared once: bodies, drives, options."""
