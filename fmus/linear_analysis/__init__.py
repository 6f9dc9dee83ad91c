"""Linearised components: state spaces, eigenvalues, participation."""
