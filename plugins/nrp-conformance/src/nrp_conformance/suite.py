"""The module that pytest collects: it holds the class under test."""

from nrp_conformance.run import under_test

TestBackend = under_test[-1]
