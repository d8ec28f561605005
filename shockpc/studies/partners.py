"""Which body, joint or point of one design is the partner of which of another: by its name, else by its place in the tree."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from shockpc.landing.places import Kind
from shockpc.quantities.profile import ShockProfile
from shockpc.text.names import matches

KINDS: tuple[Kind, ...] = ("body", "point", "joint", "part")
"""Places that have partners; contacts are partners in their order."""

Partners: TypeAlias = Mapping[Kind, Mapping[str, str]]
"""By kind and by name in the first design: the name in the other."""


def partners(first: ShockProfile, other: ShockProfile, pairs: Sequence[tuple[str, str]] = ()) -> Partners:
    """The partners of two designs, each of one.

    In this order: the given pairs; equal names; the heaviest bodies; the bodies from equally many joints above a contact on; what
    bodies carry that are partners, where the trees beyond are of one shape, such that places differ least; joints that carry
    partners, and the only points on them.

    Args:
        first: one design.
        other: the other design.
        pairs: names of the first with those of the other; of a name with * both have the same in that part.

    """
    by_kind: dict[Kind, dict[str, str]] = {kind: {} for kind in KINDS}
    for pair in pairs:
        for kind, given in matching(first, other, *pair).items():
            _add(by_kind[kind], given.items())
    for kind in KINDS:
        theirs = {place.name for place in other.places(kind)}
        _add(by_kind[kind], ((place.name, place.name) for place in first.places(kind) if place.name in theirs))
    _add(by_kind["body"], [(design.bodies[int(np.argmax(design.robot.masses))] for design in (first, other))])
    for contact, partner in zip(first.scene.contact, other.scene.contact, strict=False):
        limbs = [
            [design.bodies[i] for i in design.robot.limb(design.robot.frame(end.frame).body)]
            for design, end in ((first, contact), (other, partner))
        ]
        if len(limbs[0]) == len(limbs[1]):
            _add(by_kind["body"], zip(*limbs, strict=True))
    if len(by_kind["body"]) < len(first.bodies):
        _add_children(by_kind["body"], first, other)
    for kind in ("joint", "point"):
        for a, b in by_kind["body"].items():
            mine, theirs_ = (
                [place.name for place in design.places(kind) if place.body == design.bodies.index(body) and place.name not in taken]
                for design, body, taken in ((first, a, by_kind[kind].keys()), (other, b, {*by_kind[kind].values()}))
            )
            if len(mine) == len(theirs_) and (kind == "joint" or len(mine) == 1):
                _add(by_kind[kind], zip(mine, theirs_, strict=True))
    return by_kind


def _add(known: dict[str, str], pairs: Iterable[Iterable[str]]) -> None:
    """Add pairs of which neither has a partner yet."""
    for a, b in pairs:
        if a not in known and b not in known.values():
            known[a] = b


def matching(first: ShockProfile, other: ShockProfile, mine: str, theirs: str) -> dict[Kind, dict[str, str]]:
    """The partners that the names of a pair mean, by kind: none where one of the designs has no such names."""
    start, star, end = mine.partition("*")
    fitting: dict[Kind, dict[str, str]] = {kind: {} for kind in KINDS}
    for kind in KINDS:
        names = {place.name for place in other.places(kind)}
        for name in matches(mine, (place.name for place in first.places(kind))):
            partner = theirs.replace("*", name[len(start) : len(name) - len(end)]) if star else theirs
            fitting[kind] |= {name: partner} if partner in names else {}
    return fitting


def _add_children(known: dict[str, str], first: ShockProfile, other: ShockProfile) -> None:
    """Add what partners carry: trees of one shape, as many on either side, such that their places differ least."""
    from scipy.optimize import linear_sum_assignment  # slow to import

    trees = _tree(first), _tree(other)
    for body in first.bodies:  # what carries comes first
        if body not in known:
            continue
        loose = [
            [(shape, child, place) for shape, child, place in tree.get(name, ()) if child not in taken]
            for tree, name, taken in zip(trees, (body, known[body]), (known.keys(), {*known.values()}), strict=True)
        ]
        for shape in dict.fromkeys(shape for shape, _, _ in loose[0]):
            mine, theirs = ([(child, place) for own, child, place in side if own == shape] for side in loose)
            if len(mine) == len(theirs):
                cost = np.array([[np.linalg.norm(p - q) for _, q in theirs] for _, p in mine])
                _add(known, [(mine[i][0], theirs[j][0]) for i, j in zip(*linear_sum_assignment(cost), strict=True)])


def _tree(profile: ShockProfile) -> dict[str, list[tuple[str, str, np.ndarray]]]:
    """What each body carries: the shape of the tree from there on, the body, and its direction and distance as a share."""
    robot, children = profile.robot, dict[str, list[tuple[str, str, np.ndarray]]]()
    shapes = ["" for _ in robot.bodies]
    for i in reversed(range(1, len(shapes))):
        shapes[i] = f"({''.join(sorted(shapes[k] for k in _carried(robot.parents, i)))})"
    for i, body in enumerate(robot.bodies):
        own = [(k, profile.position[k] - profile.position[i]) for k in _carried(robot.parents, i)]
        far = max((float(np.linalg.norm(place)) for _, place in own), default=0.0) or 1.0
        children[body.name] = [(shapes[k], robot.bodies[k].name, place / far) for k, place in own]
    return children


def _carried(parents: Sequence[int], body: int) -> Iterator[int]:
    return (k for k, parent in enumerate(parents) if parent == body)
