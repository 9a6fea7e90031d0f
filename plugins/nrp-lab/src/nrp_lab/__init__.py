"""Many runs of an experiment: sweeps, searches, comparisons, benchmarks and environments of Gymnasium."""
