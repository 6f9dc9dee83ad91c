"""Other people's simulators with our FMUs inside: one file each, each held to an exact solution, each with its traps.

    python -m scenarios.hosts.fmpy_bar        and plain_c_bar, libcosim_bar, cofmpy_bar, exudyn_bicycle, mujoco_bar

What they show is told in docs/hosts.md.
"""
