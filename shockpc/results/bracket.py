"""The same landing with free, modelled and locked drives: the choice that moves the answer most."""

import numpy as np

from shockpc.core.spatial import Array, velocity_at
from shockpc.errors import SceneError, SolveError
from shockpc.health import DOUBTFUL, judge
from shockpc.landing import Landing
from shockpc.model.columns import freedom
from shockpc.model.dynamics import tree
from shockpc.model.equation import Solution, solve
from shockpc.result import Bracket
from shockpc.results.doubts import ill_posed
from shockpc.results.points import Spot
from shockpc.robot.robot import Robot
from shockpc.scene import Scene

__all__ = ["drive_bracket"]


def drive_bracket(
    robot: Robot, scene: Scene, landing: Landing, modelled: Solution, spots: tuple[Spot, ...], v_in: float
) -> tuple[tuple[Bracket, ...], tuple[str, ...]]:
    """Shock at the heaviest body's centre of mass and at every sensor, for three models of the drives; and a warning if in doubt.

    Args:
        robot: the robot.
        scene: complete.
        landing: the same as arrays.
        modelled: its solution.
        spots: sensors and points.
        v_in: speed that shock is normalised by [m/s].
    """
    nv = robot.model.nv
    none = np.zeros(nv, dtype=bool)
    every = ~none
    if robot.free_base:
        every[:6] = False

    state, doubtful = landing.state, dict[str, float]()

    def solution(drives: str, locked: np.ndarray) -> Solution | None:
        """None where this model of the drives leaves nothing to move, or cannot be solved."""
        try:
            G = freedom(robot, scene.base or "free", landing.plane, state.rotation[:, 0], locked)
            found = solve(robot, state, landing.rows, np.zeros(nv), G)
            enlarged = max(float(found.impact.condition[0]), 1.0 / float(found.impact.weakest[0]))
            if found.impact.marginal[0] or ill_posed(state, enlarged):
                found, health, _ = judge(robot, state, tree(robot, state, np.zeros(nv), G), landing.rows, found)
                if health.error_estimate > DOUBTFUL:
                    doubtful[drives] = health.error_estimate
        except (SceneError, SolveError):
            return None
        b = found.equation.b[0, :, -1]
        left = found.equation.J_c[0] @ found.impact.delta_qd[0, :, -1] + b
        return found if np.abs(left).max() <= 1e-6 * np.abs(b).max() else None

    free = modelled if landing.drives.model == "free" else solution("free", none)
    locked = modelled if landing.drives.model == "locked" else solution("locked", every)
    heaviest = max(range(len(robot.bodies)), key=lambda i: robot.bodies[i].mass)
    places = [(robot.bodies[heaviest].name, heaviest, robot.bodies[heaviest].com)]
    places += [(spot.label, spot.frame.body, spot.r) for spot in spots if spot.frame.body >= 0]
    warnings = tuple(f"shock with {drives} drives: good to about {off:.0e} of itself only" for drives, off in doubtful.items())
    found = tuple(
        Bracket(
            place=name,
            free=_shock(free, body, r, v_in),
            as_modelled=_shock(modelled, body, r, v_in),
            locked=_shock(locked, body, r, v_in),
        )
        for name, body, r in places
    )
    return found, warnings


def _shock(solution: Solution | None, body: int, r: Array, v_in: float) -> float | None:
    """Shock at a point of a body; None without a solution."""
    if solution is None:
        return None
    jump = solution.jumps[0, body, :, -1]
    return float(np.linalg.norm(velocity_at(jump[:3], jump[3:], r))) / v_in
