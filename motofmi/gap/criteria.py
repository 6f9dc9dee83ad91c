"""The decision thresholds of the gap workflow, in one place.

Every function that decides something gets a `Criteria` as an argument, and the one that was used is written into
verdict.json under `criteria`. Iteration limits, window lengths and bounds on the search effort are not here: they stand
beside the code that uses them.

Abbreviations: chi2 is the sum of squared residuals over the noise; the reduced chi2 is chi2 per degree of freedom, 1
where the residuals are noise; the excess is the reduced chi2 minus 1; delta BIC is the gain in chi2 minus the penalty
of the added parameters (k ln n, and 2 for each unknown of a single run); on blocks the gain in chi2 is n times that in
mean logarithmic loss. "Blind cases" are those of docs/gap.md.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Criteria:
    """All decision thresholds. Change some of them with `dataclasses.replace(Criteria(), tie_delta_bic=6.0)`."""

    # Adequacy: is what a model leaves consistent with the noise?

    adequate_reduced_chi2: float = 1.12
    """A model is adequate below this reduced chi2 [1]. Right models of simulated steer tests stay below it: 0 false
    alarms in 228 runs, with bursts, doubled noise and riders who change by 6 % among them."""

    scatter_deviations: float = 4.5
    """With few data the limit of adequacy is this many standard deviations sqrt(2 / n) of the reduced chi2 above 1 [1],
    and so is the smallest excess that counts on validation runs. It equals `adequate_reduced_chi2` at about 2,800
    degrees of freedom."""

    chance_deviations: float = 2.5
    """By how many standard deviations sqrt(2 n) chi2 may lie beside its mean n by chance [1]: what is left below that
    needs no further effect, and a second effect is not fitted where it would have to gain more than noise leaves."""

    # One effect

    first_effect_delta_bic: float = 12.0
    """The least delta BIC of a first effect [1]; below it the answer is `none` or `unknown`. With it 0 of 300 blind
    cases in which nothing is hidden were given a name (docs/gap.md)."""

    tie_delta_bic: float = 10.0
    """Effects, pairs and forms within this delta BIC of the best one are tied with it [1]: odds below exp(5) = 150 to 1
    ("very strong" evidence begins at 10; Kass, Raftery, J. Am. Statist. Assoc. 90 (1995) 773-795)."""

    clear_lead_delta_bic: float = 40.0
    """By how much delta BIC a family must lead all others to be named without an adequate form, and within which a
    rival is fitted to convergence and considered in the proposed experiments [1]. On simulated rigs, names were
    reliable from delta chi2 40 on."""

    explained_share: float = 0.5
    """Share of the base's excess that any name must close, where more is left than chance explains [1]. Weak cogging
    (outside the library) beside friction came out as friction, which closes two fifths."""

    unspecified_form_closed_share: float = 0.95
    """Share of the fitted runs' excess that a family must close to be named without an adequate form [1]. Effects
    outside the library came to 0.94 at most in the blind cases."""

    unspecified_form_closed_share_flexible_noise: float = 0.5
    """The same share, for fitted and for validation runs, where the noise is what a flexible model leaves [1]: no form
    of a single law is as flexible as that model."""

    far_from_noise: float = 10.0
    """From this reduced chi2 on a name needs a validation run that confirms it, and no experiment is proposed between
    the nearest candidates [1]."""

    # Two effects

    second_effect_delta_bic: float = 15.0
    """The least delta BIC of a second effect on top of the first [1]; more than for the first, since small errors of a
    large effect look like another one."""

    second_effect_share: float = 0.005
    """The same as a share of the first effect's delta chi2 [1]: beside a very large gain, tiny errors of
    the model are significant."""

    # Validation runs

    predicted_reduced_chi2: float = 1.5
    """Below this reduced chi2 a validation run was predicted [1]; above it `none` becomes `unknown`, and a name gets a
    limitation. Right names leave 0.9 to 1.1 in 97 of 100 validation runs of 160 s and more."""

    validation_excess: float = 0.2
    """The least excess on a validation run that can reject a name [1]: twice what right names leave in 97
    of 100 runs of 160 s."""

    validation_excess_share: float = 0.005
    """The same as a share of what the base leaves there [1], for the reason of `second_effect_share`."""

    validation_closed_share: float = 0.85
    """Share of the base's excess on validation runs that an effect closes if it is not rejected, with its values as
    fitted [1]. Of 85 right names in the blind cases 79 closed at least 0.95 and three 0.91 to 0.94; three were of a
    form outside the library."""

    validation_refit_deviations: float = 3.0
    """Standard deviations by which a validation run may be missed where the values move within their errors [1]."""

    validation_evidence_chi2: float = 40.0
    """Delta chi2 of validation runs alone that counts as evidence for an effect whose values the fitted runs determine
    badly [1]; the same level as `reliable_delta_chi2`."""

    validation_warning_share: float = 0.5
    """A limitation says so where an effect closes less than this share of the excess on a validation run [1]."""

    # Components: doubts about data and base

    slow_noise_share: float = 0.2
    """Share of the measured motion (rms) that may be missed and still be called slow noise [1]; beyond it
    `none` becomes `unknown`."""

    unexplained_variance: float = 0.5
    """Share of the variance of an output, without white noise, that a named model may leave in the fitted or in the
    validation runs [1]: one minus the coefficient of determination. Beyond it an effect can stand for the motion of
    another machine."""

    unit_factor: float = 1.5
    """Factor within which the common factor of all fitted forces and masses must agree with that of a unit (57.3, 1e3,
    1e6) for the unit to be doubted [1]: the values that a component starts from may be wrong by as much."""

    unit_scatter: float = 2.0
    """Factor within which a parameter shares the common factor [1]."""

    unit_share: float = 2 / 3
    """Share of the parameters with force or mass in their unit that must share the common factor [1]."""

    implausible_factor: float = 1e3
    """Factor between a fitted parameter and its start from which a limitation asks for the unit [1]."""

    inseparable_cosine: float = 0.99
    """Cosine of the slopes of an inertia and another parameter above which the inertia keeps its value [1]: a motion
    imposed at one frequency gives 1."""

    sensor_offset_errors: float = 4.0
    """Standard errors above which a sensor's offset is reported [1]: by chance once in 16,000."""

    # Vehicles: linear effects that errors of the model imitate

    weak_form_linear_share: float = 0.2
    """Share of the disturbance's power that a linear effect must gain in the weak form [1]: under feedback the motion
    depends on the disturbance, which then looks like a small linear effect."""

    prediction_linear_share: float = 0.005
    """Share of the noise's power that each parameter of a linear effect must gain in one-step prediction [1]: errors of
    the base and of the disturbances' spectra gain less."""

    prediction_linear_share_without_torque: float = 0.03
    """The same where no steer torque is recorded [1]: the torque of hands is no noise with a smooth spectrum."""

    prediction_second_effect_share: float = 0.1
    """Share of the first effect's gain that a second one must gain in one-step prediction [1], in place of
    `second_effect_share`."""

    given_matrix_error: float = 0.1
    """Relative standard error of the terms that make up the entries of given vehicle matrices [1]: moments and inertias
    that compound many masses and lengths."""

    # Experiments

    reliable_delta_chi2: float = 40.0
    """Delta chi2 from which names are reliable [1]: 66 of 66 blind cases from there on were right or in the tied set.
    Proposed runs are added until every two rivals are that far apart."""

    weak_name_delta_bic: float = 40.0
    """A name with a smaller delta BIC rests on little [1]: an experiment is proposed that would confirm it."""

    further_run_delta_chi2: float = 10.0
    """The least delta chi2 that a proposed run must add between two rivals [1]."""

    same_response_share: float = 1e-3
    """An effect is tied before any test with a rival that leaves less than this share of its squared signature [1]."""

    # Where the base misses

    false_discovery_rate: float = 0.01
    """False-discovery rate of the places of misfit (Benjamini, Hochberg 1995) [1]: 1 of 600 runs with
    nothing but noise had one."""

    # Comparison on blocks, where the noise is not known and no model is adequate

    confidence_set_level: float = 0.05
    """Level of the model confidence set [1] (Hansen, Lunde, Nason 2011): the probability with which the best model is
    eliminated from the set. It is also the level of the test for superior predictive ability (Hansen 2005), of the
    whole library against the base, on fitted runs and on validation runs: without it, 8 of 210 draws of real residuals
    with nothing to name were given a name (docs/gap.md)."""

    least_share: float = 0.1
    """Least share of the closable misfit on validation runs that a named effect closes [1]: what closes less is
    significant where runs are long, and not worth an effect in the model."""

    equal_share: float = 0.01
    """Share of the closable misfit within which two effects explain the same [1]: the one with no more parameters is
    tied with the other, whatever the confidence set says."""

    value_errors: float = 2.0
    """Standard errors (sandwich over blocks, and band) below which a value is consistent with zero [1]: an effect of
    such a magnitude is not named, and such a parameter of its form is not reported as a value."""

    tolerance: float = 0.01
    """Share of the motion (rms) that a model may miss beyond what a flexible model leaves, and still be called
    sufficient [1]. Sensors of real machines drift and quantise by about as much."""

    enough_blocks: int = 12
    """Independent blocks of fitted, and of validation runs, below which a limitation says that there are few [1]: with
    fewer, the resampled means scatter too coarsely for a level of 5 %."""

    fewest_fitted_blocks: int = 8
    """Independent blocks of fitted runs below which there is no verdict [1]: the distribution of resampled means is too
    coarse."""

    fewest_validation_blocks: int = 6
    """Independent blocks of validation runs below which they are not judged alone, but together with the left-out
    blocks of the fitted runs [1]: with fewer, resampled means are too coarse for an interval of 95 %. A name must then
    reduce their mean loss."""
