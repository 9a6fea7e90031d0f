"""The objects built by a brain file while the experiment runs."""
