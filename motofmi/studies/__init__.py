"""Studies: many runs of one kind over a grid of named dimensions, in chunks, on processes or a cluster, stored by
region and resumed where they ended."""
