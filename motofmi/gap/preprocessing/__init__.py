"""Recordings prepared for comparison: reconstructed motion, reduced data with independent errors, noise spectra."""
