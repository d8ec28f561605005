"""The range of a number over the drives: its ends for all inertias that what is known allows.

Of what is linear in the jumps and impulses, or a length of that, both ends follow from the one
solution that is there, by the law of `core.drive_box`: the largest value over drives that are
independent of one another is at a corner of their intervals, which a climb finds; the smallest is
sought. Effective masses and the energy lost only grow with inertia, so their ends are those of the
smallest and of the largest inertias. Numbers of another kind are computed anew at some corners, and
so are all where end stops act, friction, or a landing lasts, and where another face of a sole
carries: the range is then one of samples.
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.memo import memoized
from shockpc.core.spatial import Array, in_body_axes, read_only
from shockpc.impact.drive_response import drive_response, extreme_changes, with_inertias
from shockpc.impact.impact import DoubleImpact
from shockpc.impact.landed import proven, solved
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place, joint_places
from shockpc.landing.scenes.scene import Contact
from shockpc.method.exact.arithmetic import SingularError
from shockpc.quantities.quantity import Quantity, quantity_values
from shockpc.quantities.selection import Selection, quantity, select
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.errors import SceneError, SolveError
from shockpc.text.printed import few, printable

Kind = Literal["corners", "exact", "samples"]

NEARLY = 0.05
"""Share of the way to an end of a range that is left to joints which do not decide.

An end that is nearer than this share of the range is no end that joints decide."""

GROWING = {
    ("contact", "effective_mass"),
    ("contact", "effective_mass_sticking"),
    ("contact", "effective_mass_frictionless"),
    ("contact", "mitigation_frictionless"),
    ("robot", "energy_lost"),
}
"""Quantities that only grow, or only fall, with every inertia.

They follow from bᵀΛb: H grows, J H⁻¹ Jᵀ falls and Λ grows."""

LENGTHS = {
    ("joint", "joint_impulse"): "force",
    ("joint", "joint_moment"): "moment",
    ("joint", "joint_torque_share"): "along",
    ("point", "filtered_peak"): "delta_v",
    ("point", "filtered_peak_axes"): "delta_v",
}
"""Quantities that are the length of another one at the same place, but for a factor."""

LINEAR = {
    ("joint", "force"),
    ("joint", "moment"),
    ("joint", "along"),
    ("contact", "moment"),
    ("robot", "total_impulse"),
    ("robot", "total_moment"),
}
"""Quantities that are linear in the jumps and impulses of one posture, besides those of all."""


OF_JUMPS = {("point", "range_share")}
"""Other quantities that follow from the jumps alone, where contacts stick and are rigid."""


class Range(NamedTuple):
    """The smallest and the largest value of a number over the drives.

    Attributes:
        smallest: in the unit of the number.
        largest: likewise.
        kind: "corners": the largest is at a corner of the intervals, as far as a climb found it,
            and the smallest is sought; of a component, both are at corners. "exact": both are those
            of the smallest and of the largest inertias. "samples": those of some corners.
    """

    smallest: float
    largest: float
    kind: Kind

    def meets(self, least: float | None, most: float | None) -> bool | None:
        """True or False if limits are met, or missed, whatever the drives; else None.

        Args:
            least: smallest value allowed; None for any.
            most: largest value allowed; None for any.
        """
        low = -np.inf if least is None else least
        high = np.inf if most is None else most
        if low <= self.smallest and self.largest <= high:
            return True
        if self.smallest > high or self.largest < low:
            return False
        return None


DRIVES_REMEDY = (
    "give narrower intervals with --drives, --rotor or --armature (in files joints.drives, "
    "joints.rotor and joints.armature), or state that there are none: "
    'joints.model = "free" (--joints free)'
)
"""What to do where drives decide, whichever they are."""


def deciding_text(joints: Sequence[str]) -> str:
    """Words on the joints, as of `deciding_joints`, whose drives decide."""
    return f"the drives of {few([printable(name) for name in joints], 4)} decide"


def drives_advice(joints: Sequence[str]) -> str:
    """Advice where the drives of some joints, as of `deciding_joints`, decide."""
    return f"{deciding_text(joints)}: {DRIVES_REMEDY}"


def has_range(landing: PosedLanding) -> bool:
    """True if some drive of a landing is not known exactly."""
    model = landing.joint_model
    return bool(np.any(model.low < model.high))


def range_of(profile: ShockProfile, selection: Selection, place: Place) -> Range | None:
    """The range of a number of a profile over the drives.

    Args:
        profile: the landing; its own value is in the range.
        selection: the number.
        place: where.

    Returns: None where every drive is known exactly, where the number has no value, or where no
        drive reaches it: at a point that is fixed to the world, of another joint model, or of how
        far the numbers are proven.
    """
    return ranges_of(profile, selection, [place])[0]


def ranges_of(
    profile: ShockProfile, selection: Selection, places: Sequence[Place]
) -> list[Range | None]:
    """The ranges of a number of a profile at several places over the drives, each as `range_of`."""
    landing, wanted = profile.landing, selection.quantity
    ranges: list[Range | None] = [None] * len(places)
    if wanted.computation.on != "scene" or not has_range(landing):
        return ranges
    values = profile.numbers(selection, places)
    reached = []
    for k, place in enumerate(places):
        held = wanted.of == "point" and place.body < 0
        if not held and not np.isnan(values[k]):
            reached.append(k)
    searched = _searched(landing, selection, [places[k] for k in reached])
    for k, (kind, ends) in zip(reached, searched, strict=True):
        if ends:
            every = [float(values[k]), *(value for _, value in ends)]
            ranges[k] = Range(min(every), max(every), kind)
    return ranges


def deciding_joints(profile: ShockProfile, selection: Selection, place: Place) -> tuple[str, ...]:
    """Names of the joints whose drives account for nearly all of the range of a number.

    Those with the largest effect come first. At each end of the range the joints are ordered by
    what the number loses when one of them is as modelled again. Those decide with which, one after
    the other, the number comes within `NEARLY` of the way to the end. Where the number does not
    follow from the response of the landing, they are those of an impulse or a jump at its place.
    """
    landing = profile.landing
    if not has_range(landing):
        return ()
    ((kind, ends),) = _searched(landing, selection, [place])
    linear = _linear(landing, selection, place)
    if linear is None or selection.quantity.of_ground(landing.scene):
        selection, place = _jump_beside(landing, selection, place)
    response = drive_response(landing)
    Y, B = _vectors(landing, selection, place)
    if kind == "corners":
        changes = [change for change, _ in ends]
    else:
        changes = _end_changes(landing, selection, place)

    # |Y + B λ| at each end, and how far that is from |Y|.
    drives = [change[response.columns] for change in changes]
    here = np.linalg.norm(Y)
    ways = []
    for end in drives:
        length = np.linalg.norm(Y + B @ response.box.impulses(end))
        ways.append(abs(float(length - here)))
    columns: list[int] = []
    for end, way in zip(drives, ways, strict=True):
        if way > NEARLY * max(ways):
            columns += response.box.deciding(Y, B, end, NEARLY)
    names = dict[int, str]()
    for joint in landing.robot.single_joints:
        names |= dict.fromkeys(range(joint.v.start, joint.v.stop), joint.name)
    return tuple(dict.fromkeys(names[int(response.columns[i])] for i in columns))


def _jump_beside(
    landing: PosedLanding, selection: Selection, place: Place
) -> tuple[Selection, Place]:
    """An impulse of the ground, or a jump, at the place of a number: it is linear in the drives.

    That of a place without a body is the jump of the heaviest one.
    """
    if selection.quantity.of == "contact":
        return select("contact.impulse"), place
    heaviest = landing.places("body")[int(np.argmax(landing.robot.masses))]
    return select("point.delta_v"), place if place.body >= 0 else heaviest


class _Ends(NamedTuple):
    """Among what the ends of the range of a number are.

    Attributes:
        kind: how they are found.
        ends: changes (nv,) from the inertias as modelled, with the numbers there, where they exist.
    """

    kind: Kind
    ends: list[tuple[Array, float]]


def _searched(landing: PosedLanding, selection: Selection, places: Sequence[Place]) -> list[_Ends]:
    """Values among which the ends of a number's ranges are; a landing keeps them for reuse."""
    kept = _kept(landing)
    new = [place for place in places if _key(selection, place) not in kept]
    groups = [[place] for place in new]
    if new and _is_motion(landing, selection):
        groups = [new]
    for group in groups:
        for place, ends in zip(group, _search(landing, selection, group), strict=True):
            kept[_key(selection, place)] = ends
    return [kept[_key(selection, place)] for place in places]


def _key(selection: Selection, place: Place) -> tuple[object, ...]:
    """Key of a number at a place among those of a landing."""
    return selection.name, place.name, place.body, place.number, place.joint, place.r.tobytes()


@memoized()
def _kept(landing: PosedLanding) -> dict[tuple[object, ...], _Ends]:
    """The ranges that a landing keeps, by number and place."""
    del landing
    return {}


@memoized()
def _kept_ends(landing: PosedLanding) -> dict[tuple[object, ...], list[Array]]:
    """The changes of the inertias at such ends that a landing keeps, by number and place."""
    del landing
    return {}


class _Linear(NamedTuple):
    """A quantity linear in jumps and impulses, from which a number follows.

    Attributes:
        quantity: the linear one.
        place: where.
        axis: of the component that the number grows with; None for the length.
        signed: whether the number is that component with its sign, else the magnitude.
    """

    quantity: Quantity
    place: Place
    axis: int | None = None
    signed: bool = False


def _search(landing: PosedLanding, selection: Selection, places: Sequence[Place]) -> list[_Ends]:
    """Values among which the ends of a number's ranges at places are.

    Of motions there are several places, else one.
    """
    kind = _kind(landing, selection, places[0])
    follows = kind == "corners" or _follows(landing, selection)
    changes: list[Array] = []
    if kind != "corners":
        changes = _possible_extremes(landing) if follows else extreme_changes(landing)
    # A landing that lasts takes long, so it is computed of few.
    if kind != "exact" and not _is_motion(landing, selection):
        changes += _end_changes(landing, selection, places[0])
    if (follows or kind == "exact") and _other_faces(landing, changes):
        kind = "samples"
        follows = False
        changes = changes + extreme_changes(landing)
    if follows:
        values = _followed(landing, selection, places, changes)
    else:
        ends = (with_inertias(landing, change) for change in changes)
        values = [_values_of(end, selection, places) for end in ends]
    every = []
    for k in range(len(places)):
        known = []
        for change, value in zip(changes, values, strict=True):
            if not np.isnan(value[k]):
                known.append((change, float(value[k])))
        every.append(_Ends(kind, known))
    return every


def _possible_extremes(landing: PosedLanding) -> list[Array]:
    """Changes (nv,) of the inertias to the smallest and to the largest that the contacts allow."""
    response = drive_response(landing)
    changes = np.zeros((2, len(landing.joint_model.armature)))
    changes[:, response.columns] = response.box.least, response.box.most
    return list(changes)


def _is_motion(landing: PosedLanding, selection: Selection) -> bool:
    """True if a number is of a landing that lasts."""
    scene = landing.scene
    return selection.quantity.of_ground(scene) and scene.yields


def _follows(landing: PosedLanding, selection: Selection) -> bool:
    """True if a number of samples follows from the jumps of Eq. 4, linear in the drives."""
    scene, wanted = landing.scene, selection.quantity
    bonded = scene.friction is None and not scene.yields and not scene.stops
    return bonded and (wanted.of, wanted.key) in OF_JUMPS


def _followed(
    landing: PosedLanding, selection: Selection, places: Sequence[Place], changes: list[Array]
) -> list[Array]:
    """A number at places (n,), for each change (nv,), from the response of the landing."""
    if not changes:
        return []
    impacts = drive_response(landing).at(landing, changes)
    return list(selection.scalar(quantity_values(selection.quantity, impacts, places))[0])


def _kind(landing: PosedLanding, selection: Selection, place: Place) -> Kind:
    """Kind of the ends of a range, if no other face of a sole carries there."""
    wanted = selection.quantity
    if landing.scene.stops or wanted.of_ground(landing.scene):
        return "samples"
    if (wanted.of, wanted.key) in GROWING:
        return "exact"
    return "samples" if _linear(landing, selection, place) is None else "corners"


def _linear(landing: PosedLanding, selection: Selection, place: Place) -> _Linear | None:
    """The linear quantity from which a number follows; None where it is of another kind."""
    wanted = selection.quantity
    key = wanted.of, wanted.key
    component = selection.axis is not None
    if wanted.of == "part" and place.joint < 0:
        return _Linear(quantity("point", "delta_v"), place, selection.axis, component)
    if wanted.of == "part":
        joint = next(at for at in joint_places(landing.robot) if at.number == place.joint)
        return _Linear(quantity("joint", "along"), joint, signed=wanted.key == "along")
    if key == ("joint", "rate_after"):
        return _Linear(quantity("joint", "delta_qd"), place, signed=True)
    if wanted.relations.linear or key in LINEAR:
        return _Linear(wanted, place, selection.axis, component or not wanted.vector)
    if key in LENGTHS:
        return _Linear(quantity(wanted.of, LENGTHS[key]), place, selection.axis)
    if wanted.relations.length_of is not None:
        return _Linear(wanted.relations.length_of, place)
    return None


def _end_changes(landing: PosedLanding, selection: Selection, place: Place) -> list[Array]:
    """Changes (nv,) of the inertias at which a number is smallest and largest, as far as found.

    Of a number that is no length or component of what is linear, they are those of the jump at its
    place, or of the heaviest body.
    """
    if _linear(landing, selection, place) is None:
        selection, place = _jump_beside(landing, selection, place)
    kept, key = _kept_ends(landing), _key(selection, place)
    if key not in kept:
        kept[key] = _sought(landing, selection, place)
    return list(kept[key])


def _sought(landing: PosedLanding, selection: Selection, place: Place) -> list[Array]:
    """Changes (nv,) as `_end_changes`, of a length or a component of what is linear."""
    Y, B = _vectors(landing, selection, place)
    if not (np.isfinite(Y).all() and np.isfinite(B).all()):
        return []
    response = drive_response(landing)
    linear = _linear(landing, selection, place)
    if linear is not None and linear.signed:
        ends = response.box.values(Y, B)
    else:
        ends = response.box.lengths(Y, B)
    changes = np.zeros((2, len(landing.joint_model.armature)))
    changes[:, response.columns] = ends
    return [read_only(change) for change in changes]


def _vectors(landing: PosedLanding, selection: Selection, place: Place) -> tuple[Array, Array]:
    """Vector (m,) from which a number follows, and its response (m, n) to the drives."""
    response = drive_response(landing)
    linear = _linear(landing, selection, place)
    if linear is None:
        jump, beside = _jump_beside(landing, selection, place)
        linear = _Linear(jump.quantity, beside)
    every = response.combined(landing, np.eye(1 + len(response.columns)))
    vectors = quantity_values(linear.quantity, every, [linear.place])[0, :, 0]
    vectors = vectors.reshape(len(vectors), -1)
    if linear.axis is not None:
        vectors = vectors[:, linear.axis, None]
    return vectors[0], vectors[1:].T


def _other_faces(landing: PosedLanding, changes: list[Array]) -> bool:
    """True if other faces of the soles carry with other inertias, by changes (nv,)."""
    asked = zip(landing.asked, landing.scene.contact, strict=False)
    if not landing.lifted and not any(_has_faces(*contacts) for contacts in asked):
        return False
    ends = (with_inertias(landing, change) for change in changes)
    return any(end is not None and _faces(end) != _faces(landing) for end in ends)


def _has_faces(asked: Contact, contact: Contact) -> bool:
    """True if a contact is of a sole, or is a given point of one. Args: as asked for; as it is."""
    return contact.kind != "point" or (asked.kind == "auto" and asked.at == "frame")


def _faces(landing: PosedLanding) -> tuple[object, ...]:
    """The faces of the soles that carry: the contacts as they strike, and the lifted feet."""
    return *landing.scene.contact, *landing.lifted


def _values_of(
    landing: PosedLanding | None, selection: Selection, places: Sequence[Place]
) -> Array:
    """A number at places (n,), in doubles, or with a proof where doubles do not have it; or NaN."""
    wanted = selection.quantity
    values = np.full(len(places), np.nan)
    if landing is None:
        return values
    known, there = [], []
    for k, place in enumerate(places):
        place_there = _place_in(landing, selection, place)
        if place_there is not None:
            known.append(k)
            there.append(place_there)
    if not there:
        return values
    try:
        equation, solution, jumps = solved(landing)
        in_body = in_body_axes(jumps, equation.state.rotation)
        impact = DoubleImpact(landing, equation, solution, in_body)
        numbers = selection.scalar(quantity_values(wanted, impact, there))[0, 0]
        if np.isnan(numbers).any() and wanted.computation.postures != "many":
            exact = proven(landing).read(wanted.compute, there, size=wanted.size)
            numbers = selection.scalar(exact)[0, 0]
        values[known] = numbers
    except (SceneError, SolveError, SingularError):
        pass
    return values


def _place_in(landing: PosedLanding, selection: Selection, place: Place) -> Place | None:
    """A place in a landing with other inertias, where some of the contacts may be lifted."""
    if selection.quantity.of != "contact":
        return place
    return next((at for at in landing.contact_places if at.name == place.name), None)
