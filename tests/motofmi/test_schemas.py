"""The schemas that ship: every command has one, every key has a meaning, and real outputs fit."""

import json
from dataclasses import fields
from pathlib import Path

import pytest

from fmus.checks.problem import Problem
from fmus.export.compilers import host_compiler
from fmus.support.errors import InputError
from fmus.support.plain_json import to_json
from motofmi.cli.listing import commands
from motofmi.cli.main import main
from motofmi.gap.criteria import Criteria
from motofmi.schemas import names, schema
from motofmi.workflows.check import CheckReport
from motofmi.workflows.tour import Tour
from tests.motofmi.json_schemas import check_against_schema

# `gap --json` is verdict.json, `gap --plan --json` is plan.json; `completion` prints a script.
FURTHER = {"verdict", "plan", "batch"}
OUTPUTS = (
    ("list",),
    ("build", "damper:7.5", "--out", "out"),
    ("device", "damper:7.5", "--frequency", "1"),
    ("modes", "--speed", "20,30"),
    ("modes", "--speed", "20,30", "--device", "none", "--device", "damper:7.5"),
    ("trim", "--speed", "30", "--lean", "0,20"),
    ("cosimulate", "--device", "damper:7.5", "--duration", "0.1", "--out", "run.csv"),
    ("simulate", "out/damper_7_5.fmu", "--duration", "0.1"),
)


def test_every_command_has_a_schema():
    assert set(names()) - FURTHER == set(commands()) - {"completion", "gap"}
    with pytest.raises(InputError, match="unknown schema 'verdct', did you mean 'verdict'"):
        schema("verdct")


@pytest.mark.slow
@pytest.mark.skipif(host_compiler() is None, reason="no C compiler on this machine")
def test_outputs_of_commands_fit_their_schemas(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for words in OUTPUTS:
        assert main([*words, "--json", "found.json"]) == 0
        check_against_schema(words[0], json.loads(Path("found.json").read_text("utf-8")))
    capsys.readouterr()


def test_problems_of_fmus_fit_their_schema():
    found = CheckReport({"a.fmu": [Problem("archive", "error", "no model description", "a.fmu")], "b.fmu": []})
    check_against_schema("check", json.loads(to_json(found.to_dict())))


def test_the_tour_fits_its_schema(tmp_path):
    found = Tour([{"name": "report", "seconds": 1.0, "answer": "written"}], tmp_path / "report.html")
    check_against_schema("tour", json.loads(to_json(found.to_dict())))


def test_a_key_that_no_schema_has_is_a_violation():
    with pytest.raises(AssertionError, match="Additional properties"):
        check_against_schema("explore", {"page": "a.html", "bytes": 1, "vehicles": [], "devices": [], "extra": 1})


def test_thresholds_of_the_verdict_are_numbers():
    (kind,) = {type(getattr(Criteria(), field.name)) for field in fields(Criteria)} - {int}
    assert kind is float and schema("verdict")["properties"]["criteria"]["additionalProperties"] == {"type": "number"}
