"""Which families compete with all of their forms, and from where a form begins."""

from types import SimpleNamespace

import numpy as np
import pytest

from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate
from motofmi.gap.estimation.effect_fit import contained
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.experiment import FreeParameter
from motofmi.gap.selection.candidate_search import (
    FLEXIBLE_RATIO,
    _fit_in_stages,
    _may_gain_enough,
    _near_families,
    _other_forms,
    _ScreenedLibrary,
)
from motofmi.gap.selection.pairs import pairs_of


def candidate(family, delta_bic, reduced=1.0):
    fit = SimpleNamespace(reduced=reduced, freedom=1500, chi2=1500 * reduced)
    return Candidate(SimpleNamespace(family=family), fit, delta_bic + 10, delta_bic)


@pytest.mark.parametrize("best, other, reduced, near", [
    (900.0, 620.0, 1.0, True),  # 300 may be made up for by another form, whatever the gain
    (1830.0, 1460.0, 1.0, True),  # so may a quarter: a reflex without its slow muscles behind a head
    (17100.0, 16780.0, 1.0, True),
    (16000.0, 11000.0, 1.0, False),
    (16000.0, 11000.0, 2.0, True),  # where the best is not adequate either, half is enough
    (16000.0, 7000.0, 2.0, False),
])  # fmt: skip
def test_families_that_may_catch_up_compete_in_all_forms(best, other, reduced, near):
    assert (
        "reflex"
        in _near_families([candidate("extra_mode", best, reduced), candidate("reflex", other, reduced)], Criteria())
    ) is near


def test_no_curve_of_its_own_brings_a_family_back_from_far():
    """A loop that leaves 15 times what a limit leaves: its flexible form takes minutes, and cannot make up for that."""
    limit, loop = candidate("saturation", 508_000.0, 4.7), candidate("hysteresis", 393_000.0, 69.0)
    assert "hysteresis" in _near_families([limit, loop], Criteria()) and "hysteresis" not in _near_families(
        [limit, loop], Criteria(), FLEXIBLE_RATIO
    )
    assert "hysteresis" in _near_families([limit, candidate("hysteresis", 480_000.0, 19.0)], Criteria(), FLEXIBLE_RATIO)


def model(*own, family="extra_mode"):
    return SimpleNamespace(own=list(own), effects=(SimpleNamespace(family=family),))


def test_a_form_does_no_worse_than_one_that_it_contains():
    head, neck = model("inertia", "frequency"), model("inertia", "frequency", "bend")
    fits = [
        SimpleNamespace(model=head, chi2=1600.0),
        SimpleNamespace(model=neck, chi2=900.0),
        SimpleNamespace(model=model("inertia", family="other"), chi2=1.0),
    ]
    assert contained(neck, fits) == 1600.0
    assert contained(head, fits) == float("inf")


def test_the_simplest_form_of_a_family_says_when_its_turn_is(monkeypatch):
    """A delay that may grow promises most here, the reflex keeps what it promises: what the first family keeps spares
    others the fit."""
    def form(family, gain, unknowns):
        return SimpleNamespace(family=family, flexible=False, at_one=(), has_states=lambda: False,
                               free_parameters=lambda: unknowns, gain=gain)  # fmt: skip

    forms = [
        form("channel_delay", 900.0, "two"),
        form("channel_delay", 40.0, "1"),
        form("reflex", 800.0, "2 "),
        form("drift", 90.0, "2 "),
    ]
    promised = [SimpleNamespace(effect=each, gain=each.gain) for each in forms]
    monkeypatch.setattr("motofmi.gap.selection.candidate_search.screen", lambda found, effects, keep: promised)
    field = _ScreenedLibrary(SimpleNamespace(model=SimpleNamespace(effects=())), forms, Criteria())
    assert field.order == ["reflex", "drift", "channel_delay"]
    assert field.promised["channel_delay"] == 900.0  # still what decides whether it is worth a fit


@pytest.mark.parametrize("effects, reduced, unknowns, hopeful", [
    ((), 1.0, 3, True), (("reflex",), 2.0, 3, True), (("reflex",), 1.0, 3, False), (("reflex",), 1.0, 1, True)])  # fmt: skip
def test_beside_an_adequate_effect_a_second_one_must_promise_a_part_of_its_penalty(effects, reduced, unknowns, hopeful):
    """Of 15 and ln 1500 for each parameter a quarter: 9.2 for three, 6 at least for one; elsewhere a small promise may
    grow."""
    found = SimpleNamespace(model=SimpleNamespace(effects=effects), reduced=reduced, freedom=1500, count=1500)
    assert _may_gain_enough(found, SimpleNamespace(gain=7.0, start=[0.0] * unknowns), 15.0, Criteria()) is hopeful


@pytest.mark.parametrize(
    "reduced, calls", [(1.0, [["a"], ["a", "b", "c", "d", "e"]]), (3.0, [["a"], ["b", "c"], ["d"], ["e"]])]
)
def test_rivals_of_an_adequate_effect_and_its_other_forms_are_fitted_side_by_side(reduced, calls, monkeypatch):
    made = []

    def fitted(found, signatures, so_far, beat, known, criteria):
        made.append([s.effect.family for s in signatures])
        return [
            Candidate(
                s.effect,
                SimpleNamespace(
                    model=SimpleNamespace(effects=(s.effect,)), reduced=reduced, freedom=1500, chi2=1500 * reduced
                ),
                100.0,
                90.0,
            )
            for s in signatures
        ]

    def signature(family):
        return SimpleNamespace(
            effect=type(family, (), {"family": family, "nonlinear_parameters": list, "flexible": False}),
            gain=100.0,
            start=[0.0],
        )

    monkeypatch.setattr("motofmi.gap.selection.candidate_search.fit_each", fitted)
    monkeypatch.setattr("motofmi.gap.selection.candidate_search.contained", lambda model, fits: np.inf)
    monkeypatch.setattr(
        "motofmi.gap.selection.candidate_search.screen",
        lambda found, effects, keep: [further for e in effects if e is further.effect],
    )
    signatures, further = {name: [signature(name)] for name in "abcde"}, signature("a")
    field = SimpleNamespace(forms={name: [s.effect for s in of] + [further.effect] * (name == "a") for name, of in signatures.items()},
                            found=SimpleNamespace(chi2=1.0, count=1500), criteria=Criteria(), order=list("abcde"), of_family=signatures, promised=dict.fromkeys("abcde", 100.0),
                            top=100.0, signatures=[s for each in signatures.values() for s in each])  # fmt: skip
    assert len(_fit_in_stages(field, [], 4, True, np.inf, [])) >= 5 and made == calls
    led = fitted(field.found, signatures["a"], [], np.inf, [], Criteria())
    made.clear()
    _fit_in_stages(
        field, led, 4, True, np.inf, []
    )  # the first family has led: it is among those of the wave, and its other forms wait until that is fitted
    assert all(names.count("a") == 0 for names in made)


@pytest.mark.parametrize("behind, again", [(0.9, False), (5.0, True)])
def test_a_form_that_ended_where_one_does_that_it_contains_is_not_fitted_again(behind, again, monkeypatch):
    plain, richer = (type(form, (), {"family": "reflex", "flexible": False}) for form in ("plain", "richer"))
    fits = [SimpleNamespace(model=SimpleNamespace(own=own, effects=(e,)), reduced=1.0, freedom=1500, chi2=chi2)
            for e, own, chi2 in ((plain, ["gain"], 1500.0), (richer, ["gain", "rate"], 1500.0 + behind))]  # fmt: skip
    monkeypatch.setattr("motofmi.gap.selection.candidate_search.screen", lambda found, effects, keep: list(effects))
    field = SimpleNamespace(found=None, criteria=Criteria(), forms={"reflex": [plain, richer]})
    assert _other_forms(field, [Candidate(fit.model.effects[0], fit, 900.0, 880.0) for fit in fits]) == [richer] * again


@pytest.mark.parametrize(
    "chi2, source, possible", [(1400.0, "orders", False), (1550.0, "orders", True), (1400.0, "flexible_model", True)]
)
def test_no_pair_is_tried_where_its_second_effect_would_have_to_gain_from_the_noise(
    chi2, source, possible, monkeypatch
):
    """Of 1500 numbers with chi-square 1400, no law can gain 150: 1250 is 4.6 standard deviations below what noise
    leaves."""
    effect, tried = SimpleNamespace(family="extra_mode"), []
    monkeypatch.setattr("motofmi.gap.selection.pairs.search_candidates", lambda *_, **__: tried.append(1) or [])
    best = SimpleNamespace(
        model=SimpleNamespace(effects=(effect,)),
        runs=[SimpleNamespace(noise_source=source)],
        chi2=chi2,
        freedom=1500,
        reduced=chi2 / 1500,
    )
    assert pairs_of(Candidate(effect, best, 30_000.0, 29_900.0), [], []) == [] and bool(tried) is possible


@pytest.mark.parametrize("start, beat, reached", [(0.02, 100.0, True), (0.02, 1.0, True), (1e-5, 100.0, False)])
def test_a_fit_that_may_only_step_is_not_given_up_for_a_short_one(start, beat, reached):
    """From a fiftieth of its value a parameter has six steps by a factor of two to go, of which the first gains next to
    nothing; from where it is not felt, none."""
    shape = np.linspace(1.0, 2.0, 50)
    run = SimpleNamespace(data=shape, deviation=np.full(50, 0.01))
    model = SimpleNamespace(
        names=["gain"], base=["gain"], own=[], rows=[], sizes=[], effects=(), unknowns=lambda run: 0,
        magnitudes=(np.zeros(1), np.full(1, 10.0)), component=SimpleNamespace(table={}, values={"gain": 0.0}),
        experiment=SimpleNamespace(free=[FreeParameter("gain")], measured_effects={}),
        reduced=lambda run, q: (np.exp(q[0]) * shape / run.deviation, np.exp(q[0]) * (shape / run.deviation)[:, None]))  # fmt: skip
    found = fit(model, [run], np.log([start]), beat=beat)
    assert (abs(np.exp(found.x[0]) - 1.0) < 1e-4) == reached
