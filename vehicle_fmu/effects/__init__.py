"""Effects that a rigid motorcycle or bicycle neglects.

The gap workflow tries every effect that a file of this folder declares.
"""
