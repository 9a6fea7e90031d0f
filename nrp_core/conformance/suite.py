"""What pytest collects: the class that is being run."""

from nrp_core.conformance.run import under_test

TestBackend = under_test[-1]
