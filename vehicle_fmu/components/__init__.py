"""Motorcycle, bicycle and steering dampers. Every component that a file of this folder defines is registered."""
