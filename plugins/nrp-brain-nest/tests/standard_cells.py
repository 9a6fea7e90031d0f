"""PyNN's standard cells, and weights that each of them notices."""

CELLS = (
    "IF_curr_exp", "IF_curr_alpha", "IF_curr_delta", "IF_cond_exp", "IF_cond_alpha", "Izhikevich",
    "EIF_cond_exp_isfa_ista", "EIF_cond_alpha_isfa_ista", "HH_cond_exp",
)  # fmt: skip


def weight_for(cell_type: str, receptor: str) -> float:
    """Return a weight with a visible effect: mV, uS or nA; negative where PyNN has it so."""
    jumps = cell_type in ("IF_curr_delta", "Izhikevich")
    weight = 2.0 if jumps else 0.5 if "curr" in cell_type else 0.004
    return -weight if receptor == "inhibitory" and "cond" not in cell_type else weight
