"""The axes of links that bend, as they are drawn in the figure in the plane."""

import numpy as np

from shockpc.core.spatial import Array
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.figure.silhouette import to_plane
from shockpc.wings.compliant.links.bent_landing import FlexibleLanding
from shockpc.wings.compliant.links.segments import Division
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding

BENT = 0.2
"""Largest deflection of a link that bends as it is drawn, as a share of its length, about."""

SLIGHT = 0.05
"""Share of the largest deflection up to which that of a link is not drawn."""

SAMPLES = 400
"""Times at which the largest deflection is sought."""


def bent_axes(profile: ShockProfile, compliant: CompliantLanding) -> tuple[list[Array], str]:
    """The axes (k, 2) of links that bend, in the plane, and a note of how they are drawn."""
    links, origin = bent_links(compliant), profile.landing.state.origin[0]
    shares = []
    for points, deflection in links:
        length = np.linalg.norm(points[-1] - points[0])
        shares.append(float(np.linalg.norm(deflection, axis=1).max() / length))
    factor = 1.0
    if max(shares) > 0.0:
        factor = float(f"{BENT / max(shares):.0e}")
    axes = []
    for (points, deflection), share in zip(links, shares, strict=True):
        if share > SLIGHT * max(shares):
            axes.append(to_plane(origin + points + factor * deflection, profile.plane))
    note = (
        f"dashed: the axes of links that bend, when they bend most; deflections {factor:g} times "
        f"as large."
    )
    return axes, note


def bent_links(compliant: CompliantLanding) -> list[tuple[Array, Array]]:
    """Axes of the links that bend, when they do most: points (k, 3) and deflections [m].

    The points are in world axes; a deflection is the distance from a straight link.

    The points are from the base: where the link begins, its hinges, and where it ends.
    """
    landing = compliant.moving
    if not isinstance(landing, FlexibleLanding):
        return []
    times = np.linspace(0.0, compliant.motion.duration, SAMPLES)
    moved, links = compliant.displacements(times), []
    for body, division in landing.flexible.divisions.items():
        first, *segments = landing.flexible.segments[body]
        # Bending turns a hinge about the first two of its axes.
        angles = []
        for segment in segments:
            start = landing.robot.joints[segment].v.start
            angles.append(moved[:, start : start + 2])
        points = _points(division)
        R = landing.state.rotation[0, first]
        deflection = _deflections(division, points, angles) @ R.T
        links.append((landing.state.position[0, first] + points @ R.T, deflection))
    # The time at which the end of some link is farthest from where a straight link has it.
    ends = [np.linalg.norm(deflection[:, -1], axis=1) for _, deflection in links]
    most = int(np.argmax(np.max(ends, axis=0)))
    return [(points, deflection[most]) for points, deflection in links]


def _points(division: Division) -> Array:
    """Points (k, 3) of a straight link: its start, its hinges and its end, in its frame [m].

    Hinges are in the middle of their parts, so that the link ends half a spacing beyond them.
    """
    half, hinges = 0.5 * division.spacing * division.axis, division.hinges
    return np.vstack([hinges[0] - half, hinges, hinges[-1] + half])


def _deflections(division: Division, points: Array, angles: list[Array]) -> Array:
    """Deflections (T, k, 3) of points of a link [m].

    A hinge turned by small angles α moves points behind it by α × their arms.

    Args: points (k, 3); angles (T, 2) of each hinge [rad].
    """
    deflection = np.zeros((len(angles[0]), *points.shape))
    for of_hinge, hinge in zip(angles, division.hinges, strict=True):
        beyond = np.maximum((points - hinge) @ division.axis, 0.0)
        arms = np.cross(division.across[:, None], beyond[:, None] * division.axis)
        deflection += np.einsum("ta,aki->tki", of_hinge, arms)
    return deflection
