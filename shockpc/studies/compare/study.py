"""Designs side by side: what changes from the first one to each of the others."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Annotated

from shockpc.evaluation.comparison import Comparison, compared
from shockpc.evaluation.declare import QuantityOption, study
from shockpc.evaluation.designs import Design
from shockpc.evaluation.variations.kinds.registry import KINDS
from shockpc.evaluation.variations.vary import read_changes
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_fields import Option
from shockpc.robot.changes import Change, changed
from shockpc.text.errors import StudyError


def design_with(design: Design, changes: Sequence[Change]) -> Design:
    """A design with its robot changed.

    Raises:
        UnknownName: a pattern matches no link, or no joint.
        StudyError: a changed armature has no effect, because the scene sets that of the same joint.
    """
    for change in changes:
        kind = KINDS[change.what]
        why = kind.overridden(design.robot, change.pattern, design.scene)
        if why:
            raise StudyError(
                f"change {change} has no effect, because the scene {why}; leave one of the two out"
            )
    robot = design.robot
    if design.scene.joints.drives == "none":
        robot = replace(robot, default_drives=None)
    label = "; ".join([design.label, *map(str, changes)])
    return Design(label, design.scene, changed(robot, changes), (*design.changes, *changes))


@study(
    'shockpc compare go2 --contact FL_foot --change "mass:*_calf=0.9x"',
    "shockpc compare anymal_b anymal_c --contact LF_FOOT --out compare/",
    more=(
        "The options of the landing hold for every design. Give one --contact for all designs, or "
        "one for each. With --friction the numbers are with friction."
    ),
    reads="designs",
)
def compare(
    designs: Iterable[Design | Scene | str],
    quantities: QuantityOption = (),
    pairs: Annotated[
        Sequence[tuple[str, str]],
        Option(
            "Partners with different names: a body, joint or point of the first design and of the "
            "others. A * in both stands for the same text. By default names are equal.",
            "Designs",
            "A=B",
            "pair",
        ),
    ] = (),
    *,
    changes: Annotated[
        Sequence[str],
        Option(
            "Another design, as changes of the given design, such as 'mass:*_shank=0.9x; "
            "armature:*=0.01': mass, point-mass (added), inertia (a factor), inertia-xx … -yz "
            "(added), com-x, -y, -z (moved by) of links, armature of joints, place of joints (also "
            "fixed joints) in the frame of the link that carries them, such as "
            "'place:*_KFE=0,0,-0.3' or =1.1x for longer thighs.",
            "Designs",
            "CHANGES",
            "change",
        ),
    ] = (),
) -> Comparison:
    """Compute the landings of some designs, and what differs.

    Args:
        designs: the first is the one that the others are compared with.

    Raises:
        ShockError: there are fewer than two designs, one of them cannot be computed, or lacks a
            place that is named; or a quantity has no value at any place that all of them have.
    """
    side_by_side = list(map(Design.of, designs))
    if changes and len(side_by_side) > 1:
        raise StudyError(
            "--change makes designs from one file, but several files are given; give one file, or "
            "a file for each design"
        )
    of_designs = [read_changes(text) for text in changes]
    side_by_side += [design_with(side_by_side[0], of_design) for of_design in of_designs]
    if len(side_by_side) < 2:
        raise StudyError(
            "a single design cannot be compared; give a second one, or a change with --change"
        )
    return compared(side_by_side, quantities, pairs)
