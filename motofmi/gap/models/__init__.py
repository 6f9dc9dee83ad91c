"""Base and effects as functions for estimation: predicted data and their derivatives by the parameters."""
