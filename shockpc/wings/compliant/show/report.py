"""Parts of a landing's report on contacts of finite stiffness and links that bend."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from shockpc.core.spatial import Array
from shockpc.impact.springs import spring_time
from shockpc.landing.places import PlaceKind
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.of_points import low_passes
from shockpc.quantities.selection import quantity
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.report import Picture, Report
from shockpc.show.tables import Sheet
from shockpc.show.wording import robot_name
from shockpc.studies.analyze.view import View
from shockpc.wings.compliant.of_profile import compliant_of, rigid_links_of
from shockpc.wings.compliant.show.texts import stiffness_text

if TYPE_CHECKING:
    from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding

TITLES: dict[PlaceKind, dict[str, str]] = {
    "point": {
        "peak_acceleration": "peak with this stiffness [g]",
        "peak_acceleration_time": "at [ms]",
    },
    "contact": {
        "duration": "99 % of the impulse in [ms]",
        "peak_force": "peak force [N]",
        "peak_force_time": "at [ms]",
    },
    "joint": {
        "peak_joint_force": "peak force [N]",
        "peak_joint_moment": "peak moment [N m]",
        "peak_torque": "peak along the axis [N m, N]",
    },
}
"""Headings that people read, with {} for the component of a vector."""

SHOCKS = ("shock_compressed", "shock_separated")
"""Shocks of the table of these."""


def tables(profile: ShockProfile) -> dict[str, Callable[[ShockProfile], Sheet]]:
    """Tables of a landing, by name."""
    if not profile.scene.yields:
        return {}
    from shockpc.wings.compliant.show.sheets import modes_sheet

    return {"modes": modes_sheet}


def views(profile: ShockProfile) -> dict[str, View]:
    """Views of the tables that people read, by name."""
    if not profile.scene.yields:
        return {}
    from shockpc.wings.compliant.show.sheets import VIEWS

    return VIEWS


def lines(profile: ShockProfile) -> list[str]:
    """Lines of how far the impulse model holds, and when links can be taken as rigid."""
    return [*_difference_lines(profile), *_bending_lines(profile)]


def pictures(profile: ShockProfile, spectrum: bool) -> list[Picture]:
    """The landing over time, and on request the shock response spectrum of the points."""
    if not profile.scene.yields:
        return []
    name = robot_name(profile.robot)
    over_time = Picture(
        "time",
        f"forces, accelerations and torques of {name} over time",
        "wings.compliant.show.figure:draw_time",
        (profile,),
    )
    of_points = Picture(
        "spectrum",
        f"shock response spectrum of points of {name}",
        "wings.compliant.show.figure:draw_spectrum",
        (profile,),
    )
    points_move = any(place.body >= 0 for place in profile.places("point"))
    return [over_time, of_points] if spectrum and points_move else [over_time]


def document(profile: ShockProfile, spectrum: bool) -> dict[str, Any]:
    """Keys of the JSON document; `spectrum` says whether it has the shock response spectra."""
    compliant, stiffness = compliant_of(profile), None
    if compliant is not None:
        time = spring_time(profile.landing)
        stiffness = {
            "contact_stiffness": profile.scene.contact_stiffness,
            "springs_count": time if math.isfinite(time) else None,
            "spectra": _spectra(profile, compliant) if spectrum else None,
        }
    return {"stiffness": stiffness}


def charts(profile: ShockProfile) -> list[dict[str, Any]]:
    """Charts of the page: forces of the contacts and accelerations of the points over time."""
    compliant = compliant_of(profile)
    if compliant is None:
        return []
    from shockpc.wings.compliant.show.page import force_and_acceleration

    return force_and_acceleration(profile, compliant)


def overlay(profile: ShockProfile) -> tuple[list[Array], str]:
    """Further lines (k, 2) of the figure in the plane, and a note of what they are.

    They are the axes of links that bend, when they bend most.
    """
    compliant = compliant_of(profile)
    if compliant is None or not profile.scene.flex:
        return [], ""
    from shockpc.wings.compliant.show.bent_links import bent_axes

    return bent_axes(profile, compliant)


def beyond_report() -> Report:
    """The report of `shockpc paper --beyond`: what the rigid answer of the paper is off by."""
    from shockpc.wings.compliant.beyond.report import bending_report

    return bending_report()


def _difference_lines(profile: ShockProfile) -> list[str]:
    """Lines of how far the jumps of the impulse model are from those of finite stiffness."""
    stiffness = compliant_of(profile)
    if stiffness is None:
        return []
    percent = max(100.0 * stiffness.difference, 0.1)
    digits = 0 if percent >= 10.0 else 1
    how = (
        f"jumps of the bodies at the end of contact, {stiffness_text(profile)}, relative to the "
        f"largest"
    )
    if stiffness.agrees_by_construction and percent < 1.0:
        how += (
            "; with restitution 0 they agree by construction, which is no evidence for the "
            "impulse model"
        )
    elif percent >= 1.0 and np.any(stiffness.restitution > 0.0):
        how += (
            "; part of the difference is between two laws of restitution, and remains on "
            "stiffer contacts"
        )
    if profile.scene.contact_damping is not None:
        rebounds = [
            f"{e:.3g} at {contact.frame}"
            for e, contact in zip(stiffness.restitution, profile.contacts, strict=True)
        ]
        how += (
            f"; the damping causes a restitution of {', '.join(rebounds)}; the impulse model has "
            "it only with --restitution"
        )
    return [f"impulse model: within {percent:.{digits}f} % of the finite-stiffness result ({how})"]


def _bending_lines(profile: ShockProfile) -> list[str]:
    """Lines of when the links can be taken as rigid.

    The scene has to say how long the contact lasts.
    """
    links = rigid_links_of(profile)
    if links is None:
        return []
    if isinstance(links, str):
        return [f"rigid links: when they are right is not known, because {links}"]
    return list(links.lines)


def _spectra(profile: ShockProfile, stiffness: "CompliantLanding") -> dict[str, Any]:
    """The shock response spectra of the points [g]."""
    from shockpc.wings.compliant.over_time.spectra import DAMPING, SPECTRUM, spectrum

    points = [place for place in profile.places("point") if place.body >= 0]
    filters = low_passes(profile.landing, points)
    compute = quantity("point", "delta_v").compute
    raw = [spectrum(stiffness, compute, points, damping) / GRAVITY for damping in DAMPING]
    of_points = []
    for k, (place, low_pass) in enumerate(zip(points, filters, strict=True)):
        of_point = {"frame": place.name, "response": [response[:, k] for response in raw]}
        if low_pass is not None:
            behind = [
                spectrum(stiffness, compute, [place], damping, low_pass) for damping in DAMPING
            ]
            of_point["filtered_response"] = [response[:, 0] / GRAVITY for response in behind]
        of_points.append(of_point)
    return {"frequencies": list(SPECTRUM), "damping": list(DAMPING), "points": of_points}
