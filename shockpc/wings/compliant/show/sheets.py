"""The tables of a landing on contacts of finite stiffness."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from shockpc.quantities.shock_profile import ShockProfile
from shockpc.show.tables import Heading, Sheet
from shockpc.studies.analyze.sheets import points_sheet, shocks_sheet
from shockpc.studies.analyze.view import View, kept
from shockpc.studies.analyze.views import (
    READINGS,
    each_contact,
    each_joint,
    has_joints,
    has_points,
    readings_notes,
)
from shockpc.wings.compliant.of_profile import compliant_of
from shockpc.wings.compliant.show.texts import stiffness_text

MOTORS = {"standing": ", motors hold the weight", "none": ", motors give no torque"}
"""Torques of motors, in words."""


def modes_sheet(profile: ShockProfile) -> Sheet:
    """The modes of the landing, and what they carry."""
    stiffness = compliant_of(profile)
    assert stiffness is not None
    modes = stiffness.motion.modes
    columns: dict[Any, Iterable[Any]] = {"frequency [Hz]": modes.frequency}
    columns[Heading("energy", "kinetic energy before", "J")] = modes.energy
    for place, share in zip(profile.places("contact"), stiffness.force_shares, strict=False):
        columns[Heading(f"force_share_{place.name}", f"of the force of {place.name}", "%")] = share
    of_contacts = modes.participation[stiffness.number >= 0].sum(axis=0)
    columns[Heading("contacts_share", "share of the contacts", "%")] = of_contacts
    return Sheet.of("modes, and the normal force that they carry", columns)


def _few_modes(profile: ShockProfile) -> Sheet:
    return modes_sheet(profile).without("contacts_share")


def _first_rows(_: ShockProfile, __: Sheet) -> list[float]:
    """No sizes: a terminal shows the first rows."""
    return []


def _peak_sizes(profile: ShockProfile, _: Sheet) -> list[float]:
    """The largest torques come first, then the largest forces."""
    force = profile.value("peak_joint_force", "joint")
    torque = profile.value("peak_torque", "joint")
    sizes: list[float] = np.where(torque > 0.0, 1e6 * torque, force).tolist()
    return sizes


def _contacts_title(profile: ShockProfile) -> str:
    return (
        f"contacts of {stiffness_text(profile)} (frozen geometry{_constant_forces(profile)}; "
        "double precision)"
    )


def _constant_forces(profile: ShockProfile) -> str:
    """Text of the constant forces that act, where they are not the usual ones."""
    if not profile.scene.gravity:
        return ", without gravity"
    motors = MOTORS.get(profile.scene.joints.motors or "", "")
    torques = ", given torques" if profile.scene.joints.torque else ""
    return f", under gravity{motors}{torques}"


VIEWS: dict[str, View] = {
    "stiffness_contacts": View(
        each_contact,
        lambda _: True,
        kept("contact", "duration", "peak_force", "peak_force_time"),
        _contacts_title,
        brief=True,
    ),
    "stiffness_points": View(
        points_sheet,
        has_points,
        {"point": "", "peak_acceleration": "peak [g]", "peak_acceleration_time": "", **READINGS},
        "peak accelerations on these contacts",
        readings_notes,
        brief=True,
    ),
    "stiffness_shocks": View(
        shocks_sheet,
        lambda _: True,
        {
            "shock_at": "",
            "shock_compressed": "end of compression [-]",
            "shock_separated": "end of contact [-]",
            "shock": "impulse model [-]",
        },
        "velocity jumps on these contacts",
    ),
    "modes": View(_few_modes, lambda _: True, None, sizes=_first_rows, row="mode"),
    "peaks": View(
        each_joint,
        has_joints,
        kept("joint", "peak_joint_force", "peak_joint_moment", "peak_torque", "joint_torque_share"),
        "peaks through the joints",
        sizes=_peak_sizes,
        row="joint",
        brief=True,
    ),
}
"""Views of the tables of a landing on such contacts that people read, by name."""
