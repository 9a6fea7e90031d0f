"""``nest`` for scripts: their nodes become a network; pA, nS, pF become nA, uS, nF."""
