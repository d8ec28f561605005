"""A leg of two tubes with and without rotors, against frame elements.

The tubes are rigid, or those of `--flex`.
"""

import functools
import math
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shockpc import Contact, Joints, Point, Posture, Robot, Scene, load_robot
from shockpc.core.spatial import Array
from shockpc.core.threads import one_thread
from shockpc.landing.landing import PosedLanding
from shockpc.landing.resolve import resolve
from shockpc.wings.compliant.beyond.frame_leg import ANGLES, EA, EI, ROTOR, frame_leg, urdf
from shockpc.wings.compliant.beyond.peaks import landing_peaks
from shockpc.wings.compliant.links.bending import unit_frequency
from shockpc.wings.compliant.links.bent_landing import flexible_landing
from shockpc.wings.compliant.motion.contacts import simulate_landing
from shockpc.wings.compliant.motion.elements import Elements
from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding

ROTORS = {"with": ROTOR, "without": 0.0}
"""Inertia of the rotors behind their gears [kg m²]."""

LINKS = {"rigid": 0, "2 hinges": 2, "12 hinges": 12}
"""Hinges of each tube."""

RATIOS = (0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0)
"""Tc f1: duration of contact with rigid tubes, times the first bending frequency of the free leg.
"""

RIGID, MODES = 5, 20
"""Number of rigid motions of the leg, and of its elastic modes that are followed.

The modes are those of bending and stretching.
"""


class Peaks(NamedTuple):
    """Results of a strike of 1 m/s on an elastic contact, or their errors [1].

    Errors are over what frame elements give.

    Attributes:
        jump: change of the velocity of the trunk until the contact ends [m/s].
        acceleration: its maximum, of the trunk at the hip [m/s²].
        force: maximum of the contact [N].
        torque: maximum at the knee [N m]; NaN without rotors.
    """

    jump: float
    acceleration: float
    force: float
    torque: float


class LegFrequencies(NamedTuple):
    """The first frequency with which the free leg bends in its plane [Hz].

    It is that of frame elements, and on 2 and 12 hinges.
    """

    rotors: str
    frames: float
    two: float
    twelve: float


class LegErrors(NamedTuple):
    """Errors of tubes: rotors, one of `LINKS`, Tc f1, contact stiffness [N/m], and the errors."""

    rotors: str
    links: str
    ratio: float
    stiffness: float
    errors: Peaks


@functools.cache
def leg_frequencies() -> tuple[LegFrequencies, ...]:
    """The first frequencies of the leg, with rotors and without."""
    frequencies = []
    for name, rotor in ROTORS.items():
        exact = float(_frame_modes(rotor)[0][RIGID]) / 2.0 / math.pi
        of_segments = []
        for hinges in filter(None, LINKS.values()):
            elastic = flexible_landing(_posed(rotor, hinges, 1.0)).elastic_frequencies()
            # Segments bend out of the plane too.
            of_segments.append(float(elastic[np.abs(elastic - exact).argmin()]))
        frequencies.append(LegFrequencies(name, exact, *of_segments))
    return tuple(frequencies)


@functools.cache
def leg_study() -> tuple[LegErrors, ...]:
    """The leg on contacts of the stiffness with which Tc f1 is each of `RATIOS`."""
    study = []
    for frequencies, rotor in zip(leg_frequencies(), ROTORS.values(), strict=True):
        unit = unit_frequency(_posed(rotor, 0, 1.0))
        for ratio in RATIOS:
            # Tc f1 = ratio with Tc = π / (unit √k).
            stiffness = (math.pi * frequencies.frames / ratio / unit) ** 2
            expected = np.array(struck_frames(stiffness, rotor))
            for name, hinges in LINKS.items():
                peaks = _peaks(_posed(rotor, hinges, stiffness))
                errors = Peaks(*np.abs(np.array(peaks) / expected - 1.0).tolist())
                study.append(LegErrors(frequencies.rotors, name, ratio, stiffness, errors))
    return tuple(study)


@functools.cache
def _robot() -> Robot:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "leg.urdf")
        file.write_text(urdf(), encoding="utf-8")
        return load_robot(file)


def leg_scene(robot: str, stiffness: float, hinges: int, rotor: float = ROTOR) -> Scene:
    """The leg on an elastic contact, which it strikes straight down at 1 m/s.

    Args:
        robot: the file that it is in.
        stiffness: of the contact, along its normal and the ground [N/m].
        hinges: of each tube; none if it is rigid.
        rotor: inertia of each rotor behind its gear [kg m²].
    """
    thigh, shank = ANGLES
    tube = f"EI:{EI},EA:{EA},hinges:{hinges}"
    return Scene(
        robot=robot,
        base="planar",
        contact=Contact(
            frame="foot", restitution=1.0, restitution_along="directions", directions=("x", "z")
        ),
        contact_stiffness=stiffness,
        gravity=False,
        flex={"thigh": tube, "shank": tube} if hinges else {},
        joints=Joints(armature={"*": rotor}) if rotor else Joints(),
        posture=Posture(joints={"hip": thigh, "knee": shank - thigh}),
        point=(Point(frame="trunk"),),
    )


def _posed(rotor: float, hinges: int, stiffness: float) -> PosedLanding:
    return resolve(leg_scene("leg", stiffness, hinges, rotor), _robot())


def _peaks(posed: PosedLanding) -> Peaks:
    """The results of the leg with tubes of segments, or rigid ones."""
    (trunk,) = posed.places("point")
    # Without rotors nothing bears a torque at the knee.
    knees = [place for place in posed.places("joint") if place.name == "knee"]
    if not posed.joint_model.armature.any():
        knees = []
    peaks = landing_peaks(CompliantLanding(posed), trunk, knees)
    torque = float(peaks.along[0]) if knees else math.nan
    return Peaks(peaks.jump, peaks.acceleration, peaks.force, torque)


@functools.cache
def _frame_modes(rotor: float) -> tuple[Array, Array]:
    """Frequencies of the leg of frame elements, from the lowest [rad/s], and its modes.

    The shapes of the modes have unit modal mass.
    """
    leg = frame_leg(rotor)
    inverse = np.linalg.inv(np.linalg.cholesky(leg.M))
    squares, shapes = np.linalg.eigh(inverse @ leg.K @ inverse.T)
    return np.sqrt(np.maximum(squares, 0.0)), inverse.T @ shapes


def struck_frames(stiffness: float, rotor: float = ROTOR) -> Peaks:
    """The leg of frame elements, in its modes. Args: as of `leg_scene`."""
    leg, (omega, shapes) = frame_leg(rotor), _frame_modes(rotor)
    omega, shapes = omega[: RIGID + MODES], shapes[:, : RIGID + MODES]
    contact = Elements.alike(leg.foot @ shapes, stiffness, 1.0, 0, np.array([False, True]))
    springs = Elements.alike(np.eye(RIGID + MODES)[RIGID:], omega[RIGID:] ** 2)
    elements = Elements.joined(contact, springs)
    with one_thread(RIGID + MODES):
        before = shapes.T @ leg.M @ leg.falling
        motion = simulate_landing(np.eye(RIGID + MODES), elements, before)
        accelerations = shapes @ motion.response
        force = motion.peak(np.eye(2, len(motion.elements.rows))[None])[0]
        trunk = motion.peak(accelerations[None, :2])[0]
        of_rotor = motion.peak((rotor * leg.knee @ accelerations)[None, None])[0]
    jumps = motion.at(np.array([motion.duration])).jump[0]
    jump = float(np.linalg.norm(shapes[:2] @ jumps))
    torque = float(of_rotor[0]) if rotor else math.nan
    return Peaks(jump, float(trunk[0]), float(force[0]), torque)
