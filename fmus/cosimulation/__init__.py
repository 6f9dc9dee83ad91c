"""Coupled subsystems: stepped together, with the error of the coupling known before the run."""
