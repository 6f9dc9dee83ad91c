"""The loop over the steps, compiled or in Python."""
