"""Checks of FMUs, one file for each place where an FMU can be wrong: see `fmus.checks.check`."""
