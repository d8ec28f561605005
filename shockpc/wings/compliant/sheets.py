"""The tables of a landing on contacts of finite stiffness."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.tables import Column, Sheet
from shockpc.studies.analyze.sheets import joints_sheet, points_sheet, shocks_sheet
from shockpc.studies.analyze.views import READINGS, each_contact, readings_notes, view
from shockpc.wings.compliant.texts import stiffness_text

MOTORS = {"standing": ", motors hold the weight", "none": ", motors give no torque"}
"""Torques of motors, in words."""


def soft_views(profile: ShockProfile, most: int | None) -> dict[str, Callable[[], Sheet]]:
    """What people read of the tables, by name; of long ones `most` rows."""
    views: dict[str, Callable[[], Sheet]] = {
        "stiffness_contacts": lambda: stiffness_contacts(profile),
        "stiffness_points": lambda: stiffness_points(profile),
        "stiffness_shocks": lambda: stiffness_shocks(profile),
        "modes": lambda: modes_sheet(profile).without("contacts_share").largest(most, "mode"),
        "peaks": lambda: peaks_sheet(profile, most),
    }
    if not profile.points:
        del views["stiffness_points"]
    if not profile.robot.joint_names:
        del views["peaks"]
    return views


def modes_sheet(profile: ShockProfile) -> Sheet:
    """The modes of the landing, and what they carry."""
    stiffness = profile.stiffness
    assert stiffness is not None
    modes = stiffness.motion.modes
    columns: dict[Any, Iterable[Any]] = {"frequency [Hz]": modes.frequency}
    columns[Column("energy", "kinetic energy before", "J")] = modes.energy
    for place, share in zip(profile.places("contact"), stiffness.force_shares, strict=False):
        columns[Column(f"force_share_{place.name}", f"of the force of {place.name}", "%")] = share
    of_contacts = modes.participation[stiffness.number >= 0].sum(axis=0)
    columns[Column("contacts_share", "share of the contacts", "%")] = of_contacts
    return Sheet.of("modes, and the normal force that they carry", columns)


def peaks_sheet(profile: ShockProfile, most: int | None) -> Sheet:
    """Peaks through every joint, or through those with the largest torque, or else force."""
    keys = ("joint", "peak_joint_force", "peak_joint_moment", "peak_torque", "joint_torque_share")
    sheet = joints_sheet(profile).only(*keys)
    sheet = sheet._replace(title="peaks through the joints", notes=())
    force = profile.value("peak_joint_force", "joint")
    torque = profile.value("peak_torque", "joint")
    sizes = np.where(torque > 0.0, 1e6 * torque, force)
    return sheet.largest(most, "joint", sizes.tolist())


def stiffness_contacts(profile: ShockProfile) -> Sheet:
    """Forces of the contacts, and their times."""
    title = (
        f"contacts of {stiffness_text(profile)} (frozen geometry{_constant_forces(profile)}; "
        f"double precision, not proven)"
    )
    headings = {"contact": "", "duration": "", "peak_force": "", "peak_force_time": ""}
    return view(each_contact(profile), title, headings)


def stiffness_points(profile: ShockProfile) -> Sheet:
    """Peak accelerations of the points."""
    title = "peak accelerations on these contacts"
    headings = {"point": "", "peak_acceleration": "peak [g]", "peak_acceleration_time": ""}
    return view(points_sheet(profile), title, {**headings, **READINGS}, readings_notes(profile))


def stiffness_shocks(profile: ShockProfile) -> Sheet:
    """Shocks against those of the impulse model."""
    headings = {
        "shock_at": "",
        "shock_compressed": "end of compression [-]",
        "shock_separated": "end of contact [-]",
        "shock": "impulse model [-]",
    }
    return view(shocks_sheet(profile), "velocity jumps on these contacts", headings)


def _constant_forces(profile: ShockProfile) -> str:
    """Which constant forces act, where they are not the usual ones."""
    if not profile.scene.gravity:
        return ", without gravity"
    motors = MOTORS.get(profile.scene.joints.motors or "", "")
    torques = ", given torques" if profile.scene.joints.torque else ""
    return f", under gravity{motors}{torques}"
