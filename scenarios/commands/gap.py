"""Where a model misses measured data, and which physical effect is missing."""

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from fmus.build import build
from fmus.component import Component
from fmus.effects import Effect
from fmus.errors import InputError, MissingToolError
from fmus.parallel import aside
from fmus.progress import track
from identification.gap.data.runs import NotSweptError, Run, prepare, usable
from identification.gap.models.model import Model
from identification.gap.naming.decide import Verdict, decide
from identification.gap.proposing.next_test import next_experiment
from identification.gap.proposing.scaled_runs import scaled_runs
from identification.gap.reporting.verdict import as_result
from identification.gap.stands.test_stand import TestStand
from identification.recordings import read_recording, read_rig
from scenarios import gap_plan
from scenarios.augmented_rider import FILE, effect_on_modes, motion_of, rider_of, write_model
from scenarios.component_report import write_report as write_component_report
from scenarios.component_test import run_on_component
from scenarios.gap_report import pictures, write_report
from scenarios.gap_tables import headline, modes_over_speed, nearest, places
from scenarios.recordings_on_the_command_line import mapping_of
from scenarios.rig_over_time import run_over_time
from scenarios.rig_proposals import rig_proposals
from scenarios.rig_test import rig_effects, rig_test, with_bare_bar
from scenarios.vehicle_gap import run_on_vehicle
from scenarios.verdict_file import write_verdict, writing_so_far

NAME = "gap"
HELP = """Find where a model misses recordings, name the missing effect, add it, and show the gap shrink.

  motofmi gap sweep_up.csv stepped.csv --holdout sweep_down.csv --out gap
  motofmi gap sweep.csv --bare bare_bar.csv --out gap
  motofmi gap sweep.csv --rig my_rig.json --rider 3_2011 --out gap
  motofmi gap run.csv --component driven_joint --map "T=torque [N.m]" --holdout other.csv --out gap
  motofmi gap run.csv --component mass_spring_damper --impose displacement --out gap
  motofmi gap --plan --sweep 0.5:12 --sweep 12:0.5 --amplitude 2     (before any test: what it could name)
  motofmi gap eigenvalues.csv --vehicle sharp_1971 --holdout others.csv --out gap
  motofmi gap run_1.csv run_2.csv --vehicle bicycle_at_4.toml --holdout run_3.csv --out gap

The verdict is named, none (the model is as good as the noise), unknown (nothing in the library is it) or tied
(these data cannot tell the members apart). verdict.json in the --out folder holds everything.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="*", metavar="FILE", help="recordings to fit, one run each")
    parser.add_argument("--holdout", nargs="+", default=[], metavar="FILE", help="recordings that are only compared with")
    parser.add_argument("--bare", nargs="+", default=[], metavar="FILE", help="sweeps of the bare handlebar, hands off")
    parser.add_argument("--rig", metavar="FILE", help="rig.json (default: beside the first recording)")
    parser.add_argument("--rider", default="mean_2011", metavar="NAME", help="published rider whose values the fit starts from")
    parser.add_argument("--map", action="append", default=[], metavar="COLUMN=VARIABLE", help="what a column is")
    parser.add_argument("--effects", metavar="DIR", help="folder with effects of your own")
    parser.add_argument("--vehicle", metavar="NAME", help="a motorcycle's NAME or a .toml: the files are its eigenvalues over speed, or its runs")
    parser.add_argument("--device", default="none", help="what was at the vehicle's handlebar: rider:NAME, damper:VALUE or none (default)")
    parser.add_argument("--component", metavar="NAME|PATH.py:CLASS", help="any component with recorded inputs and outputs: mass_spring_damper, "
                        "driven_joint, pendulum, two_mass, a .toml, or a class of your own")  # fmt: skip
    parser.add_argument("--impose", metavar="VARIABLE", help="a component's displacement or angle that was imposed; its force was measured")
    parser.add_argument("--free", nargs="+", default=[], metavar="NAME", help="parameters to fit of which nothing is known")
    gap_plan.add_arguments(parser)
    parser.add_argument("--out", default="gap", metavar="DIR", help="folder for verdict.json, model and report")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    if arguments.plan:
        return gap_plan.run(arguments)
    if not arguments.files:
        raise InputError("gap needs recordings: motofmi gap FILE.csv [...] --holdout FILE.csv --out DIR")
    if arguments.vehicle:
        return run_on_vehicle(arguments)
    if arguments.component:
        return run_on_component(arguments)
    folder = Path(arguments.out)
    rig = read_rig(arguments.rig or Path(arguments.files[0]).parent)
    stand, library = rig_test(rig, arguments.rider), rig_effects(arguments.effects)
    if arguments.bare:
        stand = with_bare_bar(stand, _runs(arguments.bare, stand, arguments.map))
    try:
        runs, held = _runs(arguments.files, stand, arguments.map), _runs(arguments.holdout, stand, arguments.map)
    except NotSweptError:
        return _over_time(arguments, rig, stand, library)
    verdict = decide(Model(stand), runs, library, held, writing_so_far(folder, lambda verdict: as_result(verdict, "N.m")))
    with _adding(verdict, arguments, folder) as add_to:
        result = as_result(verdict, "N.m")
        result["limitations"] += _limitations(rig, runs, held, bool(arguments.bare))
        write_verdict(result, folder)
        result["next_experiment"] = next_experiment(verdict, rig_proposals)
        shown = pictures(verdict)
        add_to(result)
    result["report"] = write_report(shown, result, folder)
    write_verdict(result, folder)
    return result


def _over_time(arguments: argparse.Namespace, rig: dict[str, Any], stand: TestStand, library: Sequence[type[Effect]]) -> dict[str, Any]:
    """The result where the motion has no harmonics to compare on."""
    folder = Path(arguments.out)
    found, result = run_over_time(arguments, stand, library)
    result["limitations"] += _bar_unknown(rig, bool(arguments.bare))
    write_verdict(result, folder)
    with _adding(found.verdict, arguments, folder, swept=False) as add_to:
        result["next_experiment"] = next_experiment(found.verdict, scaled_runs)
        add_to(result)
    result["report"] = write_component_report(found.verdict, result, folder, modes_over_speed(result))
    write_verdict(result, folder)
    return result


@contextmanager
def _adding(verdict: Verdict, arguments: argparse.Namespace, folder: Path, swept: bool = True) -> Iterator[Callable[[dict[str, Any]], None]]:
    """What adds to a result the model with what was found, its FMU, and what it does to the motorcycle's modes, all of which are made meanwhile."""
    rider = write_model(verdict.best, folder, f"Fitted to {', '.join(r.name for r in verdict.best.runs)}", arguments.effects)

    def on_modes() -> dict[str, Any]:
        if verdict.verdict != "named":
            return {}
        return {"modes": effect_on_modes(rider_of(verdict.base), rider, motion_of(verdict.best, rider) if swept else None)}

    with aside(lambda: _built(rider, folder)) as fmu, aside(on_modes) as modes:

        def add_to(result: dict[str, Any]) -> None:
            name, sentences = fmu()
            result["limitations"] += sentences
            result |= {"model": FILE, "fmu": name, **modes()}

        yield add_to


def _built(rider: Component, folder: Path) -> tuple[str | None, list[str]]:
    """The FMU's name in the folder; without a compiler none, and what to say of it."""
    try:
        return Path(build(rider, folder).path).name, []
    except MissingToolError as error:
        return None, [f"No FMU was built: {error}"]


def _runs(files: Sequence[str], stand: TestStand, mapping: Sequence[str]) -> list[Run]:
    mapped = mapping_of(mapping)
    recordings = [read_recording(path, mapped or None) for path in track(files, "reading")]
    usable(recordings)
    columns = stand.columns
    return [prepare(r, columns["imposed"], columns["measured"], columns["command"], tuple(stand.further)) for r in recordings]


def _limitations(rig: dict[str, Any], runs: Sequence[Run], held: Sequence[Run], bare: bool) -> list[str]:
    sentences = list(dict.fromkeys(note for r in (*runs, *held) for note in (*r.notes, *r.recording.warnings)))
    sentences += _bar_unknown(rig, bare)
    if not held:
        sentences.append("No held-out run: the verdict is not checked on data that was not used.")
    return sentences


def _bar_unknown(rig: dict[str, Any], bare: bool) -> list[str]:
    if "handlebar_inertia" in rig or bare:
        return []
    return ["The handlebar's own inertia is not known (no rig.json, no bare-bar run): added inertia cannot be told from it."]


def show(result: dict[str, Any], console: Console) -> None:
    if "verdict" not in result:
        gap_plan.show(result, console)
        return
    console.print(headline(result), style="bold")
    for sentence in nearest(result):
        console.print(sentence)
    for effect in result["effects"]:
        values = ", ".join(f"{n} = {p['value']:.4g} +- {p['standard_error']:.2g} {p['unit']}" for n, p in effect["parameters"].items())
        console.print(f"{effect['name']} ({effect['form']}): {effect['sentence']} {values}")
    table = Table(box=None)
    for heading in ("candidate", "form", "delta chi2", "delta BIC", "probability"):
        table.add_column(heading, justify="left" if heading in ("candidate", "form") else "right")
    for c in result["candidates"][:8]:
        table.add_row(c["name"], c["form"], f"{c['delta_chi2']:.1f}", f"{c['delta_bic']:.1f}", f"{c['probability']:.3f}")
    console.print(table)
    gap = result["gap"]
    for name in ("before", "after", "holdout_before", "holdout_after"):
        if gap[name] is not None:
            console.print(f"{name.replace('_', ' '):>15}: reduced chi-square {gap[name]:.3f} (floor 1), rms {gap['rms'][name]:.3g} {gap['rms']['unit']}")
    if result["where"]:
        console.print(_where(result))
    if result["next_experiment"]:
        proposed = result["next_experiment"]
        console.print(f"next experiment: {proposed['sentence']} Expected delta chi-square: {proposed['expected_delta_chi2']:.3g}.")
    for sentence in result["limitations"]:
        console.print(f"limitation: {sentence}", style="yellow")


def _where(result: dict[str, Any]) -> Table:
    clearest = places(result, most=6)
    table = Table(box=None, title="where the base misses the data", title_justify="left")
    for heading in clearest.headings:
        table.add_column(heading, justify="left" if heading in ("run", "axis", "unit") else "right")
    for row in clearest.rows:
        table.add_row(*row)
    return table
