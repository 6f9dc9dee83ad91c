"""The command line as other programs use it: its JSON, its exit status, and one line for what is wrong."""

import gc
import json
import re
import shlex
import shutil
import subprocess
import sys
import time

import pytest

import motofmi
from fmus.declaration.component import Component
from fmus.support.errors import InputError
from fmus.support.files import write_text
from motofmi.cli import commands
from motofmi.cli.listing import commands as listed
from motofmi.cli.main import main
from motofmi.cli.parser import Parser, fill
from motofmi.cli.run import imported
from motofmi.schemas import names
from motofmi.workflows import components
from tests import ROOT
from tests.motofmi.json_schemas import check_against_schema

COMMANDS = list(listed())


def refuse_constant(text):
    raise AssertionError(f"{text} is not JSON")


def result_of(capsys, *arguments):
    """The JSON on standard output; nothing else is allowed there."""
    assert main([*arguments, "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    found = json.loads(out, parse_constant=refuse_constant)
    if arguments[0] in names():
        check_against_schema(arguments[0], found)
    return found


# Help ---------------------------------------------------------------------------------------------


def program(*arguments, **options):
    """The command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "motofmi", *arguments], capture_output=True, text=True, cwd=ROOT, **options
    )


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_shows_examples_that_it_understands(command, capsys):
    assert main([command, "--help"]) == 0
    out = capsys.readouterr().out
    assert f"\n  motofmi {command}" in out
    assert "--json" in out
    assert main(["help", command]) == 0
    assert capsys.readouterr().out == out


@pytest.mark.parametrize("name", COMMANDS)
def test_the_command_understands_every_example_of_its_help(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = imported(listed()[name].module)
    examples = [
        shlex.split(line.partition(" > ")[0], comments=True)
        for line in command.HELP.splitlines()
        if line.startswith("  motofmi ")
    ]
    assert 2 <= len(examples)
    for _, first, *words in examples:
        assert first == name
        assert fill(Parser(prog=name), command).options(words)
    assert command.SUMMARY and command.HELP.splitlines()[0]


@pytest.mark.parametrize(
    ("name", "option"),
    [("gap", "--holdout"), ("gap", "--bare"), ("gap", "--free"), ("sweep", "--vehicle"), ("sweep", "--device")],
)
def test_an_option_with_several_values_may_be_given_more_than_once(name, option):
    parser = fill(Parser(prog=name), imported(listed()[name].module))
    options = parser.options([option, "a", "b", option, "c"])
    assert getattr(options, option.strip("-")) == ["a", "b", "c"]
    # The default is not changed by what was given before.
    assert getattr(parser.options([option, "d"]), option.strip("-")) == ["d"]


@pytest.mark.parametrize("words", [[], ["help"], ["-h"], ["--help"]])
def test_help_lists_every_command_with_a_summary(words, capsys):
    assert main(words) == 0
    lines = capsys.readouterr().out.splitlines()
    for entry in listed().values():
        (line,) = (line for line in lines if line.split()[:1] == [entry.name])
        assert entry.summary and line.endswith(f"  {entry.summary}")


def test_help_is_shown_without_loading_the_numerical_libraries():
    code = "import sys; from motofmi.__main__ import main; sys.argv = ['motofmi', 'help']; main(); print(sorted({'numpy', 'sympy', 'rich'} & set(sys.modules)))"
    began = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.splitlines()[-1] == "[]"
    assert time.perf_counter() - began < 2.0  # 0.1 s on a quiet machine, where loading the libraries takes 1.5 s


def test_the_gap_command_begins_without_the_slowest_modules_of_scipy():
    code = "import sys, motofmi.cli.commands.gap; print(sorted({'scipy.signal', 'scipy.stats'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("word", ["--version", "-V"])
def test_the_version_is_that_of_the_package(word, capsys):
    assert main([word]) == 0
    assert capsys.readouterr().out == f"motofmi {motofmi.__version__}\n"


def test_a_command_is_one_file(tmp_path, monkeypatch, capsys):
    (tmp_path / "double.py").write_text(
        'SUMMARY = "twice a number"\nPLACE = 35\nUNITS = {"twice": "m"}\nHELP = "Doubles.\\n\\n  motofmi double 2\\n"\n'
        'def add_arguments(parser):\n    parser.add_argument("number", type=float)\n'
        'def run(arguments):\n    return {"twice": 2 * arguments.number}\n'
        'def show(result, screen):\n    screen.print(result["twice"])\n')  # fmt: skip
    monkeypatch.setattr(commands, "__path__", [*commands.__path__, str(tmp_path)])
    monkeypatch.delitem(sys.modules, "motofmi.cli.commands.double", raising=False)
    assert main(["help"]) == 0
    assert "  twice a number\n  device " in capsys.readouterr().out  # 35 is between modes, 30, and device, 40
    assert main(["double", "2"]) == 0
    assert capsys.readouterr().out == "4.0\n"
    assert result_of(capsys, "double", "2") == {"twice": 4.0, "units": {"twice": "m"}}


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_the_shell_accepts_its_completion(shell, capsys):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert all(command in script for command in COMMANDS) and "--holdout" in script and "sharp_1971" in script
    if not shutil.which(shell):
        pytest.skip(f"{shell} is not installed")
    subprocess.run([shell, "-n"], input=script, text=True, check=True)


def test_bash_completes_commands_options_and_names(capsys):
    if not shutil.which("bash"):
        pytest.skip("bash is not installed")
    main(["completion", "bash"])
    script = capsys.readouterr().out

    def completed(*words):
        ask = (
            f'\nCOMP_WORDS=({" ".join(words)}); COMP_CWORD={len(words) - 1}; _shtab_motofmi; echo "${{COMPREPLY[@]}}"\n'
        )
        return subprocess.run(["bash"], input=script + ask, capture_output=True, text=True, check=True).stdout.split()

    assert completed("motofmi", "mod") == ["modes"]
    assert completed("motofmi", "gap", "--hol") == ["--holdout"]
    assert completed("motofmi", "modes", "--vehicle", "sha") == ["sharp_1971", "sharp_1994"]
    assert completed("motofmi", "device", "mean") == ["mean_2011"]
    assert completed("motofmi", "identify", "--method", "n") == ["nyquist"]


@pytest.mark.slow
def test_it_runs_as_a_program():
    done = program("list", "--json", "-", check=True)
    assert done.stderr == "" and "riders" in json.loads(done.stdout)


def test_garbage_is_left_alone_during_an_import_and_collected_after_it(tmp_path, monkeypatch):
    (tmp_path / "asks_whether.py").write_text("import gc\nENABLED = gc.isenabled()\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert not imported("asks_whether").ENABLED and gc.isenabled()
    with pytest.raises(ModuleNotFoundError):
        imported("no_such_module")
    assert gc.isenabled()


# list ---------------------------------------------------------------------------------------------


def test_list_gives_every_word_that_set_takes(capsys):
    found = result_of(capsys, "list")
    assert all(isinstance(found[kind], list) for kind in ("components", "riders", "motorcycles", "dampers", "effects"))
    published = {*(f"{n}_2008" for n in range(1, 6)), *(f"{n}_2011" for n in range(1, 11)), "mean_2011"}
    assert published <= {r["name"] for r in found["riders"]}
    (sharp,) = (m for m in found["motorcycles"] if m["name"] == "sharp_1971")
    assert "Sharp" in sharp["source"]
    damping = sharp["parameters"]["steering_damping"]
    assert (damping["symbol"], damping["unit"], damping["min"], damping["max"]) == ("K", "N.m.s/rad", 0, 1e4)
    assert damping["value"] == pytest.approx(5 * 4.4482216152605 * 0.3048)  # 5 lbf.ft.s/rad
    (rider,) = (r for r in found["riders"] if r["name"] == "4_2008")
    assert set(rider["assumed"]) == {"arm_damping", "waist_damping"}
    settings = [
        f"--set={name}={entry['value']}" for name, entry in rider["parameters"].items() if name != "added_steer_inertia"
    ]
    settings += [
        f"--set={name}={entry['value']}" for name, entry in sharp["parameters"].items() if name != "added_steer_inertia"
    ]
    assert result_of(capsys, "modes", "--device", "rider:4_2008", "--speed", "20", *settings)["modes"]


def test_list_names_every_component(capsys):
    found = {c["name"] for c in result_of(capsys, "list")["components"]}
    assert found == set(components.COMPONENTS)


# What is wrong is said in one line ------------------------------------------------------------------

BAD = {
    "unknown rider": (["modes", "--device", "rider:maen_2011"], "unknown rider 'maen_2011', did you mean 'mean_2011'? (valid: 10_2011, "),
    "unknown damper": (["modes", "--device", "damper:heavy"], "unknown damper 'heavy' (valid: high_2011, "),
    "unknown vehicle": (["modes", "--vehicle", "sharp"], "unknown motorcycle 'sharp'"),
    "unknown kind": (["modes", "--device", "driver:mean_2011"], "unknown kind of component 'driver', did you mean 'rider'?"),
    "unknown name": (["device", "mean"], "unknown component 'mean'"),
    "no vehicle": (["modes", "--vehicle", "rider:mean_2011"], "'rider:mean_2011' is a PassiveRider, not a vehicle (valid: "),
    "no device": (["modes", "--device", "motorcycle:sharp_1971"], "'motorcycle:sharp_1971' is a Motorcycle, not a device of a vehicle (valid: none, damper:VALUE, "),
    "no transfer functions": (["device", "none"], "device 'none' has no transfer functions"),
    "unknown parameter": (["modes", "--device", "rider:mean_2011", "--set", "arm_dampng=3"], "unknown parameter 'arm_dampng', did you mean 'arm_damping'?"),
    "no parameter of this device": (["modes", "--set", "arm_damping=3"], "unknown parameter 'arm_damping'"),
    "value out of bounds": (["modes", "--device", "rider:mean_2011", "--set", "arm_damping=-3"], "arm_damping = -3 N.m.s/rad is outside its bounds [0, 100000]"),
    "damper out of bounds": (["modes", "--device", "damper:-3"], "damping = -3 N.m.s/rad is outside its bounds"),
    "damper not a number": (["modes", "--device", "damper:nan"], "damping = nan N.m.s/rad is outside its bounds"),
    "value not a number": (["modes", "--set", "trail=long"], "'trail=long' is not NAME=VALUE with a number, as in arm_damping=20"),
    "several values": (["modes", "--set", "trail=0.1:0.2:0.02"], "'trail=0.1:0.2:0.02' gives several values, but a command takes one value: repeat the command in a loop, as in for x in"),
    "no value": (["modes", "--set", "trail"], "'trail' is not NAME=VALUE with a number"),
    "speed zero": (["modes", "--speed", "0"], "motorcycle_sharp_1971: speed = 0 m/s is outside its bounds [0.1, 200]"),
    "speed below zero": (["modes", "--speed=-1:5:1"], "speed '-1:5:1' is not A:B:STEP, one value or a comma list of ascending numbers from 0 on [m/s]"),
    "speed negative": (["modes", "--speed", "-3"], "speed '-3' is not"),
    "speed not a number": (["modes", "--speed", "nan"], "speed 'nan' is not"),
    "speed infinite": (["modes", "--speed", "1:inf:1"], "speed '1:inf:1' is not"),
    "speed in words": (["modes", "--speed", "fast"], "speed 'fast' is not"),
    "speed descending": (["modes", "--speed", "9:1:1"], "speed '9:1:1' is not"),
    "speed step zero": (["modes", "--speed", "1:9:0"], "speed '1:9:0' is not"),
    "speed step too small": (["modes", "--speed", "1:9:1e-9"], "speed '1:9:1e-9' has more than 1,000,000 values; give a larger step"),
    "speed without end": (["modes", "--speed", "1:9"], "speed '1:9' is not"),
    "speed twice": (["modes", "--speed", "5,5"], "speed '5,5' is not"),
    "speed too low": (["modes", "--speed", "0.05"], "speed = 0.05 m/s is outside its bounds [0.1, 200]"),
    "speed too high": (["modes", "--speed", "10:500:10"], "speed = 500 m/s is outside its bounds [0.1, 200]"),
    "frequency zero": (["device", "damper:7.5", "--frequency", "0"], "frequency '0' is not"),
    "unknown option": (["modes", "--sped", "5"], "unknown option '--sped', did you mean '--speed'?"),
    "one word too many": (["device", "damper:7.5", "5"], "unexpected '5'; motofmi help device shows the arguments of the command"),
    "missing argument": (["device"], "the following arguments are required: device"),
    "unknown name in the list": (["list", "shap_1971"], "unknown name 'shap_1971', did you mean 'sharp_1971'? (valid: "),
    "unknown command": (["mode"], "unknown command 'mode', did you mean 'modes'? (valid: build, "),
    "help of an unknown command": (["help", "mods"], "unknown command 'mods', did you mean 'modes'?"),
    "an option without a command": (["--speed", "5"], "unknown command '--speed'"),
}  # fmt: skip


def complaint(capsys, arguments):
    """The one line on standard error of a command that must end with status 2."""
    status = main(arguments)
    out, err = capsys.readouterr()
    assert status == 2
    assert out == ""
    assert err.count("\n") == 1 and err.startswith("motofmi")
    return err


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_named_in_one_line(case, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments, message = BAD[case]
    json_file = ["--json", "result.json"] if arguments and arguments[0] in COMMANDS else []
    assert message in complaint(capsys, [*arguments, *json_file])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("line, message", [
    ("damping = { value = 1.0, unit = 'N.m.sek/rad' }", "unknown unit [N.m.sek/rad] at 'sek' (known symbols: "),
    ("damping = { value = 1.0, unit = 'N.m/rad' }", "unit [N.m/rad] cannot be converted to [N.m.s/rad]"),
    ("dampng = 1.0", "unknown parameter 'dampng', did you mean 'damping'? (valid: damping)"),
    ("damping = 1.0\n[author]\nname = 'me'", "unknown key 'author' (valid: about, "),
    ("damping = -1.0", "damping = -1 N.m.s/rad is outside its bounds [0, 10000]"),
    ("damping = ", "is not a valid TOML file: "),
])  # fmt: skip
def test_a_bad_file_is_named_in_one_line(line, message, capsys, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(f'component = "LinearDamper"\n[parameters]\n{line}\n', "utf-8")
    found = complaint(capsys, ["modes", "--device", str(path), "--speed", "20"])
    assert message in found and "mine" in found


def test_a_file_that_is_not_there(capsys, tmp_path):
    assert "cannot read" in complaint(capsys, ["modes", "--device", str(tmp_path / "absent.toml")])


def test_a_parameter_that_two_parts_have_needs_the_name_of_the_part(capsys):
    arguments = ["modes", "--device", "rider:mean_2011", "--speed", "20"]
    message = complaint(capsys, [*arguments, "--set", "added_steer_inertia=0.1"])
    assert "'added_steer_inertia' is a parameter of vehicle and device: write device.added_steer_inertia=0.1" in message
    assert main([*arguments, "--set", "device.added_steer_inertia=0.1"]) == 0


def test_a_place_that_cannot_be_written(capsys, tmp_path):
    (tmp_path / "file").write_text("", "utf-8")
    for option in ("--json", "--plot", "--csv"):
        assert f"{option}: cannot write {tmp_path / 'file' / 'x.png'}: " in complaint(
            capsys, ["modes", option, str(tmp_path / "file" / "x.png")]
        )
    assert f"cannot write {tmp_path}: it is a folder" in complaint(capsys, ["modes", "--json", str(tmp_path)])
    assert "no file can be written into the folder" in complaint(
        capsys, ["tour", "--out", str(tmp_path / "file")]
    )  # before the tour starts
    assert "'x.gif' does not end in .png, .svg, .pdf" in complaint(capsys, ["modes", "--plot", "x.gif"])
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_a_place_that_is_lost_meanwhile(tmp_path):
    (tmp_path / "file").write_text("", "utf-8")
    with pytest.raises(InputError, match=f"cannot write {re.escape(str(tmp_path / 'file' / 'x.txt'))}: "):
        write_text(tmp_path / "file" / "x.txt", "")


def test_names_of_components_are_unique_words():
    found = [components.component(spec) for spec in components.every_name()]
    assert len({c.name for c in found}) == len(found)
    assert all(isinstance(c, Component) for c in found)
