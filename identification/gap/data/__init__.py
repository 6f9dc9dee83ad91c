"""Measured data made ready: reduced to what can be compared, with the noise of it."""
