"""Pictures of the reference: sign conventions, and the errors of couplings in the modes."""

from io import BytesIO
from typing import Any

import numpy as np

import motofmi
from fmus.cosimulation.cosimulate import join
from fmus.cosimulation.coupling import COUPLINGS, Coupling
from fmus.cosimulation.coupling_error import largest_stable_step, predict
from fmus.cosimulation.network import Network
from fmus.cosimulation.subsystems.subsystem import LinearSubsystem
from fmus.expressions.functions import NUMERIC
from fmus.linear_analysis.linearisation import linearise

SPEED, STEPS, LARGEST = 30.0, np.geomspace(2e-4, 2e-2, 21), 1.0  # m/s, s, s
CASTER, RADIUS, WHEELBASE = np.radians(27.0), 0.3, 1.4  # rad, m, m; of the sketch
INK, ACCENT = "#2b5b84", "#b5432a"


def _svg(figure: Any) -> str:
    data = BytesIO()
    figure.savefig(data, format="svg", metadata={"Date": None})
    return data.getvalue().decode()


def ridden_motorcycle() -> Network:
    """Sharp's motorcycle with the mean rider at SPEED, as two linear subsystems."""
    rider = motofmi.rider("mean_2011")
    inertia = rider.run(rider.start_values(), NUMERIC)["port_inertia"]  # moves with the handlebar
    vehicle = motofmi.vehicle("sharp_1971", added_steer_inertia=inertia)
    parts = {"vehicle": linearise(vehicle, speed=SPEED), "device": linearise(rider)}
    subsystems = {name: LinearSubsystem(space) for name, space in parts.items()}
    return Network(subsystems, join(subsystems))


def largest_stable_steps() -> list[tuple[Coupling, float]]:
    """Every coupling with its largest stable step [s]."""
    network = ridden_motorcycle()
    return [(coupling, largest_stable_step(coupling, network, largest=LARGEST)) for coupling in COUPLINGS.values()]


def coupling_errors() -> str:
    """The error of each coupling in the damping ratio of the least damped mode over the communication step."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - no window, no state

    network = ridden_motorcycle()
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    axes = figure.add_subplot()
    for name, coupling in COUPLINGS.items():
        errors = [_damping_error(predict(coupling, network, float(step))) for step in STEPS]
        axes.loglog(1e3 * STEPS, errors, label=f"{name} ({coupling.order})", linewidth=1.2)
    axes.set(xlabel="communication step [ms]", ylabel="relative error of the damping ratio [1]", ylim=(1e-10, 10))
    axes.legend(fontsize="x-small", title="coupling (order)", ncols=2)
    return _svg(figure)


def _damping_error(predicted: Any) -> float:
    """Of the oscillation with the least damping."""
    ratio = np.where(predicted.oscillatory, -predicted.exact.real / np.abs(predicted.exact), np.inf)
    return float(abs(predicted.damping_error[int(ratio.argmin())]))


def signs() -> str:
    """The axes and the positive senses: the vehicle from the right and from above."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - no window, no state

    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    _from_the_right(figure.add_subplot(1, 2, 1))
    _from_above(figure.add_subplot(1, 2, 2))
    return _svg(figure)


def _from_the_right(axes: Any) -> None:
    turn = np.linspace(0, 2 * np.pi, 80)
    for centre in (0.0, WHEELBASE):
        axes.plot(centre + RADIUS * np.cos(turn), RADIUS + RADIUS * np.sin(turn), color=INK)
    foot = WHEELBASE + 0.08
    head = foot - np.tan(CASTER) * 1.15
    axes.plot([foot + np.tan(CASTER) * 0.0, head], [0, 1.15], color=ACCENT, linestyle="--", linewidth=1)
    axes.plot([0, 0.45, head + 0.12], [RADIUS, 0.62, 0.86], color=INK, linewidth=2)
    axes.plot([WHEELBASE, head + 0.12], [RADIUS, 0.86], color=INK, linewidth=2)
    axes.plot([0, WHEELBASE + 0.6], [0, 0], color="0.5", linewidth=0.8)
    _arrow(axes, (-0.4, 1.2), (0.05, 1.2), "x, forward")
    _arrow(axes, (-0.4, 1.2), (-0.4, 0.8), "z, down")
    axes.text(-0.4, 1.27, "y, to the right (to the viewer)", fontsize=8, va="bottom")
    axes.text(foot + 0.02, 0.06, "trail", fontsize=8, color=ACCENT)
    axes.text(
        head + 0.02,
        1.12,
        "steer axis: $\\delta$, $s$, $w$, $T_h$, $T_f$\npositive to the right",
        fontsize=8,
        color=ACCENT,
        ha="left",
        va="bottom",
    )
    axes.text(head + 0.27, 0.72, "caster angle", fontsize=8, color=ACCENT)
    axes.set(title="from the right", xlim=(-0.5, 2.3), ylim=(-0.15, 1.75), aspect="equal")
    axes.axis("off")


def _from_above(axes: Any) -> None:
    steer = np.radians(25.0)
    axes.plot([-0.25, 0.25], [0, 0], color=INK, linewidth=6)
    axes.plot([0, 1.1], [0, 0], color=INK, linewidth=2)
    axes.plot(
        [1.1 - 0.25 * np.cos(steer), 1.1 + 0.25 * np.cos(steer)],
        [0.25 * np.sin(steer), -0.25 * np.sin(steer)],
        color=INK,
        linewidth=6,
    )
    bar = np.array([[-np.sin(steer), -np.cos(steer)], [np.sin(steer), np.cos(steer)]]) * 0.33
    axes.plot(0.95 + bar[:, 0], bar[:, 1], color=INK, linewidth=2)
    _arrow(axes, (-0.2, 0.75), (0.3, 0.75), "x")
    _arrow(axes, (-0.2, 0.75), (-0.2, 0.35), "y")
    axes.annotate(
        "",
        (1.42, -0.24),
        (1.46, 0.06),
        arrowprops={"arrowstyle": "->", "color": ACCENT, "connectionstyle": "arc3,rad=-0.3"},
    )
    axes.text(1.5, -0.1, "steer angle $\\delta > 0$", fontsize=8, color=ACCENT)
    axes.annotate(
        "",
        (0.5, -0.62),
        (0.8, -0.45),
        arrowprops={"arrowstyle": "->", "color": ACCENT, "connectionstyle": "arc3,rad=-0.3"},
    )
    axes.text(0.45, -0.8, "yaw rate $> 0$", fontsize=8, color=ACCENT)
    axes.set(title="from above", xlim=(-0.5, 2.3), ylim=(-0.95, 0.95), aspect="equal")
    axes.axis("off")


def _arrow(axes: Any, start: tuple[float, float], end: tuple[float, float], text: str) -> None:
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": "k"})
    axes.text(*end, f" {text}", fontsize=8, va="center")
