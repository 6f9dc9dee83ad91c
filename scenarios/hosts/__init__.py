"""Other tools' simulators with FMUs of this project inside, one file each, each compared with an exact solution.

    python -m motofmi.scenarios.hosts             the list of the hosts
    python -m motofmi.scenarios.hosts.fmpy_bar    one of them

A host is a module of this folder with

    HOST             the simulator's name
    PACKAGE          the import name of the package that it needs
    run(**options)   the results, by name
    SAMPLES          optional: functions by name, (fmus by name, step [s], count) -> samples (count, 5) of a rider on a
                     handlebar, which the benchmark of couplings compares

The results of each host are in docs/hosts.md.
"""

from types import ModuleType

from fmus.support.modules import modules_in


def hosts() -> dict[str, ModuleType]:
    """The hosts by the names of their modules."""
    return {
        module.__name__.rpartition(".")[2]: module
        for module in modules_in("motofmi.scenarios.hosts")
        if hasattr(module, "HOST")
    }
