"""Restitution and damping of a single mass on a spring and a damper."""

import numpy as np

from shockpc.core.spatial import Array


def damper_restitution(ratio: Array) -> Array:
    """The restitution of a mass on a spring and a viscous damper, which do not pull.

    The motion ends where their force falls to zero.

    e = exp(−2ζ acos ζ / √(1 − ζ²)), beyond ζ = 1 with acosh ζ and √(ζ² − 1) (Schwager and Pöschel
    2007, Granular Matter 9:465). Args: ratio ζ = c / (2 √(k m)) of the damping to the critical one.
    """
    return np.asarray(np.exp(-2.0 * ratio * rise(ratio)))


def rise(ratio: Array) -> Array:
    """ω times the time until the largest force of a mass on a spring and a damper in series.

    It is acos ζ / √(1 − ζ²) of a viscous damper.

    Args: ratio ζ of the damping to the critical one, 2 ζ ω the rate at which the damper lets the
    force decay.
    """
    size = np.abs(np.sqrt((1.0 - ratio) * (1.0 + ratio) + 0.0j))
    angle = np.abs(np.arccos(ratio + 0.0j))
    return np.asarray(np.where(size > 0.0, angle / np.where(size > 0.0, size, 1.0), 1.0))


def series_damping(restitution: Array) -> Array:
    """The damping ratio ζ of a mass on a spring and a damper in series, by its restitution e.

    The damper is viscous, and e is that of the motion until the force is zero.

    e = exp(−πζ / √(1 − ζ²)), and the rate at which the damper lets the force decay is 2 ζ √(k/m).
    At ζ = 1, e = 0: the force decays without an end, and so does the velocity.
    """
    logarithm = 0.0 - np.log(np.maximum(restitution, 1e-300))
    return np.where(restitution > 0.0, logarithm / np.hypot(np.pi, logarithm), 1.0)
