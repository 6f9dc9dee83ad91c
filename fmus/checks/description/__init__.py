"""Checks of the description files of an FMU, one a file: see `fmus.checks.check`."""
