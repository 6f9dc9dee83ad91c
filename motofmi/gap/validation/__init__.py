"""Fits on runs that were not used for estimation."""
