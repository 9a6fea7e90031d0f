"""What a brain file has built, as it is while the experiment runs."""
