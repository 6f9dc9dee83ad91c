"""Tests that have not been made: what they could name, and which of them would settle a verdict."""
