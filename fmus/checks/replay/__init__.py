"""The replay of reference results, in a process of its own: it imports what co-simulation needs."""
