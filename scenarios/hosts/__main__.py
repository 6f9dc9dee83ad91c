"""The hosts, with the command that runs each and whether its package is installed."""

from importlib.util import find_spec

from motofmi.scenarios.hosts import hosts


def main() -> None:
    """Print one line for each host."""
    for name, module in hosts().items():
        installed = find_spec(module.PACKAGE) is not None
        print(
            f"{module.HOST:<16}python -m "
            f"motofmi.scenarios.hosts.{name:<18}{'' if installed else f'({module.PACKAGE} is not installed)'}".rstrip()
        )


if __name__ == "__main__":
    main()
