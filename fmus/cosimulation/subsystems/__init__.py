"""What a coupling can step: FMUs and linear models."""
