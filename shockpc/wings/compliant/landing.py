"""Scenes and landings of this wing: refused options, and landings that last.

Options that mean nothing are refused.
"""

from typing import TYPE_CHECKING

from shockpc.landing.contact import check_holds_normal
from shockpc.landing.landing import PosedLanding
from shockpc.landing.scenes.scene import Scene
from shockpc.method.constraints import Constraint
from shockpc.text.errors import SceneError
from shockpc.text.printed import printable

if TYPE_CHECKING:
    from shockpc.wings.compliant.over_time.compliant_landing import CompliantLanding


def check_options(scene: Scene, constraints: tuple[Constraint, ...]) -> None:
    """Refuse options of finite stiffness that have no meaning for the scene.

    Args:
        scene: the scene.
        constraints: the constraints of its contacts, in their order.
    """
    stops = scene.stops or any(constraint.kind == "stop" for constraint in constraints)
    if not scene.yields:
        for is_set, message in _idle_on_rigid_contacts(scene):
            if is_set:
                raise SceneError(message)
        return
    if scene.stop_stiffness is not None and not stops:
        raise SceneError(STOPS_NEEDED)
    if scene.friction is not None:
        raise SceneError(
            "friction and a contact stiffness are given; contacts of finite stiffness stick, so "
            "leave one of them out"
        )
    _check_laws(scene)
    for contact, constraint in zip(scene.contact, constraints, strict=True):
        if constraint.kind != "stop":
            check_holds_normal(contact, constraint, "a contact stiffness")
    if stops and scene.stop_stiffness is None:
        raise SceneError(
            "contacts of finite stiffness are given, and rigid end stops; give the stops a "
            "stop_stiffness too"
        )


def check_landing(landing: PosedLanding) -> None:
    """Refuse links that cannot bend. Raises: ShockError: one of the scene's cannot."""
    if landing.scene.flex:
        from shockpc.wings.compliant.links.bent_landing import flexible_landing

        flexible_landing(landing)


def landing_motion(landing: PosedLanding, until: float | None) -> "CompliantLanding | None":
    """The landing over time, until its end or a time [s]; None where its contacts are rigid.

    Raises:
        SolveError: the motion cannot be followed.
    """
    if landing.scene.contact_stiffness is None:
        return None
    from shockpc.wings.compliant.over_time.compliant_landing import (
        CompliantLanding,
        compliant_landing,
    )

    return compliant_landing(landing) if until is None else CompliantLanding(landing, until)


def robot_texts(scene: Scene) -> list[str]:
    """Texts of the robot for a header."""
    return [f"{printable(pattern)} bends ({text})" for pattern, text in scene.flex.items()]


STOPS_NEEDED = (
    "a stiffness of end stops needs stops = true (--stops) and the stiffness of the contacts; give "
    "these too"
)


def _idle_on_rigid_contacts(scene: Scene) -> tuple[tuple[bool, str], ...]:
    """Options without effect on rigid contacts: whether the scene sets each, and the refusal.

    They are in the order in which they are refused.
    """
    without = "is given without the stiffness along the normal; give contact_stiffness too"
    joints = scene.joints
    torque = "torque" if joints.torque else f'motors = "{joints.motors}"'
    # With parts, the stiffness is looked for on which one breaks.
    breakable = bool(scene.part)
    return (
        (scene.stop_stiffness is not None, STOPS_NEEDED),
        (scene.tangential_stiffness is not None, f"a stiffness along the ground {without}"),
        (scene.contact_damping is not None, f"a contact damping {without}"),
        (scene.contact_law is not None, f"a contact law {without}"),
        (
            bool(joints.torque or joints.motors),
            f"{torque} of joints: constant torques have an effect only on contacts of finite "
            f"stiffness; give contact_stiffness too",
        ),
        (
            not scene.gravity and not breakable,
            "gravity = false (--no-gravity) has an effect only on contacts of finite stiffness; "
            "give contact_stiffness too",
        ),
        (
            bool(scene.flex) and not breakable,
            "flex: links that bend have an effect only on contacts of finite stiffness; give "
            "contact_stiffness too, or leave it out",
        ),
    )


def _check_laws(scene: Scene) -> None:
    """Refuse a stiffness along the ground that is not positive, and two laws of the losses."""
    along = scene.tangential_stiffness
    if along is not None and not along > 0.0:
        raise SceneError(f"tangential_stiffness must be > 0 N/m, got {along:g}")
    if scene.contact_damping is None:
        return
    if any(contact.restitution for contact in scene.contact):
        raise SceneError("a contact damping and a restitution cannot be combined; keep one of them")
    if scene.contact_law is not None:
        raise SceneError(
            "a contact damping and a contact law are given; the law takes its damping from the "
            "restitution, so keep one"
        )
