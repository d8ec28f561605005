"""What constructors accept is what type checkers accept: this file is checked with the package."""

from pathlib import Path

import shockpc


def test_constructors_take_names_paths_and_lists() -> None:
    """A scene holds contacts and texts, whatever it was made from."""
    one = shockpc.Scene(
        robot=Path("robot.urdf"),
        srdf=Path("robot.srdf"),
        contact="foot",
        plane=[0.0, -1.0, 0.0],
        stance=["toe"],
    )
    two = shockpc.Scene(robot="robot.urdf", contact=["foot", shockpc.Contact(frame="toe")])
    contacts: tuple[shockpc.Contact, ...] = (*one.contact, *two.contact)
    assert [contact.frame for contact in contacts] == ["foot", "foot", "toe"]
    assert (one.robot, one.srdf) == ("robot.urdf", "robot.srdf")
