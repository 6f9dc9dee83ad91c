"""Ports between riders and vehicles; the sign conventions are stated here and nowhere else."""
