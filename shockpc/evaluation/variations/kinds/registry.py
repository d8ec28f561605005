"""All kinds of quantities that vary, by the words that name them."""

from itertools import chain

from shockpc.evaluation.variations.kinds.contacts import CONTACT, GROUND, OFFSETS
from shockpc.evaluation.variations.kinds.joints import ARMATURE, JOINT_STIFFNESS, PLACE, ROTOR
from shockpc.evaluation.variations.kinds.links import LINK_PROPERTIES
from shockpc.evaluation.variations.kinds.posture import ATTITUDES, JOINT_MOTIONS, JOINT_POSITION
from shockpc.evaluation.variations.kinds.strike import STRIKE_KINDS
from shockpc.evaluation.variations.variation import Kind
from shockpc.text.wings import from_wings

_OF_THE_LANDING = (*STRIKE_KINDS, *ATTITUDES, *OFFSETS, *GROUND, CONTACT)
_OF_JOINTS = (ARMATURE, ROTOR, JOINT_STIFFNESS, PLACE, *JOINT_MOTIONS)
_OF_WINGS = chain.from_iterable(from_wings("variations", "KINDS"))

KINDS: dict[str, Kind] = {
    kind.word: kind for kind in chain(_OF_THE_LANDING, LINK_PROPERTIES, _OF_JOINTS, _OF_WINGS)
}
"""Kinds by word; a subject without such a word is a joint's position, `JOINT_POSITION`."""

WORDS = tuple(kind.form for kind in KINDS.values())
"""Names, as they are typed, of what can be varied besides positions of joints."""


def kind_and_target(subject: str) -> tuple[Kind, str]:
    """Kind and target of a subject as it is typed: KIND, KIND:TARGET, or the name of a joint."""
    word, colon, target = subject.partition(":")
    if word == JOINT_POSITION.word and colon:
        return JOINT_POSITION, target
    kind = KINDS.get(word)
    if kind is None or (colon and not kind.of):
        return JOINT_POSITION, subject
    return kind, target
