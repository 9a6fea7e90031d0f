"""What a scanner sees, as one number for each sector; shared by the trained controller and its training."""

import numpy as np

SECTORS = 8
REACH = 1.1  # m, the range of the feelers


def sectors(ranges, angles):
    """Return the nearness of obstacles in each sector, from right to left: 0 beyond reach, 1 at contact.

    Args:
        ranges: m, shape ``(..., n_beams)``.
        angles: rad, shape ``(n_beams,)``, from right to left; beams aside count less than those ahead.
    """
    felt = np.clip(1.0 - np.asarray(ranges) / REACH, 0.0, 1.0) * np.cos(angles) ** 2
    return np.stack([part.max(axis=-1) for part in np.array_split(felt, SECTORS, axis=-1)], axis=-1)
