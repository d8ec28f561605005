"""All kinds of quantities that vary, by the words that name them."""

from shockpc.evaluation.kinds.contacts import CONTACT, GROUND, OFFSETS
from shockpc.evaluation.kinds.joints import ARMATURE, JOINT_STIFFNESS, PLACE, ROTOR
from shockpc.evaluation.kinds.links import LINK_PROPERTIES
from shockpc.evaluation.kinds.posture import ATTITUDES, JOINT_MOTIONS
from shockpc.evaluation.kinds.strike import SPEED, STRIKE_ANGLE
from shockpc.evaluation.variation import Kind
from shockpc.text.wings import from_wings

KINDS: dict[str, Kind] = {
    kind.word: kind
    for kind in (
        *(SPEED, STRIKE_ANGLE, *ATTITUDES, *OFFSETS, *GROUND, CONTACT),
        *LINK_PROPERTIES,
        *(ARMATURE, ROTOR, JOINT_STIFFNESS, PLACE, *JOINT_MOTIONS),
        *(kind for kinds in from_wings("variations", "KINDS") for kind in kinds),
    )
}
"""Kinds by word; a subject without such a word is a joint's position, `JOINT_POSITION`."""

WORDS = tuple(f"{word}:{kind.of}" if kind.of else word for word, kind in KINDS.items())
"""What can be varied besides positions of joints, as it is typed."""
