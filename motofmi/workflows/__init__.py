"""The functions behind the command line and the Python interface."""
