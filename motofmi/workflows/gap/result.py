"""The result of `find_gap`."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from fmus.declaration.component import Component
from fmus.export.build import build
from fmus.support.errors import MissingToolError
from fmus.support.files import note_written, write_text
from fmus.support.notebook import html, new_axes
from fmus.support.parallel import in_background
from motofmi.gap.selection.result import Verdict
from motofmi.reports.gap_report import FILE as REPORT
from motofmi.reports.gap_report import Pictures, before_and_after_chart, draw_before_and_after, gap_report
from motofmi.reports.gap_summary import error_text, headline, nearest, value_text
from motofmi.reports.report import Link, Report
from motofmi.reports.shown import Interactive
from motofmi.workflows.gap.kind import Kind
from motofmi.workflows.gap.verdict_file import FILE as VERDICT
from motofmi.workflows.gap.verdict_file import write_verdict

DEVICE_FILES = {"path": "value file", "fmu": "FMU"}  # what the files of a found device are


class Gap:
    """The result: where a model deviates from recordings, and which physical effect it lacks; `find_gap` shows an
    example.

    `verdict` is `named`, `none`, `unknown` or `tied`; `effects`, `tied`, `alternatives`, `reason`, `candidates`,
    `where`, `gap`, `limitations` and `next_experiment` are those of `verdict.json` (docs/gap.md). `model` is
    the fitted component with the effects found, `selection` the fits behind the verdict. `complete` and
    `save_known` are called by `find_gap`.
    """

    def __init__(self, experiment: Kind, selection: Verdict) -> None:
        self._experiment, self.selection = experiment, selection
        self._contents = experiment.contents(selection)
        self._contents["limitations"] = [
            *([selection.ended] if selection.ended else []),
            *self._contents["limitations"],
            *experiment.limitations(selection, self._contents),
        ]
        self._fitted = experiment.model(selection)
        self._complete = False

    @property
    def verdict(self) -> str:
        """`named`, `none`, `unknown` or `tied`.

        none: the base is consistent with the noise; unknown: no effect of the library explains the data; tied: several
        effects explain the data equally well.
        """
        return self._contents["verdict"]

    @property
    def effects(self) -> list[dict[str, Any]]:
        """The effects found: name, form, probability, and parameters with value, standard_error and unit."""
        return self._contents["effects"]

    @property
    def tied(self) -> list[str]:
        """The names of the effects that explain the data equally well."""
        return self._contents["tied"]

    @property
    def alternatives(self) -> list[dict[str, Any]]:
        """The models of a tie, or the nearest one where nothing is named: effects with their parameters, and closed."""
        return self._contents["alternatives"]

    @property
    def reason(self) -> str | None:
        """Why nothing is named, in one sentence; None where something is, or nothing is missing. Where the verdict is
        `none`, the offset of an input that dry friction would have as well."""
        return self._contents["reason"]

    @property
    def candidates(self) -> list[dict[str, Any]]:
        """Every effect that was tried: name, form, delta_chi2, delta_bic, probability."""
        return self._contents["candidates"]

    @property
    def where(self) -> list[dict[str, Any]]:
        """Where the base deviates from the data: run, axis, from, to, unit, excess, p_value."""
        return self._contents["where"]

    @property
    def gap(self) -> dict[str, Any]:
        """Reduced chi-square and rms of the residuals, before and after, on fitted and on validation runs."""
        return self._contents["gap"]

    @property
    def limitations(self) -> list[str]:
        """Assumptions and limitations of the verdict, in sentences."""
        return self._contents["limitations"]

    @property
    def next_experiment(self) -> dict[str, Any] | None:
        """The experiment that would distinguish the remaining candidates; None if none is needed or known."""
        return self._contents["next_experiment"]

    @property
    def model(self) -> Component:
        """The component as fitted, with the effects found."""
        return self._fitted.component

    def to_dict(self) -> dict[str, Any]:
        """The contents of `verdict.json`."""
        return dict(self._contents)

    def to_dataframe(self) -> Any:
        """The candidates as a pandas.DataFrame, the best first."""
        import pandas  # noqa: PLC0415 - imported on use

        return pandas.DataFrame(self.candidates)

    def complete(self) -> None:
        """Compute the modes before and after, and the next experiment. `find_gap` calls this."""
        if self._complete:
            return
        if self.verdict == "none" or self._contents["complete"]:
            modes = self._modes()  # on all processors
        else:
            with in_background(self._modes) as found:
                self._contents["next_experiment"] = self._experiment.next_experiment(self.selection)
                modes = found()
        if modes is not None:
            self._contents["modes"] = modes
        self._complete = True

    def _modes(self) -> dict[str, Any] | None:
        return self._experiment.modes(self.selection, self.model)

    def save(self, folder: str | Path) -> list[Path]:
        """Write `verdict.json`, the fitted model as value file and FMU, and `report.html` into the folder.

        Returns their paths. Without a C compiler no FMU is written, and a limitation is added. Raises InputError if the
        folder cannot be written.
        """
        folder = Path(folder)
        contents = self._contents
        write_verdict(contents, folder)
        write_text(folder / self._fitted.file, self._fitted.text)
        with in_background(lambda: _built(self.model, folder)) as built:
            self.complete()
            _ = self._pictures  # drawn while the FMU is built
            contents["fmu"], sentences = built()
        if contents["fmu"]:
            note_written(folder / contents["fmu"])
        contents["limitations"] += [s for s in sentences if s not in contents["limitations"]]
        contents |= {"model": self._fitted.file, "report": REPORT}
        device = self._experiment.found_device(self.selection) if self.verdict == "named" else None
        if device is not None:
            write_text(folder / device.file, device.text)
            contents["device"] = {"path": device.file, "fmu": _built(device.component, folder)[0]}
        files = [
            (VERDICT, "verdict with all numbers"),
            (self._fitted.file, "fitted model"),
            (contents["fmu"], "its FMU"),
            *(
                (name, f"{DEVICE_FILES[what]} of the device found")
                for what, name in (contents.get("device") or {}).items()
            ),
        ]
        self._report([(folder / name, text) for name, text in files if name]).write(folder / REPORT)
        write_verdict(contents, folder)
        written = (VERDICT, REPORT, self._fitted.file, contents["fmu"], *contents.get("device", {}).values())
        return [folder / name for name in written if name]

    def save_known(self, folder: Path) -> None:
        """Write `verdict.json` and `report.html` of a search that was interrupted."""
        self._contents["report"] = REPORT
        self._report().write(folder / REPORT)
        write_verdict(self._contents, folder)

    def report(self, path: str | Path) -> Path:
        """Write the HTML report and return its path. Raises InputError if it cannot be written."""
        self._report().write(Path(path))
        return Path(path)

    def show(self) -> Interactive:
        """The first picture of the report, which compares base and result with the data, interactive in a notebook."""
        charts = [chart for chart, _ in self._pictures.before_and_after]
        return Interactive(charts[0] if charts else before_and_after_chart(self._contents))

    def plot(self) -> Any:
        """Plot reduced chi-square before and after, on fitted and on validation runs; returns the matplotlib axes."""
        return draw_before_and_after(new_axes(), self._contents)

    @cached_property
    def _pictures(self) -> Pictures:
        return self._experiment.pictures(self.selection)

    def _report(self, files: Sequence[Link] = ()) -> Report:
        kind, contents = self._experiment, self._contents
        return gap_report(
            kind.title,
            contents,
            self._pictures,
            kind.modes_section(contents),
            kind.place,
            kind.fitted_parameters(self.selection),
            kind.given.files,
            files,
        )

    def __repr__(self) -> str:
        parts = [headline(self._contents)]
        parts += [f"{e['name']}.{n} = {_value(p)}" for e in self.effects for n, p in e["parameters"].items()]
        parts.append("reduced chi-square " + ", ".join(f"{key.replace('_', ' ')} {self.gap[key]:.3g}" for key in
                                                      ("before", "after", "holdout_before", "holdout_after")
                                                      if self.gap[key] is not None))  # fmt: skip
        return f"Gap({'; '.join(parts)})"

    def _repr_html_(self) -> str:
        rows = [(e["name"], e["form"], n, _value(p)) for e in self.effects for n, p in e["parameters"].items()]
        text = " ".join([headline(self._contents), *nearest(self._contents)])
        return html(
            text,
            ("effect", "form", "parameter", "value"),
            rows,
            lambda axes: draw_before_and_after(axes, self._contents),
        )


def _value(parameter: Mapping[str, Any]) -> str:
    return f"{value_text(parameter)} +- {error_text(parameter)} {parameter['unit']}"


def _built(component: Component, folder: Path) -> tuple[str | None, list[str]]:
    """The file name of the FMU in the folder; without a C compiler None and a limitation."""
    try:
        return Path(build(component, folder).path).name, []
    except MissingToolError as error:
        return None, [f"No FMU was built: {error}"]
