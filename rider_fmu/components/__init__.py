"""Riders. Every component that a file of this folder defines is registered."""
