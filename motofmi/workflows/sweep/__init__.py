"""Studies over vehicles, devices, speeds, parameters and populations: described, validated, run, opened again."""
