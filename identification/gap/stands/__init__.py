"""What is tested, and how: the base, what is free in it, and how effects join."""
