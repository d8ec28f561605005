"""Kinds of the contacts and of the ground: which contacts strike, where, and numbers of both."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from shockpc.evaluation.variations.variation import Kind, Options, Variation
from shockpc.landing.contact import contacts_like, landing_frames
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.scene import ORIGIN, Contact, Scene
from shockpc.landing.scenes.scene_fields import options_of
from shockpc.robot.robot import Robot
from shockpc.text.errors import StudyError
from shockpc.text.printed import unit_text


@dataclass(frozen=True)
class ContactNames(Kind):
    """The contacts of a landing, by name."""

    names_contacts: bool = True
    option: str = "contact"

    def read(self, robot: Robot, subject: str, target: str, values: Any) -> Variation:
        """The landings whose contacts are named: NAME,NAME, with + between those of one landing."""
        texts: list[Any] = []
        if isinstance(values, str):
            texts = list(values.split(","))
        elif isinstance(values, Iterable):
            texts = list(values)
        if not texts:
            raise StudyError(
                "contact: no contact is named; write contact=NAME,NAME or a glob, such as "
                "contact=*_foot"
            )
        names: list[str] = []
        for text in texts:
            names += ["+".join(frames) for frames in landing_frames(robot, str(text))]
        return Variation(subject, self, "", "", tuple(dict.fromkeys(names)))

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        text = str(value)
        names = [text] if text in robot.frames else text.split("+")
        return replace(scene, contact=contacts_like(scene.contact, names))

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        return [(f"--{self.option}", str(value))]


@dataclass(frozen=True)
class Offset(Kind):
    """A coordinate of all contact points in the frames of their links [m]."""

    unit: str = "m"
    option: str = "offset"

    def prepared(self, scene: Scene) -> Scene:
        """The scene whose contacts are points of frames, unless it says otherwise."""
        contacts = []
        for contact in scene.contact:
            if contact.at == "auto":
                contact = replace(contact, at="frame")
            if contact.kind == "auto":
                contact = replace(contact, kind="point")
            contacts.append(contact)
        return replace(scene, contact=tuple(contacts))

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        contacts = []
        for contact in self.prepared(scene).contact:
            offset = list(contact.offset or ORIGIN)
            offset[self.axis] = float(value)
            x, y, z = offset
            contacts.append(replace(contact, offset=(x, y, z)))
        return replace(scene, contact=tuple(contacts))

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        return [(contact.offset or ORIGIN)[self.axis] for contact in landing.scene.contact]

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        return [(f"--{self.option}", ",".join(map(repr, scene.contact[0].offset or ORIGIN)))]


@dataclass(frozen=True)
class OfGround(Kind):
    """A number of the scene that describes the ground.

    Attributes:
        field: of the record that has it.
    """

    nonnegative: bool = True
    uncertain: bool = True
    of_ground: bool = True
    field: str = ""

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        fields: dict[str, Any] = {self.field: float(value)}
        return replace(scene, **fields)

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        return [getattr(landing.scene, self.field)]

    def options(self, varied: Variation, value: Any, scene: Scene, base: Scene) -> Options:
        return [(f"--{self.option}", repr(float(value)))]


@dataclass(frozen=True)
class OfContacts(OfGround):
    """A number that all contacts have."""

    def scene_with(self, varied: Variation, scene: Scene, robot: Robot, value: Any) -> Scene:
        fields: dict[str, Any] = {self.field: float(value)}
        contacts = tuple(replace(contact, **fields) for contact in scene.contact)
        return replace(scene, contact=contacts)

    def present(self, varied: Variation, landing: PosedLanding) -> Iterable[float | None]:
        return ()


def _of_record(kind: type[OfGround], record: type) -> tuple[OfGround, ...]:
    """The kinds of the options of a record that vary."""
    kinds = []
    for field, option in options_of(record).items():
        if option.varies:
            unit = unit_text(option.unit)
            lasting = option.name.endswith("-stiffness")
            of_field = kind(option.name, unit, field=field, lasting=lasting, option=option.name)
            kinds.append(of_field)
    return tuple(kinds)


CONTACT = ContactNames("contact")

OFFSETS = (Offset("offset-x", axis=0), Offset("offset-y", axis=1), Offset("offset-z", axis=2))

GROUND = (*_of_record(OfGround, Scene), *_of_record(OfContacts, Contact))
