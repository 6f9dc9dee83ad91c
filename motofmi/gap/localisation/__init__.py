"""Where the misfit of a model lies: by run, order, frequency, time, amplitude and direction."""
