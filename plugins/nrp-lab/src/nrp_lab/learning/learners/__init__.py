"""The learners that ship."""
