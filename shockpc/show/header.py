"""The header of a landing, the same in tables and figures.

It gives robot, posture, base, contacts, strike, joint model and plane.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from shockpc.core.interval import Interval, interval_text
from shockpc.core.spatial import Array
from shockpc.impact.springs import spring_time
from shockpc.judgement.accuracy import SHARE
from shockpc.judgement.unknowns import merged
from shockpc.landing.contact import contact_name
from shockpc.landing.end_stops import side_of
from shockpc.landing.scenes.joint_options import Rotor
from shockpc.landing.scenes.scene_file import sideways
from shockpc.method.base import Base
from shockpc.method.constraints import slices_of
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.bodies_and_joints import WORLD
from shockpc.robot.feet_and_sensors import BENT, each_foot, feet, recognised
from shockpc.robot.robot import Robot
from shockpc.robot.usual_base import hangs, usual_base
from shockpc.show.wording import number_text, vector_text
from shockpc.text.diagnostic import Diagnostic, alike
from shockpc.text.printed import count, few, listed, printable
from shockpc.text.wings import from_wings

JOINT_MODELS = {
    "free": "free (zero reflected inertia; a stiff gearbox changes the results considerably)",
    "geared": "geared (every joint has the reflected inertia of its drive)",
    "locked": "locked (no joint moves, so the robot is one rigid body)",
    "mixed": "mixed (some joints have reflected inertia or are locked, the others are free)",
}

BASES = {
    "free": "falls freely; --base planar or --base fixed restrains it",
    "planar": "moves in the plane only; --base free releases it",
    "fixed": "fixed to the world; --base free releases it",
    "world": (
        f'fixed to the world, because its root link is called "{WORLD}"; --base free releases it'
    ),
    "file": "fixed in the file; --base free releases it",
    "weld": "fixed to the world by a weld of the file; --base free releases it",
    "arm": (
        "fixed to the world, because the robot has no feet and hangs on its root by one chain; "
        "--base free releases it"
    ),
    "legs": (
        f'freed, although its root link is called "{WORLD}", because legs hang on that; --base '
        f"fixed holds it"
    ),
}

ROUNDED = 1e-6
"""Deflection of a spring that postures with six decimals leave where it is relaxed [rad, m]."""

PLANES = {"xz": "xz (sagittal)", "yz": "yz (frontal)", "xy": "xy (from above)"}


def landing_text(profile: ShockProfile) -> str:
    """The kind of a landing in words: on all feet, on some contacts together, or on one alone."""
    robot, contacts = profile.robot, profile.landing.contacts
    held = ", the base held" if hangs(robot, profile.landing.base) else ""
    if len(contacts) == 1:
        return f"{contact_name(profile.scene)} only{held}"
    feet_of_robot = each_foot(robot)
    on_feet = False
    if recognised(robot):
        frames = {*feet(robot), *feet_of_robot}
        on_feet = all(contact.frame in frames for contact in contacts)
    struck = sorted(contact.body for contact in contacts)
    if on_feet and struck == sorted(robot.frame(foot).body for foot in feet_of_robot):
        number = len(feet_of_robot)
        which = "both" if number == 2 else f"all {number_text(number)}"
        return f"{which} feet together{held}"
    return f"{contact_name(profile.scene)} together{held}"


def landings_text(landings: Mapping[str, ShockProfile]) -> str:
    """The kinds of landings in words, or their names.

    The kinds are on all level feet, on those of edges of their support, and on single ones.
    """
    first, *others = landings.values()
    if not others:
        return landing_text(first)
    contacts: dict[frozenset[str], None] = {}
    for profile in landings.values():
        contacts[frozenset(contact.frame for contact in profile.scene.contact)] = None
    sizes = [len(frames) for frames in contacts]
    single = sizes.count(1)
    if sizes[0] < 2 or single < 2:
        names = list(landings)
        if len(names) <= 4:
            return "; ".join(names)
        return f"{len(names)}, from {names[0]} to {names[-1]}"
    parts = [landing_text(first)]
    edges = len(sizes) - single - 1
    if edges:
        parts.append(f"{count(edges, 'edge')} of their support")
    parts.append(f"{number_text(single)} single feet")
    return f"{len(landings)}: {', '.join(parts)}"


def contacts_text(landings: Iterable[ShockProfile]) -> str:
    """The places and strikes of the contacts of some landings, each once."""
    texts: dict[str, None] = {}
    for profile in landings:
        for i in range(len(profile.contacts)):
            texts[_contact_text(profile, i)] = None
    return printable(few(list(texts), 8, "; "))


def unknown_lines(landings: Iterable[ShockProfile]) -> list[tuple[str, str]]:
    """The assumptions of landings, (name, text): a line for each thing that is not known.

    Another line says what was chosen.
    """
    lines = []
    chosen = []
    for unknown in merged(profile.unknowns for profile in landings):
        if unknown.known:
            chosen.append(printable(unknown.named))
        else:
            lines.append(("unknown", printable(str(unknown))))
    assumed = "; ".join(chosen)
    if assumed:
        lines.append(("assumed", assumed))
    return lines


def header_lines(profile: ShockProfile) -> list[tuple[str, str]]:
    """The assumptions of the landing, then what was computed; (name, text)."""
    return [*unknown_lines([profile]), *scene_lines(profile)]


def scene_lines(profile: ShockProfile) -> list[tuple[str, str]]:
    """The landing that was computed, a line (name, text) for each part of the scene."""
    robot, scene = profile.robot, profile.scene
    xacro = "".join(f", {name}:={value}" for name, value in scene.xacro.items())
    contacts = [_contact_text(profile, k) for k in range(len(profile.contacts))]
    velocity = f"contact at {strike_text(profile)}: ({vector_text(profile.strike)}) m/s"
    if scene.v_in == "com":
        velocity += f"; shock relative to {profile.v_in:.4g} m/s of the centre of mass"
    lines = {
        "landing": landing_text(profile),
        "robot": f"{robot.label} ({robot.name}, {moving_text(robot, profile.landing.base)}{xacro})",
        "posture": posture_text(profile),
        "base": base_text(robot, scene.base or "free"),
        "contact": "; ".join(contacts),
        "stance": "; ".join(f"{foot.frame}, which stands" for foot in profile.stance),
        "velocity": velocity,
        "joint model": "; ".join([joint_model_text(profile), *_drive_texts(profile)]),
        "plane": plane_text(profile),
    }
    if not profile.stance:
        del lines["stance"]
    return [(name, printable(text)) for name, text in lines.items()]


def shared_lines(landings: Mapping[str, ShockProfile]) -> list[tuple[str, str]]:
    """The assumptions of several landings, then `common_lines`; all lines of a single one."""
    return [*unknown_lines(landings.values()), *common_lines(landings)]


def common_lines(landings: Mapping[str, ShockProfile]) -> list[tuple[str, str]]:
    """Lines that several landings have in common, and their names; all lines of a single one."""
    if len(landings) == 1:
        return scene_lines(*landings.values())
    headers = [dict(scene_lines(profile)) for profile in landings.values()]
    lines = [("landings", landings_text(landings))]
    for name in ("robot", "posture", "base", "joint model"):
        lines.append((name, _common_text([header[name] for header in headers])))
    return lines


def _common_text(texts: Sequence[str]) -> str:
    """The parts of a line that all landings have, such as the drives."""
    text, *others = dict.fromkeys(texts)
    if not others:
        return text
    common = text.split("; ")
    for alternative in others:
        parts = alternative.split("; ")
        common = [part for part in common if part in parts]
    return "; ".join(common) or "differs between the landings"


def shared_warnings(landings: Mapping[str, ShockProfile], without: str = "") -> list[str]:
    """A line for each thing that landings warn of, with the landing in which it is largest.

    They stand after `unknown_lines`.

    Args:
        landings: by name.
        without: warnings of a kind that are left out.
    """
    warnings: list[tuple[Diagnostic, str]] = []
    for name, profile in landings.items():
        for warning in other_warnings(profile):
            if warning.kind != without:
                warnings.append((warning, name))
    lines = []
    for group in alike(warnings):
        worst, _ = group[0]
        line = f"warning: {worst}"
        first, *others = dict.fromkeys(name for _, name in group)
        if 1 + len(others) < len(landings):
            less = f", less in {len(others)} more" if others else ""
            line += f" (in {first}{less})"
        lines.append(line)
    return lines


def plane_text(profile: ShockProfile) -> str:
    """The plane of CoPc and RoPc in words.

    The text says if more than half of the motion before the impact is out of the sagittal plane.
    """
    plane, share = profile.scene.plane, sideways(profile.scene.strike)
    if not isinstance(plane, str):
        return f"normal ({vector_text(profile.plane.normal)})"
    if plane == "xy" or not share > 0.5:
        return PLANES[plane]
    text = f"{PLANES[plane]}; {100.0 * share:.0f} % of the motion is out of the sagittal plane"
    return f"{text}, which --plane xz selects" if plane == "yz" else text


def moving_text(robot: Robot, base: Base) -> str:
    """Mass and number of the bodies of a robot that can move, with its base as given."""
    masses = robot.masses[robot.movable(base)]
    return f"{masses.sum():.4g} kg, {count(len(masses), 'moving body')}"


def base_text(robot: Robot, base: Base) -> str:
    """The motion of the base in words, why it is so, and what changes it."""
    ties = [loop.name for loop in robot.loops if set(loop.bodies) == {-1, 0}]
    if robot.free_base and ties and base != "fixed":
        return f"held to the world by {listed(ties)} of the file; --base fixed holds it altogether"
    usual = usual_base(robot)
    chosen = usual.base == base and usual.reason != "falls"
    return BASES[usual.reason if chosen else base]


def joint_model_text(profile: ShockProfile) -> str:
    """The model of the joints, and what it means or where the drives are from."""
    if not profile.robot.joint_names:
        return "none (the robot has no joints)"
    model = profile.landing.joint_model
    return model.summary if model.drives else JOINT_MODELS[profile.joint_model]


def _drive_texts(profile: ShockProfile) -> list[str]:
    """Texts on what the scene and the file say of the drives, and of the springs."""
    robot, joints, model = profile.robot, profile.scene.joints, profile.landing.joint_model
    texts = []
    for text in _settings(robot, joints.armature, ("kg m²", "kg")):
        texts.append(f"reflected inertia {text}")
    texts += [_rotor_text(name, motor) for name, motor in joints.rotor.items()]
    if joints.locked:
        texts.append(f"locked: {', '.join(joints.locked)}")
    if not joints.carried:
        texts.append("rotors are not coupled to the links that carry them")
    for texts_of in from_wings("landing", "robot_texts"):
        texts += texts_of(profile.scene)
    if model.drives and joints.drives is None and model.armature.any():
        texts.append("--joints free for free joints")
    return texts + _spring_texts(profile)


def _rotor_text(name: str, motor: Rotor) -> str:
    """Inertia and gear of a rotor, and the spring behind it."""
    ratio = "the file's gear ratio"
    if motor.gear_ratio is not None:
        ratio = f"gear ratio {interval_text(motor.gear_ratio)}"
    parts = [f"{interval_text(motor.inertia)} kg m²", ratio]
    if motor.gear is not None:
        parts.append(str(motor.gear))
    if motor.stiffness is not None:
        parts.append(f"behind a spring of {motor.stiffness:g} N m/rad")
    return f"rotor of {printable(name)}: {', '.join(parts)}"


def _spring_texts(profile: ShockProfile) -> list[str]:
    """From when springs have an effect, and the one with the largest load at touchdown."""
    robot, model = profile.robot, profile.landing.joint_model
    sprung = []
    for joint in robot.single_joints:
        if joint.kind != "free" and model.springs[joint.v].any():
            sprung.append(joint.name)
    texts = []
    time = spring_time(profile.landing)
    if sprung and math.isfinite(time):
        texts.append(f"springs have an effect after {1e3 * time:.2g} ms")
    deflection = model.deflection(robot, profile.landing.q)
    load = np.where(np.abs(deflection) > ROUNDED, model.stiffness * deflection, 0.0)
    loads = {name: float(np.abs(load[robot.joint(name).v]).max()) for name in sprung}
    largest = max(loads, key=lambda name: loads[name], default="")
    if largest and loads[largest] > 0.0:
        unit = "N" if robot.joint(largest).unit == "m" else "N m"
        texts.append(
            f"{largest} is loaded by its spring with {loads[largest]:.3g} {unit} at touchdown, "
            f"which has an effect only on contacts of finite stiffness"
        )
    return texts


def posture_text(profile: ShockProfile) -> str:
    """The reference posture and what was set besides, with units."""
    robot, posture = profile.robot, profile.landing.scene.posture
    reference = printable(str(posture.reference))
    if posture.reference == BENT:
        reference += (
            " (neutral, with straight legs bent by 30 deg at the knees and level feet, as no "
            "standing posture is known)"
        )
    words = [
        reference,
        *_settings(robot, posture.joints, ("rad", "m")),
        *_settings(robot, posture.joints_deg, ("deg", "m")),
    ]
    for name, quaternion in posture.joint_quaternions.items():
        words.append(f"{printable(name)} at quaternion ({vector_text(quaternion)})")
    if posture.base_rpy_deg:
        words.append("base at roll {:g}, pitch {:g}, yaw {:g} deg".format(*posture.base_rpy_deg))
    if posture.base_quaternion:
        words.append("base at quaternion ({:g}, {:g}, {:g}, {:g})".format(*posture.base_quaternion))
    return few(words, 8, noun=" settings")


def strike_text(profile: ShockProfile) -> str:
    """Speed of the contact, its direction, and what moves before the impact."""
    strike = profile.scene.strike
    parts = [
        f"{float(np.linalg.norm(profile.strike)):.4g} m/s, {angle_text(profile)} deg from the "
        f"vertical"
    ]
    if strike.drop_height is not None:
        parts.append(f"after a fall of {strike.drop_height:g} m")
    rates = {name: rate for name, rate in strike.joint_velocities.items() if rate}
    moving = _settings(profile.robot, rates, ("rad/s", "m/s"))
    angular_velocity = strike.angular_velocity or ()
    if any(angular_velocity):
        moving = [f"robot rotates at ({vector_text(angular_velocity)}) rad/s", *moving]
    if moving:
        if len(profile.contacts) > 1:
            parts.append("the fastest contact")
        parts.append(few(moving, 4, noun=" joint rates"))
    return ", ".join(parts)


def angle_text(profile: ShockProfile) -> str:
    """Angle of the contact's velocity from straight down [deg], to four digits.

    It is below zero if the contact moves backward in the plane.
    """
    x, y, z = profile.strike
    angle = math.degrees(math.atan2(math.hypot(x, y), -z))
    backward = profile.strike @ profile.plane.forward < -1e-9 * np.linalg.norm(profile.strike)
    return f"{round(-angle if backward else angle, 9) + 0.0:.4g}"


def other_warnings(profile: ShockProfile) -> list[Diagnostic]:
    """The warnings of a landing that `unknown_lines` do not have."""
    said = {str(unknown) for unknown in profile.unknowns}
    return [warning for warning in profile.health.warnings if warning.text not in said]


def other_warning_lines(profile: ShockProfile) -> list[str]:
    """The warnings of a landing, after `unknown_lines`."""
    return [f"warning: {warning}" for warning in other_warnings(profile)]


def _contact_text(profile: ShockProfile, i: int) -> str:
    """The place of a contact, and its strike, in words."""
    scene, constraint = profile.scene.contact[i], profile.landing.contacts[i]
    if constraint.kind == "stop":
        return _stop_text(profile, i)
    contact = profile.contacts[i]
    lowest = ", its lowest point" if scene.at == "lowest" else ""
    parts = [
        f"{scene.frame}{lowest} at ({_position_text(contact.point)}) m",
        _constraint_text(profile, i),
        *_sole_words(profile, i),
    ]
    if scene.restitution:
        parts.append(f"restitution {scene.restitution:g}")
    if scene.normal:
        parts.append(f"normal ({vector_text(scene.normal)})")
    for axis in _left_out(profile, i):
        parts.append(f"not along ({axis}), where only rounding of the file moves it")
    if np.linalg.norm(contact.approach - profile.strike) > 1e-9 * np.linalg.norm(profile.strike):
        parts.append(f"approaches at ({vector_text(contact.approach)}) m/s")
    return ", ".join(parts)


def _stop_text(profile: ShockProfile, i: int) -> str:
    """The end stop that strikes as a contact."""
    scene, constraint = profile.scene.contact[i], profile.landing.contacts[i]
    value = "minimum" if side_of(profile.robot, constraint) > 0.0 else "maximum"
    rebound = f", restitution {scene.restitution:g}" if scene.restitution else ""
    return (
        f"{scene.frame}, the end stop at the {value} value of the joint{rebound}; speeds are "
        f"those of its body's CoM against it"
    )


def _constraint_text(profile: ShockProfile, i: int) -> str:
    """Words on whether a contact sticks or slides, with friction where it has an effect."""
    scene, friction = profile.scene.contact[i], profile.friction
    if not scene.sticks:
        directions: list[str] = []
        for direction in scene.directions:
            if isinstance(direction, str):
                directions.append(direction)
            else:
                directions.append("({:g} {:g} {:g})".format(*direction))
        return f"slides, constrained along {' '.join(directions)}"
    if friction is None or friction.impact is None:
        return "sticks"
    return f"sticks ({friction.state[i]} with friction {profile.scene.friction:g})"


def _position_text(position: Array) -> str:
    """A position to a millimetre [m]."""
    return ", ".join(f"{x:.3f}" for x in position.round(3) + 0.0)


def _sole_words(profile: ShockProfile, i: int) -> list[str]:
    """Words on the part of its sole that a contact carries with.

    These are the edge that the pressure is on, and what its twist needs.
    """
    contact, kind = profile.contacts[i], profile.scene.contact[i].kind
    if kind in ("point", "auto"):
        return []
    if kind == "flat":
        return ["flat"]
    words = ["a corner of its sole"]
    if kind == "edge":
        words = [f"an edge of its sole along ({vector_text(profile.scene.contact[i].edge or ())})"]
        if contact.centre_of_pressure is not None:
            words.append(f"centre of pressure at ({_position_text(contact.centre_of_pressure)}) m")
    if contact.twist_needed is not None:
        words.append(f"does not twist with friction {contact.twist_needed:.2g} or more")
    return words


def _left_out(profile: ShockProfile, i: int) -> Iterator[str]:
    """The directions in which a contact is not stopped.

    The mechanism moves it there only by what rounding leaves.
    """
    constraints = profile.landing.constraints
    forces, rows = constraints[i].forces, slices_of(constraints)[i]
    for combination in profile.row_space.infeasible:
        axis = combination[rows][: len(forces)] @ forces
        length = float(np.linalg.norm(axis))
        if length > SHARE:
            axis = axis / length * np.sign(axis[np.argmax(np.abs(axis))])
            yield " ".join(f"{x:.3g}" for x in np.where(np.abs(axis) < 1e-3, 0.0, axis))


def _settings(robot: Robot, values: Mapping[str, Interval], units: tuple[str, str]) -> list[str]:
    """Values by pattern of joints, with the unit of the joints that turn or that slide."""
    slides = {joint.name: joint.kind == "prismatic" for joint in robot.single_joints}
    texts = []
    for pattern, value in values.items():
        kinds = sorted({slides.get(name, False) for name in robot.match_joints(pattern)})
        unit = " or ".join(units[kind] for kind in kinds)
        texts.append(f"{printable(pattern)} = {interval_text(value)} {unit}")
    return texts
