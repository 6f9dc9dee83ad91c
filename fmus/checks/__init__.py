"""What can be wrong with an FMU, one file for each place where it can be wrong."""
