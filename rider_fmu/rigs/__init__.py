"""Test rigs on which riders were measured. Every component that a file of this folder defines is registered."""
