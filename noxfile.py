#!/usr/bin/env -S uv run --script
# /// script
# dependencies = ["nox>=2025.2.9"]
# ///
"""Tasks of a contributor: `nox` runs lint and tests, `nox -s docs` builds the site. `.ci/run` does all of it in one
environment."""

import nox

nox.needs_version = ">=2025.2.9"
nox.options.default_venv_backend = "uv|virtualenv"


@nox.session
def lint(session: nox.Session) -> None:
    """Style, types and spelling."""
    session.install(".[dev]")
    session.run("ruff", "check", ".")
    session.run("mypy", "fmus", "rider_fmu", "vehicle_fmu", "motofmi", "scenarios")
    session.run("codespell")


@nox.session
def tests(session: nox.Session) -> None:
    """The tests; arguments go to pytest."""
    session.install(".[dev]")
    session.run("pytest", "-n", "auto", "--dist", "worksteal", *session.posargs)


@nox.session(default=False)
def docs(session: nox.Session) -> None:
    """The site, into the folder `site`."""
    session.install(".[docs]")
    session.run("sphinx-build", "-nW", "docs", "site")


@nox.session(default=False)
def build(session: nox.Session) -> None:
    """Wheel and sdist, checked, into the folder `dist`."""
    session.install("build", "twine")
    session.run("python", "-m", "build", "--sdist")
    session.run("python", "-m", "build", "--wheel")  # from the checkout, which may hold prebuilt FMUs
    session.run("twine", "check", "--strict", "dist/*")


if __name__ == "__main__":
    nox.main()
