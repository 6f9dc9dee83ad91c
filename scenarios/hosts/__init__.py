"""Other people's simulators with our FMUs inside, one file each, every one held to an exact solution.

    python -m scenarios.hosts.fmpy_on_a_bar
"""
