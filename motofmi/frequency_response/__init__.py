"""Frequency response functions: excitation, estimators, responses of linear components."""
