"""The folder of a recording: the experiment, the files it used, and the changes made to its run."""
