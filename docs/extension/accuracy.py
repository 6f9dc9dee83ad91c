"""How often verdicts are right, and what computations cost: from `benchmarks/results.json`."""

from typing import Any

from extension.measured import cases, results, share, value
from extension.tables import table

ACCURACY = """# How often a verdict is right

Blind cases: simulators that share no code with the workflow draw vehicles, riders, tests, noises and magnitudes at
random; each case is run once. Every table is rendered from `benchmarks/results.json`; brackets are Wilson's 95 %
intervals. `python -m benchmarks NAME` repeats a study.

"""
STUDIES = {
    "gap_blind": (
        "Steer test",
        "Riders on rigs of all kinds, with sweeps, noise and handlebars drawn at random. Detectable means a delta "
        "chi-square of 40 or more for the truth.",
    ),
    "gap_generic": (
        "Generic mechanisms",
        "Driven by a torque, angle imposed, closed loop, two masses, a heavy spring and mass.",
    ),
    "gap_real_like": (
        "Machines that no model explains completely",
        "A dominant effect, in a form of the library or in another one, beside one that is in no library; recordings with "
        "jitter, low-pass filters and closed loops, each with a validation run.",
    ),
    "gap_outside_library": (
        "Effects outside the library",
        "The same machines with a dominant effect that is in no library: damping or stiffness that depend on deflection "
        "and rate in other ways. A law counts as stated where `limitations` hold one of the hidden kind.",
    ),
    "gap_vehicle": ("Vehicles, eigenvalues over speed", "Sets of eigenvalues of motorcycles with standard errors."),
    "gap_vehicle_runs": (
        "Vehicles, recorded runs",
        "Motorcycles and bicycles, shaken, kicked or ridden, with two to five channels.",
    ),
    "gap_permutation": (
        "Nothing to name",
        "The simulated base plus its real residuals of recordings, in permuted blocks with random signs.",
    ),
}
COSTS = """# Measured costs

From `benchmarks/results.json`, on the machine that each entry names; `python -m benchmarks NAME` repeats one.

"""


def accuracy() -> str:
    studies = [_study(name, *words) for name, words in STUDIES.items()]
    return ACCURACY + "\n".join(
        [
            *studies,
            f"## Other methods\n\n{value('gap_rivals.cases')} blind cases of the steer test, of which half hide nothing, none with a "
            f"validation run (`gap_rivals`).\n\n{method_comparison()}",
            _machines(),
        ]
    )


def _study(name: str, title: str, words: str) -> str:
    found = results()[name]
    rows = [(key.replace("_", " "), cases(rate), share(rate)) for key, rate in _rates(found.get("rates", found))]
    return f"## {title}\n\n{words} `{name}`, {found['date']}.\n\n{table(('', 'cases', 'share'), rows)}"


def _rates(found: dict[str, Any]) -> list[tuple[str, dict[str, float]]]:
    return [
        (key, entry) for key, entry in found.items() if isinstance(entry, dict) and {"rate", "trials"} <= set(entry)
    ]


def _machines() -> str:
    rows = [
        (
            machine,
            ", ".join(f"`{e}`" for e in found["effects"]),
            name,
            f"{v['found']:.4g} +- {v['standard_error']:.1g}",
            f"{v['published']:.4g}",
        )
        for machine, found in results()["gap_machines"].items()
        if isinstance(found, dict) and "values" in found
        for name, v in found["values"].items()
    ]
    return (
        "## Simulated public machines\n\nFrom their published equations, with a base whose values are wrong (`gap_machines`).\n\n"
        + table(("machine", "named", "parameter", "found", "published"), rows)
    )


def costs() -> str:
    return COSTS + "\n".join([_fmus(), _couplings(), _gap(), _further()])


def _fmus() -> str:
    rows = [
        (
            name,
            *(
                found["nanoseconds_per_step"][k]
                for k in ("compiled, C loop", "bare arithmetic, C loop", "pythonfmu, C loop")
            ),
            found["archive_bytes"]["compiled"] // 1000,
        )
        for name, found in results()["fmu_speed"].items()
        if "nanoseconds_per_step" in found
    ]
    return "## FMUs\n\n" + table(
        ("FMU", "compiled, ns a step", "bare arithmetic, ns", "pythonfmu, ns", "archive, kB"), rows
    )


def _couplings() -> str:
    found = results()["coupling"]
    rows = [
        (
            f"`{name}`" if group == "ours" else name,
            f"{100 * abs(at['0.001']['slow']['damping_error']):.2g} %",
            f"{100 * at['0.001']['trajectory_error']:.2g} %",
            f"{_rate(at):,.0f}",
        )
        for group in ("ours", "peers")
        for name, at in found[group].items()
    ]
    return (
        "## Co-simulation\n\nThe rider on a bar, at a step of 1 ms: error of the damping ratio of the slow mode, of the trajectory, and speed.\n\n"
        + table(("coupling or tool", "damping error", "trajectory error", "steps a second"), rows)
    )


def _rate(at: dict[str, Any]) -> float:
    return at.get("steps_per_second", at["0.001"].get("steps_per_second", 0.0))


def _gap() -> str:
    rows = [
        (name, f"{found['samples']:,}", f"{found['cpu_s']:.1f}", f"{found['peak_mb']:.0f}")
        for name, found in results()["gap_speed"].items()
        if isinstance(found, dict) and "cpu_s" in found
    ]
    return "## Gap workflow\n\n" + table(("case", "samples", "processor time [s]", "memory [MB]"), rows)


def _further() -> str:
    rows = [
        ("tour, wall time", f"{value('tour.seconds'):.0f} s"),
        ("named modes over bare `numpy.linalg.eig`", f"{value('modes.ratio'):.2f} times"),
        ("identification fit", f"{value('identification.fit.fit_ms'):.2g} ms"),
        (
            "read and reduce a recording to an FRF",
            f"{value('identification.reading.MB_per_s')['read and reduced to an FRF']:.0f} MB/s",
        ),
        ("six-body rider over real time", f"{value('full_rider.real_time_factor'):.0f} times faster"),
    ]
    return "## Further\n\n" + table(("what", "measured"), rows)


def coupling_comparison() -> str:
    """The couplings of other tools beside two of this package, for the paper."""
    found = results()["coupling"]
    chosen = [
        ("motofmi, jacobi_quadratic", found["ours"]["jacobi_quadratic"]),
        ("motofmi, implicit_hermite", found["ours"]["implicit_hermite"]),
        *found["peers"].items(),
    ]
    rows = [
        (name, f"{100 * abs(at['0.001']['slow']['damping_error']):.2g} %", f"{_rate(at):,.0f}") for name, at in chosen
    ]
    return table(("coupling or tool", "error of the damping ratio", "steps a second"), rows)


def method_comparison() -> str:
    """The methods on blind cases, for the paper."""
    ways = value("gap_rivals.ways")
    heading = ("method", *(key.replace("_", " ") for key in next(iter(ways.values()))))
    return table(heading, [(name, *(cases(rate) for rate in found.values())) for name, found in ways.items()])
