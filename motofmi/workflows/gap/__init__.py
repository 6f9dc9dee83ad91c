"""The gap workflow from recordings to a verdict with its files: one module for each kind of experiment."""
