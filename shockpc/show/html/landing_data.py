"""Landings as data for `report.js`: surfaces, places, and matrices of every contact velocity."""

import base64
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.landed import CONTRADICTION, LandingProof
from shockpc.landing.landing import PosedLanding
from shockpc.method.constraints import Constraint, constraint_point
from shockpc.profile import ILL_CONDITIONED
from shockpc.quantities.ground.levels import levels, on_ground
from shockpc.quantities.of_bodies import ROUNDED
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.quantities.strike_matrices import (
    StrikeAxes,
    StrikeMatrices,
    contact_normals,
    peak_per_speed,
    strike_matrices,
)
from shockpc.robot.robot import Robot
from shockpc.show.figure.body_shapes import body_shapes
from shockpc.show.figure.picture import letter
from shockpc.show.figure.view import numbered
from shockpc.show.html.charts import CONFIG, STYLES, picture, placed
from shockpc.show.html.posture import PostureSliders
from shockpc.show.html.surfaces import Surface, surfaces
from shockpc.show.wording import BRACKETED
from shockpc.text.printed import printable
from shockpc.text.wings import from_wings

MOST_TRIANGLES = 90_000
"""Limit of the surfaces of a page, which keeps it below 8 MB."""

SHORT_ARRAY = 2**16
"""Vertices of which indices have two bytes."""

SurfacesOf = Mapping[int, Sequence[Surface]]
"""Surfaces of the bodies, in their frames, by the identity of the robot."""


def surfaces_of(landings: Mapping[str, ShockProfile]) -> SurfacesOf:
    """The surfaces that are drawn of the robots of landings."""
    robots: dict[int, Robot] = {}
    for profile in landings.values():
        robots[id(profile.robot)] = profile.robot
    drawn = {}
    for key, robot in robots.items():
        shapes = [shapes for shapes, _ in body_shapes(robot)]
        drawn[key] = surfaces(shapes, MOST_TRIANGLES // len(robots))
    return drawn


def page_data(
    landings: Mapping[str, ShockProfile], drawn: SurfacesOf, postures: Mapping[str, PostureSliders]
) -> dict[str, Any]:
    """The data that the script needs.

    Args:
        landings: by name.
        drawn: the surfaces of their robots.
        postures: the sliders of each by name, if it has any.
    """
    # Robots of equal surfaces share them.
    geometries: list[dict[str, Any]] = []
    number_of: dict[int, int] = {}
    for key, parts in drawn.items():
        geometry = _geometry(parts)
        if geometry not in geometries:
            geometries.append(geometry)
        number_of[key] = geometries.index(geometry)
    data = []
    for name, profile in landings.items():
        key = id(profile.robot)
        landing = _landing(name, profile, drawn[key], number_of[key])
        landing["sliders"] = postures[name].sliders if name in postures else None
        data.append(landing)
    return {
        "geometries": geometries,
        "landings": data,
        "contradiction": CONTRADICTION,
        "singular": ILL_CONDITIONED,
        "bracketed": BRACKETED,
        "styles": STYLES,
        "config": CONFIG,
    }


def _geometry(parts: Sequence[Surface]) -> dict[str, Any]:
    """The surfaces of the bodies, in their frames, in base 64.

    They are in single precision and whole numbers, little-endian.
    """
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    triangles = [part.triangles + start for part, start in zip(parts, starts, strict=False)]
    wide = bool(starts[-1] > SHORT_ARRAY)
    return {
        "vertices": _encoded(np.concatenate([part.vertices for part in parts]), "<f4"),
        "triangles": _encoded(np.concatenate(triangles), "<u4" if wide else "<u2"),
        "wide": wide,
        "starts": starts[:-1].tolist(),
    }


def _encoded(values: np.ndarray, kind: str) -> str:
    return base64.b64encode(values.astype(kind).tobytes()).decode()


def _landing(
    name: str, profile: ShockProfile, drawn: Sequence[Surface], geometry: int
) -> dict[str, Any]:
    """The data of a landing.

    They are placements, what follows from the velocity of the base, and what shock is relative to.

    Args:
        name: of the landing.
        profile: the landing.
        drawn: surfaces of the bodies.
        geometry: number of those surfaces.
    """
    landing, robot, plane = profile.landing, profile.robot, profile.plane
    axes = StrikeAxes.of(profile)
    vertices = placed(drawn, profile.rotation, profile.position)
    directions = (plane.normal, plane.e1, plane.e2)
    contacts = _contacts(profile)
    return {
        "geometry": geometry,
        **picture(name, vertices, profile.contacts[0].point, directions),
        "bodies": [printable(body) for body in profile.bodies],
        "numbered": list(numbered(profile)),
        "com": robot.coms.tolist(),
        "gyration": robot.gyration.tolist(),
        "rotation": profile.rotation.tolist(),
        "position": profile.position.tolist(),
        "origin": landing.state.origin[0].tolist(),
        "models": _models(profile),
        "joints": [printable(place.name) for place in profile.places("joint")],
        "grounds": _grounds(profile),
        "strike": _strike(landing, axes),
        "reference": _references(profile) if profile.scene.v_in == "com" else contacts,
        **{key: axis.tolist() for key, axis in axes._asdict().items()},
        "normal": plane.normal.tolist(),
        "contacts": contacts,
        "points": _points(profile),
        "peak": peak_per_speed(landing),
        "ground": _ground(landing),
        "length": landing.length,
        "rounded": ROUNDED,
        "histories": _histories(profile),
    }


def _references(profile: ShockProfile) -> list[dict[str, Any]]:
    """The velocities of which the fastest normalises shock, for a velocity of the base."""
    base = profile.landing.before.velocity
    return [_motion(velocity, base) for velocity in profile.reference_velocities]


def _histories(profile: ShockProfile) -> list[dict[str, Any]]:
    """The charts of wings."""
    histories: list[dict[str, Any]] = []
    for charts_of in from_wings("report", "charts"):
        histories += charts_of(profile)
    return histories


def _strike(landing: PosedLanding, axes: StrikeAxes) -> list[float]:
    """Angle and heading [deg] and speed [m/s] of the velocity of the scene."""
    angle, heading, speed = axes.polar(landing.before.velocity)
    return [round(math.degrees(angle), 9), round(math.degrees(heading), 9), round(speed, 9)]


def _models(profile: ShockProfile) -> dict[str, Any]:
    """The matrices of each joint model; None without a solution."""
    proofs = {
        "free": profile.proof_with("free"),
        "with drives": profile.proof,
        "locked": profile.proof_with("locked"),
    }
    return {name: _matrices_of(proof, profile.landing) for name, proof in proofs.items()}


def _matrices_of(proof: LandingProof | None, landing: PosedLanding) -> dict[str, Any] | None:
    # A foot that only one of them lifts leaves the tables of contacts without a common row.
    if proof is None or proof.landing.lifted != landing.lifted:
        return None
    return _matrices(strike_matrices(proof))


def _matrices(strikes: StrikeMatrices) -> dict[str, Any]:
    """The matrices for the script.

    Those of impulses have ten digits, which keep the page small, and null where an impulse is not
    determined.
    """
    matrices = {key: matrix.tolist() for key, matrix in strikes._asdict().items()}
    for key in ("contacts", "loads"):
        matrices[key] = [list(map(_ten_digits, matrix)) for matrix in matrices[key]]
    return matrices


def _ten_digits(row: Sequence[float]) -> list[float] | None:
    if math.isnan(sum(row)):
        return None
    return [float(f"{x:.10g}") for x in row]


def _contacts(profile: ShockProfile) -> list[dict[str, Any]]:
    """The contacts: where they are, and how fast for a velocity of the base."""
    constraints = profile.landing.constraints
    base = profile.landing.before.velocity
    contacts = []
    for k, (contact, normal) in enumerate(
        zip(profile.contacts, contact_normals(profile), strict=True)
    ):
        constraint = constraints[k]
        base_velocity = base if _follows_base(constraint) else None
        contacts.append(
            {
                "name": printable(contact.frame),
                "body": constraint.body,
                "r": constraint.point.tolist(),
                # The page takes a contact that approaches along its normal as one that strikes,
                # which an end stop does.
                "normal": normal.tolist(),
                **_motion(contact.approach, base_velocity),
            }
        )
    return contacts


def _follows_base(constraint: Constraint) -> bool:
    """True if a contact moves with the base: neither at a velocity of its own nor an end stop."""
    return constraint.velocity is None and constraint.kind != "stop"


def _motion(velocity: Array, base: Array | None) -> dict[str, Any]:
    """A velocity as that of the base and a constant; None for one that does not follow the base."""
    if base is None:
        return {"follows": False, "extra": velocity.tolist()}
    return {"follows": True, "extra": (velocity - base).tolist()}


def _points(profile: ShockProfile) -> list[dict[str, Any]]:
    """The sensors and points."""
    points = []
    for k, (place, point) in enumerate(zip(profile.landing.points, profile.points, strict=True)):
        points.append(
            {
                "letter": letter(k),
                "name": printable(place.name),
                "body": place.body,
                "r": place.r.tolist(),
                "axes": place.axes.T.tolist(),
                "position": point.position.tolist(),
            }
        )
    return points


def _grounds(profile: ShockProfile) -> list[dict[str, Any]]:
    """Names and normals of the contacts and standing feet."""
    grounds = []
    for place in profile.places("contact"):
        normal = profile.landing.constraints[place.number].normal
        grounds.append({"name": printable(place.name), "normal": normal.tolist()})
    return grounds


def _ground(landing: PosedLanding) -> dict[str, Any] | None:
    """Contacts and standing feet, which flat ground has to touch first.

    Each has the distance that its shapes reach below its point [m]. None where nothing lands on
    flat ground, or the robot does not come down as a whole.
    """
    level = on_ground(landing)
    if landing.base == "fixed" or not level:
        return None
    state = landing.state
    feet = [(*landing.contacts, *landing.stance)[k] for k in level]
    points = np.stack([constraint_point(state, foot) for foot in feet], axis=1)
    here = levels(landing, state.rotation, state.position, points)
    depths = (points[0] @ landing.up - here.contacts[0]).tolist()
    contacts = []
    for k, foot, depth in zip(level, feet, depths, strict=True):
        contacts.append(
            {
                "body": foot.body,
                "r": foot.point.tolist(),
                "depth": depth,
                "number": k if k < len(landing.contacts) else -1,
            }
        )
    return {"up": landing.up.tolist(), "tolerance": here.tolerance, "contacts": contacts}
