"""``nest`` as brains of the platform use it directly: its calls fill a network; pA, nS and pF become nA, uS and nF."""
