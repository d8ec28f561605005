"""Remarks on what measured landings do not tell of unknowns, and on errors of the model.

An error of the model is one beyond the scatter of the landings.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np

from shockpc.text.printed import few
from shockpc.wings.recordings.identify.fit import Fit, FittedValues
from shockpc.wings.recordings.identify.predictor import Predicted, Predictor
from shockpc.wings.recordings.identify.uncertainty import ALIKE, DRAWS, Uncertainty, drawn
from shockpc.wings.recordings.tables.prediction import coordinate

HARD = 0.95
"""Correlation from which two unknowns are hard to tell apart."""

HELD = 0.1
"""Rate of a joint before touchdown up to which motors may hold it, as a share of its jump."""

SLIGHT = 0.02
"""Share of the jumps by which they may be wrong without a word."""


def of_unknowns(known: Uncertainty, n: int) -> Iterator[str]:
    """Remarks on what the data do not tell of the unknowns.

    Args: n, number of landings.
    """
    names = [unknown.variation.subject for unknown in known.unknowns]
    if known.scatter < ALIKE:
        yield (
            f"not identifiable: the {n} landings are all alike (at the same contact speed their "
            f"predicted jumps differ by {100.0 * known.scatter:.2g} %), so model errors go into "
            "the values without widening the intervals. Measure landings in other postures"
        )
    for name, unknown in zip(names, known.unknowns, strict=True):
        if unknown.state == "no influence":
            yield (
                f"{name} has no influence on the measured velocities, so any value predicts the "
                "same"
            )
        if unknown.state == "at its bound":
            yield (
                f"{name} is at the bound {unknown.value:.4g} of its range, so it has no interval; "
                "widen the range if possible"
            )
    yield from _unseen_directions(known, names)
    for i, j in combinations(range(len(names)), 2):
        r = known.correlation[i, j]
        if abs(r) > HARD:
            yield (
                f"{names[i]} and {names[j]} are hard to tell apart (correlation {r:.2f}): an error "
                f"in one can be "
                "compensated by the other"
            )


def _unseen_directions(known: Uncertainty, names: Sequence[str]) -> Iterator[str]:
    """Remarks on unknowns, or several together, of which the data say nothing."""
    for direction in known.unseen:
        part = []
        for j, unknown in enumerate(known.unknowns):
            if abs(direction[j]) > 0.3 and unknown.state != "no influence":
                part.append(j)
        if len(part) == 1:
            yield (
                f"{names[part[0]]} cannot be determined: over its range it "
                "changes the jumps by less than the misfit"
            )
        elif part:
            signs = "with" if direction[part[0]] * direction[part[1]] > 0.0 else "against"
            yield (
                f"the data cannot tell {' and '.join(names[j] for j in part)} apart: one changed "
                f"{signs} the other predicts "
                "the same; fix one of them, or measure landings that differ more"
            )


def of_errors(known: Uncertainty, errors: Mapping[str, float]) -> Iterator[str]:
    """That nothing is identified, where the error does not fall.

    Args: errors, as in `Identification`.
    """
    names = []
    for unknown in known.unknowns:
        if unknown.state == "error does not fall":
            names.append(unknown.variation.subject)
    if names:
        yield (
            f"nothing is identified: the error is {errors['before']:.3g} with the scene as given, "
            f"and {errors['after']:.3g} with the values found. The model is wrong elsewhere than "
            f"in {' or '.join(names)}"
        )


def of_control(fit: Fit) -> Iterator[str]:
    """A remark that control acts as inertia.

    It is made where joints whose inertia is unknown move very little before touchdown, as motors
    hold them.

    A damping k_d takes the impulse k_d t Δq̇ in a window t, as an inertia k_d t would.
    """
    predictor = fit.predictor
    window = predictor.measured[0].time
    velocities = _velocities_of_inertias(predictor)
    jumps = []
    for k, column in enumerate(predictor.measured):
        if coordinate(column, predictor.robot) in velocities:
            jumps.append(k)
    if not jumps:
        return
    before = np.abs(predictor.rows.before.joint_rates[fit.used][:, velocities])
    after = np.abs(np.nan_to_num(fit.before.measured[fit.used][:, jumps]))
    if np.median(before) > HELD * np.median(after):
        return
    inertia = (
        "k_d t in a window t" if window is None else f"{1e-3 * window:.3g} s × k_d in {window:g} ms"
    )
    example = "" if window is None else f", {2e-3 * window:.2g} kg m² at k_d = 2 N m s/rad"
    yield (
        "the joints move very little before touchdown, so motors may hold them: the damping k_d of "
        f"their control acts like an inertia of {inertia}{example}, which the value includes. "
        "Switch the control off before touchdown, or subtract this inertia"
    )


def _velocities_of_inertias(predictor: Predictor) -> list[int]:
    """Numbers of the joint velocities whose inertia is unknown."""
    robot = predictor.robot
    names: set[str] = set()
    for unknown in predictor.unknowns:
        if unknown.kind.of_rotors:
            names.update(robot.match_joints(unknown.target))
    velocities: list[int] = []
    for name in sorted(names):
        v = robot.joint(name).v
        velocities += range(v.start, v.stop)
    return velocities


def of_model(fit: Fit, solution: FittedValues, errors: Mapping[str, float]) -> Iterator[str]:
    """Remarks on errors beyond the scatter of the landings, or beyond the noise.

    Args: errors, as in `Identification`.
    """
    n = int(fit.used.sum())
    ratios = list(_wrong_ratios(fit, solution.predicted, n)) if n > 5 else []
    if ratios:
        yield (
            "the model is still wrong by more than the scatter of the landings, which no interval "
            "covers: ratios of measured to predicted jumps are "
            + few(ratios, 6, noun=" velocities")
        )
    if not fit.by_energy:
        ratio = float(np.sqrt(np.sum(solution.residuals**2) / fit.freedoms))
        # The root of a mean of n squares scatters by 1 / √(2 n); three times that is rare.
        if ratio > 1.0 + 3.0 / np.sqrt(2.0 * n):
            yield (
                "the model is still wrong by more than the noise: the remaining error is "
                f"{ratio:.3g} times the given noise"
            )
    after, free = errors["after"], errors["free impulse"]
    if after > SLIGHT and free < 0.9 * after:
        yield (
            f"the error is {after:.2f}, and {free:.2f} with the best "
            "impulse at the contacts under any law. This part comes from the robot's inertia, its "
            "posture or the measurement, and the rest from the law of contact"
        )


def _wrong_ratios(fit: Fit, predicted: Predicted, n: int) -> Iterator[str]:
    """Ratios of measured to predicted jumps that differ from 1 by more than the landings scatter.

    Of each velocity the slope Σ x y / Σ x² of measured over predicted jumps, with the middle 99.7 %
    of its values for landings drawn with replacement, which are as far as three standard
    deviations.
    """
    counts = drawn(n, 2 * DRAWS)
    for k, column in enumerate(fit.predictor.measured):
        measured = predicted.measured[fit.used, k]
        # x = y = 0 where nothing was measured.
        x = np.where(np.isnan(measured), 0.0, np.nan_to_num(predicted.jumps[fit.used, k]))
        y = np.nan_to_num(measured)
        xx = float(x @ x)
        if not xx > 0.0:
            continue
        slopes = counts @ (x * y) / np.maximum(counts @ (x * x), 1e-300)
        low, high = np.quantile(slopes, (0.0015, 0.9985))
        if not (low <= 1.0 + SLIGHT and high >= 1.0 - SLIGHT):
            yield f"{column.name} {x @ y / xx:.2f} ({low:.2f} … {high:.2f})"
