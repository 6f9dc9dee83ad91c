"""Recordings of tests: files in, columns with units in SI, checked, on a regular grid."""
