"""Trials of an FMU, one a file: see `fmus.checks.trial`."""
