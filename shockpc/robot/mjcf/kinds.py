"""Numbers of MuJoCo's enumerations that the reader of MJCF uses."""

FREE, BALL, SLIDE, HINGE = range(4)
"""Kinds of joints, mjtJoint."""

CONNECT, WELD, JOINT, TENDON = range(4)
"""Kinds of equalities, mjtEq."""

WRAPPED_JOINT = 1
"""The object that a fixed tendon wraps, mjtWrap."""

MESH = 7
"""A mesh, mjtGeom; its frame depends on the file of the mesh."""

SITE = 6
"""A site, mjtObj."""

NO_EQUALITY = 2
"""The flag that turns all equalities off, mjtDisableBit."""

ON_JOINT = 1
"""Transmissions up to this number act on a joint, mjtTrn."""
