"""``nest`` as brain files call it: what they make becomes a network; pA, nS, pF become nA, uS, nF."""
