"""Recordings of tests: read from files, converted to SI units, checked, and resampled to a regular grid."""
