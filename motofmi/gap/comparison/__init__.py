"""Which effect is missing: a comparison of fitted models on blocks of the residuals, without an absolute noise."""
