"""Questions, one per file, each answered by `run`; and hosts, other people's simulators with our FMUs inside."""
