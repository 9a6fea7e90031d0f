"""What a firm joint follows."""

FREE, VELOCITY, POSITION = 0, 1, 2
"""Nothing, a velocity or a position."""
