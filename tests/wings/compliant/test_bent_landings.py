"""Landings whose links bend: rotors on their segments, and the face of a sole that carries."""

from dataclasses import replace

import numpy as np
from standing import soles
from test_rotors import refused
from test_soles import ROLLS
from trees import known_robot

from shockpc import Contact, Joints, RobotError, Rotor, Scene, load_robot, resolve
from shockpc.wings.compliant.links.bent_landing import flexible_landing


def test_links_that_bend_carry_rotors():
    """The segment at a joint has its rotor: straight links are rigid ones, and every motion has
    energy.
    """
    go2, flex = known_robot("go2"), {"*": "EI:674"}
    landing = resolve(
        Scene(
            robot="go2",
            contact=Contact(frame="FL_foot", at="frame"),
            contact_stiffness=1e5,
            flex=flex,
        ),
        go2,
    )
    bent = flexible_landing(landing)
    v, H = bent.flexible.v, bent.state.H[0]
    np.testing.assert_allclose(H[np.ix_(v, v)], landing.state.H[0], atol=1e-14 * np.abs(H).max())
    assert np.linalg.eigvalsh(H)[0] > 0.0
    heavy = {"FL_calf_joint": Rotor(inertia=0.1, gear_ratio=6.0, gear="planetary")}
    scene = replace(landing.scene, joints=Joints(rotor=heavy))
    refused(
        RobotError,
        ("FL_thigh", "FL_calf_joint", "--no-carried"),
        lambda: flexible_landing(resolve(scene, go2)),
    )


def test_stiff_links_that_bend_have_the_face_of_rigid_ones(tmp_path):
    """The inertia of a spring against the contact decides: stiff hinges lock, soft ones are free."""
    biped = load_robot(soles(tmp_path, "biped"))
    scene = Scene(
        robot=biped.label, contact="left_foot", joints=Joints(locked=ROLLS), contact_stiffness=1e5
    )
    kinds = []
    for EI in (1e9, 1e-3):
        landing = resolve(replace(scene, flex={"left_shank": f"EI:{EI:g}"}), biped)
        kinds.append(flexible_landing(landing).scene.contact[0].kind)
    assert kinds[0] == "edge"
    assert kinds[1] != kinds[0]
