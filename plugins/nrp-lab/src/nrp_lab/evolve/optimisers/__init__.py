"""Optimisers choose the candidates of each generation: one module each; entry points add others."""
