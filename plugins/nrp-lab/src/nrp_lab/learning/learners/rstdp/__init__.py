"""Reward-modulated STDP, with the error of the expected reward as dopamine."""
