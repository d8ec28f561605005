"""Quantities at places, KEY@PLACE, as a text names them."""

from collections.abc import Iterable
from typing import NamedTuple

from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place, moving_point
from shockpc.landing.scenes.scene import Point, Scene
from shockpc.landing.scenes.scene_file import points_at
from shockpc.quantities.quantity import Quantity
from shockpc.quantities.renamed import current_name
from shockpc.quantities.selection import Selection, select, selections
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.text.errors import StudyError, UnknownName
from shockpc.text.printed import listed


class Column(NamedTuple):
    """A column of numbers: a selected quantity at a place.

    Attributes:
        selection: the quantity.
        place: where.
        requested: whether it was asked for by name, so that the summary and the figure show it.
        time: after the impact [ms], on contacts of the scene's stiffness; None for the impulse.
    """

    selection: Selection
    place: Place
    requested: bool = False
    time: float | None = None

    @property
    def name(self) -> str:
        """The heading of the column in the table of rows, KEY@PLACE."""
        after = "" if self.time is None else f" after {self.time:g} ms"
        return f"{self.selection.name}@{self.place.name}{after}"

    @property
    def title(self) -> str:
        """The column's name in texts."""
        component = "" if self.selection.axis is None else "xyz"[self.selection.axis]
        after = "" if self.time is None else f", after {self.time:g} ms"
        return self.selection.quantity.title_at(self.place.name, component) + after

    @property
    def unit(self) -> str:
        """The unit of its numbers, as headings give it."""
        return self.selection.quantity.unit_text

    @property
    def shock(self) -> bool:
        """True if it is a shock of the row's strike."""
        return self.selection.quantity.relations.most_severe is not None and self.time is None

    def per_landing(self, scene: Scene) -> bool:
        """True if it is computed in one posture at a time, for a landing of a scene."""
        return self.time is not None or self.selection.quantity.per_landing(scene)

    def at(self, landing: PosedLanding) -> Place | None:
        """The place in a landing; None if that has fewer contacts, or other parts."""
        kind = self.selection.quantity.of
        if kind == "part":
            parts = [part for part in landing.parts if part.name == self.place.name]
            return parts[0] if parts else None
        number = self.place.number
        if kind != "contact" or number < len(landing.contacts):
            return landing.carried(self.place)
        # Places after those of the contacts are of feet that stand.
        standing = landing.contact_places[number : number + 1]
        return self.place if self.place.name in [place.name for place in standing] else None


def selected(landing: PosedLanding, text: str) -> tuple[Selection, tuple[Place, ...]]:
    """The selection and the places of QUANTITY[@PLACES], by default all of its kind.

    Raises:
        ShockError: as for `select` and `places_at`.
    """
    key, _, pattern = text.partition("@")
    selection = select(key)
    try:
        return selection, places_at(landing, selection.quantity, pattern or None)
    except UnknownName:
        if selection.quantity.vector and pattern[-2:] in (".x", ".y", ".z"):
            wanted = f"{key}{pattern[-2:]}@{pattern[:-2]}"
            raise StudyError(
                f'"{text}": the component of a vector stands before the place; write {wanted}'
            ) from None
        raise


def places_at(
    landing: PosedLanding, quantity: Quantity, pattern: str | None = None
) -> tuple[Place, ...]:
    """The places of a quantity's kind that a name or a glob means; without one, all of them.

    A point is FRAME or FRAME:x,y,z; where a body is needed, a link means the body that it belongs
    to.

    Raises:
        UnknownName: nothing fits; the text names the nearest.
        StudyError: a point is fixed to the world, or the scene lacks what the quantity needs.
    """
    robot = landing.robot
    kind = quantity.of
    places = landing.places(kind)
    lacking = quantity.scope.lacks(landing)
    if lacking:
        raise StudyError(lacking)
    if quantity.scope.parts_of:
        of_joints = quantity.scope.parts_of == "joint"
        places = tuple(place for place in places if (place.joint >= 0) == of_joints)
    if kind == "part" and not places:
        where = {"point": " at a frame", "joint": " of joints"}.get(quantity.scope.parts_of, "")
        raise StudyError(
            f"{quantity.key} is of parts, and the scene has none{where}; describe them by [[part]]"
        )
    if quantity.scope.strikes:
        places = places[: len(landing.contacts)]
    if pattern is None:
        return tuple(place for place in places if place.body >= 0 or kind != "point")
    if kind == "point":
        return tuple(moving_point(robot, point) for point in points_at(robot, pattern))
    if kind == "body":
        return tuple(places[i] for i in robot.match_bodies(pattern))
    named = {place.name: place for place in places}
    return tuple(named[name] for name in robot.match(kind, pattern, named))


def target_text(target: str | Point, scenes: Iterable[Scene]) -> str:
    """The number that a study is about, as a text; of a point the shock.

    It is that with friction if one of the scenes has friction.
    """
    friction = "_friction" if any(scene.friction is not None for scene in scenes) else ""
    if isinstance(target, Point):
        return f"shock{friction}@{target.label}"
    return current_name(target)


def column(profile: ShockProfile, text: str) -> Column:
    """The number of an impact that a text names, KEY@PLACE; of the robot as a whole only KEY.

    Args:
        profile: a landing in which it exists.
        text: the text.

    Raises:
        UnknownName: there is no such quantity, or no such place of its kind.
        StudyError: no place is named, it does not move, or redundant contacts leave the number
            undetermined.
    """
    text = current_name(text)
    entry = selections().get(text.partition("@")[0])
    if entry is not None:
        _refuse_unusable(entry)
    selection, places = selected(profile.landing, text)
    key, kind = selection.name, selection.quantity.of.upper()
    if selection.quantity.scope.shared and profile.redundant:
        raise StudyError(
            f"{key} is not determined, because contacts or loops are redundant; choose another "
            f"quantity"
        )
    if "@" not in text and kind != "ROBOT" and len(places) != 1:
        example = places[0].name if places else kind
        raise StudyError(f"{key} needs a place; write {key}@{kind}, such as {key}@{example}")
    if len(places) > 1:
        raise StudyError(
            f'"{text}" is ambiguous: {listed((place.name for place in places), 6)}; name one'
        )
    return Column(selection, places[0])


def _refuse_unusable(selection: Selection) -> None:
    """Refuse what is not a number of every row of a sweep.

    Raises:
        StudyError: it is either 0 or 1, or computed in one posture at a time.
    """
    quantity = selection.quantity
    if not quantity.decided_by_ground and quantity.computation.on == "scene":
        return
    why = "it is computed in one posture at a time"
    if quantity.relations.role:
        why = "it is either 0 or 1"
    raise StudyError(
        f"{selection.name} ({quantity.title}) cannot be used here: {why}; choose another quantity"
    )


def ground_columns(landing: PosedLanding) -> tuple[Column, ...]:
    """The columns that tell if flat ground allows a landing, or only with a small tilt."""
    (robot,) = landing.places("robot")
    return Column(select("feasible"), robot), Column(select("feasible_if_tilted"), robot)
