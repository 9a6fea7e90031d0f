"""``nest`` for brain files: their nodes become a network; pA, nS, pF become nA, uS, nF."""
