"""The words for what is wrong with a scene's equations: who is to blame, not which matrix."""

import numpy as np

from shockpc.core.spatial import Array
from shockpc.model.rows import Rows
from shockpc.robot.robot import Robot

__all__ = ["contradiction", "ill_conditioned", "nearly_repeated"]


def ill_conditioned(robot: Robot, rows: Rows, weakest: float, apart: Array, left: float, trusted: float, chosen: str) -> str:
    """The warning for two solutions that part: where, how far, what is to blame, what was done about it.

    Args:
        robot: the robot.
        rows: what is held.
        weakest: smallest singular value of the rows over the largest [1].
        apart: (nb,) how far the solutions are apart, 0 for bodies that do not move [1].
        left: estimated error of the one that is reported [1].
        trusted: from where on they are said to part [1].
        chosen: the one that is reported.
    """
    names = [body.name for body in robot.bodies]
    worst = int(np.argmax(apart))
    mass = np.array([body.mass for body in robot.bodies])
    light, heavy = int(np.argmin(mass)), int(np.argmax(mass))
    ratio = mass[heavy] / mass[light] if mass[light] > 0.0 else np.inf
    blame = (
        f'the masses of "{names[light]}" ({mass[light]:.3g} kg) and "{names[heavy]}" ({mass[heavy]:.3g} kg) lie far apart'
        if ratio >= 1e4
        else f"the rows of {', '.join(block.name for block in rows.blocks)} nearly repeat one another"
        if weakest < 1e-3
        else f"a chain of {len(names)} bodies hardly passes the shock on"
        if len(names) > 20
        else "the mechanism is close to a posture in which it cannot give way"
    )
    seen = (
        "so ill-conditioned that there is no second solution to hold the first against"
        if np.isinf(apart[worst])
        else f'two independent solutions part by {apart[worst]:.0e} at body "{names[worst]}"'
        if apart[worst] > trusted
        else "rounding in the placements shows"
    )
    good = f"good to about {left:.0e} of each body's motion" if np.isfinite(left) else "and no digit of them is sure"
    return f"{seen}: {blame}; the numbers are those of {chosen}, {good}"


def nearly_repeated(rows: Rows) -> str:
    """The warning for rows of which nobody can tell whether they repeat one another."""
    return (
        f"the rows of {', '.join(block.name for block in rows.blocks)} repeat one another so nearly that rounding decides whether "
        "one more of them holds, and if it decides wrongly, no digit below is right: put their points exactly together, or "
        "farther apart than a billionth of the robot"
    )


def contradiction(rows: Rows, row: int, left: Array) -> str:
    """The message for a row that cannot be met: whose it is, along what, by how much. Args: left (nc,) what is left [m/s]."""
    block, own = next((block, own) for block, own in zip(rows.blocks, rows.slices, strict=True) if row < own.stop)
    axis = " ".join(f"{u:.3g}" for u in block.axes[row - own.start] + 0.0)
    return (
        f"{block.name} cannot be stopped: {abs(left[row]):.3g} m/s are left along ({axis}), because the mechanism cannot move that "
        "way here, or another contact asks for the opposite; leave that direction out of the contact or of the strike, "
        "or free the base"
    )
