"""The packages of a wheel: the scenarios and the glossary, in folders of their own in a checkout, are installed inside
`motofmi`."""

from setuptools import find_namespace_packages, setup
from setuptools.command.build_py import build_py

IMPORT_NAMES = ("motofmi", "fmus", "rider_fmu", "vehicle_fmu")


class BuildPackages(build_py):
    """Leaves out `motofmi/scenarios.py`, which stands for the folder in a checkout, and the scripts that build the
    documentation."""

    def find_package_modules(self, package: str, package_dir: str) -> list[tuple[str, str, str]]:
        found = super().find_package_modules(package, package_dir)
        return [
            (owner, module, file)
            for owner, module, file in found
            if (owner, module) != ("motofmi", "scenarios") and owner != "motofmi.docs"
        ]


scenarios = [f"motofmi.{name}" for name in find_namespace_packages(include=["scenarios", "scenarios.*"])]
setup(
    packages=[
        *find_namespace_packages(include=[pattern for name in IMPORT_NAMES for pattern in (name, f"{name}.*")]),
        *scenarios,
        "motofmi.docs",
    ],
    package_dir={"motofmi.scenarios": "scenarios", "motofmi.docs": "docs"},
    cmdclass={"build_py": BuildPackages},
)
