"""Parameters of a model from frequency responses: the fit, its bootstrap, and populations."""
