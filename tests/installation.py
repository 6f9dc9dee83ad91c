"""Fresh environments in which the project is installed, with the packages of this one as dependencies."""

import os
import subprocess
import sys
import venv
from pathlib import Path

from tests import ROOT

NAMES = {"motofmi", "fmus", "rider_fmu", "vehicle_fmu"}


def listed_files() -> list[str]:
    """What git lists in the checkout; empty where there is none."""
    found = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout
    return [name for name in found.split("\n") if name and (ROOT / name).is_file()]


def copied_checkout(folder: Path) -> Path:
    """A copy of what git lists."""
    for name in listed_files():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes((ROOT / name).read_bytes())
    return folder


def built_wheel(checkout: Path) -> Path:
    """The wheel of a copied checkout."""
    done = subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--skip-dependency-check"],
        cwd=checkout,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    (path,) = (checkout / "dist").glob("*.whl")
    return path


def environment_with(folder: Path, *what: str) -> Path:
    """The Python of a new environment in which `what` is installed, with the packages of this one."""
    venv.create(folder, with_pip=False)
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    places = [str(python), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    packages = Path(subprocess.run(places, capture_output=True, text=True, check=True).stdout.strip())
    (packages / "dependencies.pth").write_text(str(_dependencies(folder / "dependencies")), "utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "pip", "--python", str(python), "install", "--no-deps", "--no-index", *what],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return python


def fresh_environment(folder: Path) -> Path:
    """The Python of a new environment in which the wheel is installed."""
    return environment_with(folder / "environment", str(built_wheel(copied_checkout(folder / "checkout"))))


def _dependencies(folder: Path) -> Path:
    """What is installed here, without the project itself, which may be installed here too."""
    folder.mkdir(parents=True)
    for packages in [Path(path) for path in sys.path if path.endswith("site-packages")]:
        for member in packages.iterdir():
            own = member.name in NAMES or member.name.startswith(("motofmi-", "__editable__"))
            if not own and not (folder / member.name).exists():
                (folder / member.name).symlink_to(member)
    return folder
