"""Effects that the passive rider neglects. The gap workflow tries every effect that a file of this folder declares."""
