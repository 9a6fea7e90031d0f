"""Many runs of one experiment: environments to learn in."""
