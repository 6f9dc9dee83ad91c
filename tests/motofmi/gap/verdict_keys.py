"""The keys that `verdict.json` has for every verdict, with any component."""

KEYS = {
    "verdict", "effects", "tied", "closest", "candidates", "where", "gap", "base", "complete", "explained", "remainder",
    "noise_source", "next_experiment", "limitations", "criteria", "model", "fmu", "report",
}  # fmt: skip
