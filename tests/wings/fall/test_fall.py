"""`shockpc fall`: the motion obeys closed forms, MuJoCo agrees, and every strike is a landing like
any other.
"""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from commands import good, run, says

from shockpc import (
    Contact,
    Joints,
    Part,
    Point,
    Scene,
    SolveError,
    Strike,
    StudyError,
    fall,
    load_robot,
    shock_profile,
)
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.selection import select
from shockpc.wings.fall.body import Rigid
from shockpc.wings.fall.cross_section import CrossSection, SectionMotion
from shockpc.wings.fall.planar_fall import follow_fall
from shockpc.wings.fall.report import fall_report

PARTS = (
    # name, carrier, place of the joint, centre and sides of the box about the joint, mass
    ("torso", "", (0.0, 0.0, 0.0), (0.0, 0.0, 0.2), (0.15, 0.3, 0.5), 20.0),
    ("left_leg", "torso", (0.0, 0.1, -0.05), (0.01, 0.0, -0.35), (0.1, 0.1, 0.7), 5.0),
    ("right_leg", "torso", (0.0, -0.1, -0.05), (0.01, 0.0, -0.35), (0.1, 0.1, 0.7), 5.0),
    ("left_arm", "torso", (0.0, 0.2, 0.4), (0.2, 0.0, 0.0), (0.4, 0.06, 0.06), 2.0),
    ("right_arm", "torso", (0.0, -0.2, 0.4), (0.2, 0.0, 0.0), (0.4, 0.06, 0.06), 2.0),
)
"""A figure of boxes, the mirror image of itself."""


def text(*numbers: float) -> str:
    return " ".join(map(repr, numbers))


def moments(mass: float, sides: tuple[float, float, float]) -> list[float]:
    x, y, z = (side * side for side in sides)
    return [mass * pair / 12.0 for pair in (y + z, x + z, x + y)]


def urdf(parts: tuple = PARTS, shapes: str = "collision") -> str:
    texts = []
    for name, carrier, place, centre, sides, mass in parts:
        x, y, z = moments(mass, sides)
        inertia = f'<inertia ixx="{x!r}" iyy="{y!r}" izz="{z!r}" ixy="0" ixz="0" iyz="0"/>'
        origin = f'<origin xyz="{text(*centre)}"/>'
        box = (
            f'<{shapes}>{origin}<geometry><box size="{text(*sides)}"/></geometry></{shapes}>'
            if shapes
            else ""
        )
        texts.append(
            f'<link name="{name}"><inertial>{origin}<mass '
            f'value="{mass}"/>{inertia}</inertial>{box}</link>'
        )
        if carrier:
            ends = (
                f'<parent link="{carrier}"/><child link="{name}"/><origin '
                f'xyz="{text(*place)}"/><axis xyz="0 1 0"/>'
            )
            texts.append(
                f'<joint name="{name}_joint" type="revolute">{ends}<limit lower="-1" upper="1" '
                f'effort="9" velocity="9"/></joint>'
            )
    return f'<robot name="figure">{"".join(texts)}</robot>'


def mjcf() -> str:
    bodies: dict[str, str] = {}
    for name, carrier, place, centre, sides, mass in reversed(PARTS):
        inertial = (
            f'<inertial pos="{text(*centre)}" mass="{mass}" '
            f'diaginertia="{text(*moments(mass, sides))}"/>'
        )
        geom = (
            f'<geom type="box" pos="{text(*centre)}" '
            f'size="{text(*(side / 2.0 for side in sides))}"/>'
        )
        joint = (
            f'<joint name="{name}_joint" axis="0 1 0" range="-1 1" limited="true"/>'
            if carrier
            else "<freejoint/>"
        )
        inside = bodies.pop(name, "")
        body = f'<body name="{name}" pos="{text(*place)}">{joint}{inertial}{geom}{inside}</body>'
        bodies[carrier] = body + bodies.get(carrier, "")
    return (
        f'<mujoco model="figure"><compiler '
        f'angle="radian"/><worldbody>{bodies[""]}</worldbody></mujoco>'
    )


@pytest.fixture(scope="module")
def figure(tmp_path_factory):
    """The scene of the figure."""
    file = tmp_path_factory.mktemp("figure") / "figure.urdf"
    file.write_text(urdf())
    return Scene(robot=str(file))


@pytest.fixture(scope="module")
def falls(figure):
    return fall(figure)


def box(width: float, height: float, mass: float = 1.0) -> CrossSection:
    points = np.array(
        [[x, z] for x in (-width / 2.0, width / 2.0) for z in (-height / 2.0, height / 2.0)]
    )
    return CrossSection.of(mass, mass * (width**2 + height**2) / 12.0, points)


def tipped(
    section: CrossSection,
    friction: float | None = None,
    hinged: float | None = None,
    nudge: float = 1e-6,
):
    """A fall from the balance."""
    corner, theta = section.balance(section.lowest(0.0))
    length, _, kappa = section.arm(corner)
    start = section.pivoting(
        corner, theta + nudge, math.sqrt(2.0 * kappa * GRAVITY / length * (1.0 - math.cos(nudge)))
    )
    return follow_fall(section, corner, start, friction, hinged)


def test_tip_of_a_rod():
    """The tip of a uniform rod on a hinge strikes at √(3 g L)."""
    (impact,) = tipped(box(1e-9, 0.7), hinged=0.0).impacts
    assert impact.speed == pytest.approx(math.sqrt(3.0 * GRAVITY * 0.7), rel=1e-8)


def test_box_on_a_hinge_and_sliding():
    """ω² = 2 m g Δh / I on a hinge; with a friction of 0.5 the edge slips and the box strikes more
    slowly.
    """
    w, h = 0.1, 1.0
    (hinge,) = tipped(box(w, h), hinged=0.0).impacts
    closed = math.sqrt(2.0 * GRAVITY * (math.hypot(w, h) / 2.0 - w / 2.0) / ((w * w + h * h) / 3.0))
    assert hinge.before.omega == pytest.approx(closed, rel=1e-9)
    assert hinge.before.omega == pytest.approx(5.134, abs=1e-3)
    found = tipped(box(w, h), 0.5)
    assert [phase.kind for phase in found.phases][:2] == ["pivots", "slides"]
    assert found.impacts[0].before.omega == pytest.approx(4.884, abs=1e-3)


def test_slip_begins_where_the_closed_form_says():
    """From rest at the balance T / N = 3κ sin φ (cos φ − 2/3) / (1 − κ (1 + 2 cos φ − 3 cos² φ))
    reaches µ.
    """
    section = box(0.1, 1.0)
    _, angle, kappa = section.arm(
        section.lowest(0.0)
        if section.balance(section.lowest(0.0))[0] == 0
        else section.balance(section.lowest(0.0))[0]
    )
    phi = tipped(section, 0.3).phases[0].end.theta + angle
    c, s = math.cos(phi), math.sin(phi)
    along, up = kappa * s * (3.0 * c - 2.0), 1.0 - kappa * (1.0 + 2.0 * c - 3.0 * c * c)
    assert abs(along) / up == pytest.approx(0.3, rel=1e-5)


@pytest.mark.parametrize(("kappa", "pulled"), [(0.749, False), (0.751, True)])
def test_edge_would_be_pulled_from_three_quarters_on(kappa, pulled):
    """N / (m g) = 1 − κ (1 + 2 cos φ − 3 cos² φ) has its smallest value 1 − 4κ/3 at cos φ = 1/3."""
    section = CrossSection.of(
        1.0, 0.25 * (1.0 / kappa - 1.0), np.array([[-1e-7, -0.5], [1e-7, -0.5], [0.0, 0.5]])
    )
    assert (
        len(tipped(section).phases) > 1 and tipped(section).phases[1].kind != "pivots"
    ) == pulled
    phi = math.acos(1.0 / 3.0)
    start = SectionMotion(0.0, 0.0, 0.5, 0.0, 0.0, 0.0)
    corner = section.balance(section.lowest(0.0))[0]
    angle = section.arm(corner)[1]
    _, up = section.forces(corner, phi - angle, section.squared_rate(corner, phi - angle, start))
    assert float(up) == pytest.approx(GRAVITY * (1.0 - 4.0 * kappa / 3.0), rel=1e-5)


def test_rolling_polygon_loses_energy_at_each_change():
    """A rimless wheel keeps (I + m r² cos 2π/n) / (I + m r²) of its rate at each spoke."""
    n, r, m, inertia = 8, 0.4, 3.0, 0.2
    angle = 2.0 * math.pi * (np.arange(n) + 0.5) / n - math.pi / 2.0
    wheel = CrossSection.of(m, inertia, r * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    corner = wheel.lowest(1e-9)
    found = follow_fall(wheel, corner, wheel.pivoting(corner, 0.0, 3.0))
    kept = (inertia + m * r * r * math.cos(2.0 * math.pi / n)) / (inertia + m * r * r)
    forward = [
        impact
        for impact in found.impacts
        if impact.before.omega > 0.0 and impact.corner > impact.on
    ]
    assert len(forward) > 2
    assert [impact.after.omega / impact.before.omega for impact in forward] == pytest.approx(
        [kept] * len(forward), rel=1e-9
    )
    assert found.rests


def test_energy_is_never_gained():
    """Random polygons with any friction: energy is kept while pivoting and in the air, and else
    lost; nothing sinks; all rest.
    """
    rng, kinds = np.random.default_rng(7), set()
    for k in range(40):
        points = rng.normal(size=(12, 2)) * [1.0, 2.0]
        section = CrossSection.of(2.0, 2.0 * rng.uniform(0.2, 1.5), points - points.mean(axis=0))
        corner = section.lowest(0.0)
        start = section.pivoting(corner, 0.0, rng.uniform(1.0, 6.0))
        found = follow_fall(section, corner, start, (None, 0.2, 0.5, 1.0)[k % 4])
        scale = section.energy(start)
        for phase in found.phases:
            kinds.add(phase.kind)
            change = section.energy(phase.end) - section.energy(phase.start)
            assert change <= 1e-7 * scale
            assert phase.kind == "slides" or change >= -1e-7 * scale
            lowest = section.at(section.lowest(phase.end.theta), phase.end.theta)[1]
            assert phase.end.z + lowest >= -1e-7
        for impact in found.impacts:
            assert section.energy(impact.after) <= section.energy(impact.before) + 1e-9 * scale
            assert impact.speed >= -1e-9
    assert kinds == {"pivots", "slides", "is in the air"}


def test_least_push():
    """A push just above the smallest one tips a box, with the energy that is missing to its
    balance; one below does not.
    """
    section = box(0.4, 1.0)
    corner = section.balance(section.lowest(0.0))[0]
    rate = section.least_rate(corner, 0.0)
    up = math.hypot(0.2, 0.5) - 0.5
    assert 0.5 * (section.inertia + math.hypot(0.2, 0.5) ** 2) * rate**2 == pytest.approx(
        GRAVITY * up, rel=1e-12
    )
    assert follow_fall(section, corner, section.pivoting(corner, 0.0, 1.001 * rate)).phases[
        0
    ].end.theta == pytest.approx(math.pi / 2.0)
    assert (
        follow_fall(section, corner, section.pivoting(corner, 0.0, 0.999 * rate))
        .phases[0]
        .end.omega
        == 0.0
    )


def test_figure_falls_over_its_feet(falls):
    """It balances where its centre of mass is over the edge, and strikes with its hands first in
    front, at the speed of a hinge.
    """
    rigid = Rigid.of(falls.results[0].profile.scene, falls.robot)
    assert falls.failures == ()
    tips = {tip.name: tip for tip in falls.tips}
    com = sum(mass * np.add(place, centre) for _, _, place, centre, _, mass in PARTS) / rigid.mass
    x, z = 0.06 - com[0], com[2] + 0.75
    assert tips["front"].balance == pytest.approx(math.atan2(x, z), rel=1e-9)
    first = {one.strike.fall: one.strike for one in falls.results if one.strike.number == 1}
    assert set(first["front"].struck) == {"left_arm", "right_arm"}
    assert first["front"].remark == ""
    across = rigid.mass * (x * x + z * z) + tips["front"].section.inertia
    reach = (
        2.0
        * GRAVITY
        * rigid.mass
        * (math.hypot(x, z) - (z * math.cos(a := first["front"].rotation) - 0.0 + x * math.sin(a)))
    )
    assert tips["front"].hinged == pytest.approx(math.sqrt(reach / across), rel=1e-3)


def test_left_and_right_are_mirror_images(falls):
    by_name = {one.strike.name: one for one in falls.results}
    sides = [name for name in by_name if name.startswith("left")]
    assert sides
    for name in sides:
        one, other = by_name[name], by_name[name.replace("left", "right")]
        assert one.strike.speed == pytest.approx(other.strike.speed, rel=1e-9)
        assert {link.replace("left", "right") for link in one.strike.struck} == {
            link.replace("left", "right") for link in other.strike.struck
        }
        assert one.values["delta_v_max"] == pytest.approx(other.values["delta_v_max"], rel=1e-6)
        # one arm strikes, in front of the legs
        assert ("out of the plane" in one.strike.remark) == (one.strike.number == 1)
        assert one.trunk == pytest.approx(other.trunk, rel=1e-6, nan_ok=True)


def test_every_strike_is_a_landing(falls):
    """Its contacts move at the speeds that are stated, none is pulled, and its numbers are those of
    the analysis.
    """
    assert len(falls.table) == len(falls.results) > 6
    for one in falls.results:
        profile = shock_profile(one.strike.scene)
        striking = profile.contacts[: len(one.strike.pressing)]
        # slides
        assert all(contact.approach[2] == 0.0 for contact in profile.contacts[len(striking) :])
        down = {contact.frame: -contact.approach[2] for contact in striking}
        assert down == pytest.approx(
            {link: one.strike.struck[link] for link in one.strike.pressing}, rel=1e-9
        )
        impulses = [
            contact.impulse[2]
            for contact in (*profile.contacts, *profile.stance)
            if contact.impulse is not None
        ]
        assert min(impulses, default=0.0) >= -1e-5 * max(impulses, default=0.0)
        assert min(contact.point[2] for contact in profile.contacts) == pytest.approx(0.0, abs=1e-3)
        worst = np.nanmax(profile.numbers(*select_all(profile, "delta_v_max")))
        assert one.values["delta_v_max"] == pytest.approx(worst, rel=1e-12)
        # from zero to ± 1 rad
        rates = {
            joint.name: float(profile.delta_qd[joint.v.start]) for joint in profile.robot.joints[1:]
        }
        assert abs(rates[one.stop[0]]) == pytest.approx(max(map(abs, rates.values())))
        assert one.stop[1] == pytest.approx(1.0 / max(map(abs, rates.values())))
    order = [one.values["delta_v_max"] for one in falls.results]
    assert order == sorted(order, reverse=True)


def test_readings_of_a_fall_are_bounds_without_a_stiffness_and_the_report_says_so(figure):
    """2πf Δv of first order at the sensor."""
    found = fall(
        replace(figure, point=(Point(frame="torso"),), imu_bandwidth="50Hz"), headings=("front",)
    )
    for one in found.results:
        jump = float(np.linalg.norm(one.profile.value("delta_v", "point")[0]))
        assert one.values["filtered_peak"] == pytest.approx(
            100.0 * math.pi * jump / GRAVITY, rel=1e-9
        )
    assert any(
        "filtered_peak: at most" in note
        for sheet in fall_report(found).body(False)
        for note in getattr(sheet, "notes", ())
    )


def select_all(profile, key):
    from shockpc import select

    selection = select(key)
    return selection, profile.places(selection.quantity.of)


@pytest.mark.parametrize("friction", [None, 0.3])
def test_strikes_of_a_rigid_robot_are_those_of_its_fall(figure, friction):
    """With locked joints the jump of the rotation is that of the body in the plane, on edges that
    stand or slide too.
    """
    found = fall(
        replace(figure, friction=friction, joints=Joints(model="locked")),
        headings=("front", "back"),
    )
    assert found.failures == ()
    corners = {
        (impact.before.theta, impact.before.omega): impact
        for tip in found.tips
        for impact in tip.fall.impacts
        if impact.speed >= 0.1
    }
    left = {tip.name: np.cross([0.0, 0.0, 1.0], tip.forward) for tip in found.tips}
    assert {"pivots", "slides"} <= {one.strike.motion for one in found.results}
    for one in found.results:
        profile, corner = one.profile, corners[one.strike.rotation, one.strike.rate]
        impact = profile.friction and profile.friction.impact
        jump = profile.delta_omega[0] if impact is None else impact.jumps[0, 0, :3, 3]
        assert left[one.strike.fall] @ profile.rotation[0] @ jump == pytest.approx(
            corner.after.omega - corner.before.omega, rel=1e-6
        )


def test_joints_and_parts_are_judged_in_the_strike_that_is_the_worst_for_them(figure):
    """The peak of a half-sine torque is π/2 of its mean, the impulse over its length; a part's
    duration alone gives the mean.
    """
    hip = Part(name="hip", joint="left_leg_joint", momentary_torque=20.0)
    scene = replace(figure, part=(hip,), joints=Joints(armature={"*": 0.1}))
    found = fall(replace(scene, pulse="half-sine:5ms"), headings=("left", "back"))
    expected = dict[str, tuple[float, str]]()
    for strike in found.strikes:
        profile = shock_profile(strike.scene)
        impulses = np.abs(profile.numbers(select("along"), profile.places("joint"))).tolist()
        for place, impulse in zip(profile.places("joint"), impulses, strict=True):
            name, limit = ("hip", 20.0) if place.name == hip.joint else (place.name, 9.0)
            expected[name] = min(
                expected.get(name, (math.inf, "")),
                (limit / (0.5 * math.pi * impulse / 5e-3), strike.name),
            )
    assert (len({strike.fall for strike in found.strikes}), found.rank) == (2, "part_margin")
    assert [one.margin for one in found.margins] == sorted(one.margin for one in found.margins)
    assert {one.name: one.margin for one in found.margins} == pytest.approx(
        {name: one[0] for name, one in expected.items()}
    )
    assert {one.name: one.strike for one in found.margins} == {
        name: one[1] for name, one in expected.items()
    }
    lasting = fall(
        replace(scene, part=(replace(hip, torque_duration=5e-3),)), headings=("left", "back")
    )
    assert [(one.name, one.kind) for one in lasting.margins] == [("hip", "part")]
    assert lasting.margins[0].margin == pytest.approx(expected["hip"][0] * 0.5 * math.pi)
    stiff = fall(replace(scene, contact_stiffness=1e5), headings=["left"])
    assert {one.name for one in stiff.margins} == expected.keys()
    bare = fall(scene, headings=("left", "back"))
    assert (bare.margins, bare.rank) == ((), "delta_v_max")


def test_urdf_and_mjcf_fall_alike(falls, tmp_path):
    file = tmp_path / "figure.xml"
    file.write_text(mjcf())
    other = fall(Scene(robot=str(file)))
    assert [one.strike.name for one in other.results] == [one.strike.name for one in falls.results]
    for one, same in zip(falls.results, other.results, strict=True):
        assert same.strike.struck == pytest.approx(one.strike.struck, rel=1e-6)
        assert same.values == pytest.approx(one.values, rel=1e-6, nan_ok=True)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [None, 0.5])
def test_mujoco_agrees(figure, friction):
    """Held at its edge, and on a floor with friction; python tests/wings/fall/falling.py compares twenty falls
    each.
    """
    import falling

    here, there = falling.compared(figure.robot, 0.0 if friction is None else 180.0, friction, 2e-4)
    assert here.links & there.links
    assert here.speed == pytest.approx(there.speed, rel=1e-3 if friction is None else 0.02)
    if friction is None:
        assert (here.rotation, here.rate) == pytest.approx((there.rotation, there.rate), rel=1e-3)


def test_drops(figure):
    """The 26 attitudes: the lowest point is under the centre of mass, or a face is; all strike at
    √(2 g H).
    """
    found = fall(figure, drop=0.75)
    assert len(found.results) + len(found.failures) == 26
    speed = math.sqrt(2.0 * GRAVITY * 0.75)
    for one in found.results:
        assert one.strike.speed == pytest.approx(speed, rel=1e-12)
        profile = one.profile
        com = (
            (profile.position + (profile.rotation @ profile.robot.coms[..., None])[..., 0]).T
            @ profile.robot.masses
            / profile.robot.mass
        )
        assert com[2] > 0.0
        if one.strike.fall == "face front":
            assert profile.rotation[0] @ [1.0, 0.0, 0.0] == pytest.approx(
                [0.0, 0.0, -1.0], abs=1e-12
            )
    spread = fall(figure, drop=0.75, attitudes=9)
    assert [len(spread.results), len(spread.tips)] == [9, 0]


def test_a_push_tips_or_does_not(figure, falls):
    least = {tip.name: tip.least_push for tip in falls.tips}["front"]
    harder = fall(figure, headings=("front",), push=2.0 * least)
    assert harder.tips[0].hinged > {tip.name: tip.hinged for tip in falls.tips}["front"]
    with pytest.raises(StudyError, match=r"at least 0\.\d+ m/s"):
        fall(figure, headings=("front",), push=0.9 * least)


def test_pressure_that_leaves_the_edge_is_a_warning(figure, tmp_path):
    """A mass to one side and in front lets the robot turn about a corner; the figure itself does
    not.
    """
    file = tmp_path / "uneven.urdf"
    file.write_text(
        urdf((*PARTS, ("load", "torso", (0.3, 0.6, 0.5), (0.0, 0.0, 0.0), (0.1, 0.1, 0.1), 8.0)))
    )
    (uneven,) = fall(Scene(robot=str(file)), headings=("front",)).tips
    assert any("centre of pressure" in text for text in uneven.warnings)
    (even,) = fall(figure, headings=("front",)).tips
    assert even.warnings == ()


def test_a_link_with_visual_geometry_alone_strikes_with_it(falls, tmp_path):
    """As with collision geometry of the same shape; a note names it."""
    file, head, tail = tmp_path / "hands.urdf", *urdf().split('<link name="left_arm">')
    file.write_text(f'{head}<link name="left_arm">{tail.replace("collision", "visual", 2)}')
    found = fall(Scene(robot=str(file)), headings=("left",))
    (note,) = found.notes
    assert says(note, "visual geometry", '"left_arm"', "delta_v_max")
    same = [one for one in falls.results if one.strike.fall == "left"]
    for one, other in zip(found.results, same, strict=True):
        assert one.strike.struck == pytest.approx(other.strike.struck, rel=1e-9)
        assert one.strike.rotation == pytest.approx(other.strike.rotation, rel=1e-9)


def test_what_cannot_fall_says_why(figure, tmp_path):
    bare, feet = tmp_path / "bare.urdf", tmp_path / "feet.urdf"
    bare.write_text(urdf(shapes=""))
    sole = (
        '<collision><origin xyz="0 -0.1 -0.7"/><geometry><box size="0.2 0.3 '
        '0.01"/></geometry></collision>'
    )
    feet.write_text(
        urdf(shapes="").replace('<link name="left_leg">', f'<link name="left_leg">{sole}')
    )
    visual = tmp_path / "visual.urdf"
    visual.write_text(urdf(shapes="visual"))
    seen = fall(Scene(robot=str(visual)), headings=("front",))
    assert "visual geometry strikes" in seen.notes[0]
    assert seen.results
    for scene, options, words in (
        (Scene(robot=str(bare)), {}, "neither collision nor visual geometry"),
        (Scene(robot=str(feet)), {}, "because they have no geometry"),
        (Scene(robot=figure.robot, base="fixed"), {}, "--base free"),
        (Scene(robot=figure.robot, strike=Strike(speed=2.0)), {}, "gives .speed.: a fall computes"),
        (
            Scene(robot=figure.robot, contact=Contact(frame="left_leg", restitution=0.5)),
            {},
            "restitution",
        ),
        (figure, {"headings": ("up",)}, '"up" is no heading'),
        (figure, {"drop": -1.0}, "drop must be > 0"),
        (figure, {"attitudes": 5}, "give its height"),
        (figure, {"drop": 1.0, "push": 1.0}, "a drop is given"),
        (figure, {"drop": 1.0, "headings": ("left",), "least": 1.0}, '"headings", "least": only'),
    ):
        with pytest.raises(StudyError, match=words):
            fall(scene, **options)


def test_a_robot_with_negative_moments_of_inertia_does_not_fall(tmp_path):
    file = tmp_path / "negative.urdf"
    file.write_text(urdf().replace('iyz="0"', 'iyz="90"', 1))
    with pytest.raises(SolveError, match=r"principal moments of .torso."):
        fall(Scene(robot=str(file)))


def test_standing_points_may_have_offsets(figure):
    """A stance FRAME:x,y,z holds that point: the impulse there keeps it at rest."""
    scene = Scene(
        robot=figure.robot,
        contact=Contact(frame="left_arm", offset=(0.4, 0.0, 0.0)),
        stance=("left_leg:0.06,0.05,-0.7",),
    )
    profile = shock_profile(scene)
    leg = load_robot(figure.robot).frame("left_leg").body
    r = np.array([0.06, 0.05, -0.7])
    jump = profile.delta_v[leg] + np.cross(profile.delta_omega[leg], r)
    assert jump == pytest.approx(np.zeros(3), abs=1e-9)


def test_command(figure, tmp_path, capfd):
    """The table names what strikes; JSON, CSV, figure and page are written; several postures."""
    out = tmp_path / "out"
    shown = good(
        capfd, "fall", figure.robot, "--heading", "front", "--friction", "0.5", "--out", out
    )
    assert "left_arm" in shown
    assert {
        "fall.json",
        "fall.png",
        "fall.svg",
        "falls.csv",
        "report.html",
        "report.md",
        "strikes.csv",
    } <= {x.name for x in out.iterdir()}
    written = json.loads((out / "fall.json").read_text())
    assert written["schema"] == "shockpc.fall/2"
    assert written["failures"] == []
    assert {row["motion"] for row in written["tables"]["strikes"]} <= {
        "pivots",
        "slides",
        "is in the air",
    }
    assert "front 1" in (out / "report.html").read_text()
    vary = run(
        capfd,
        "fall",
        figure.robot,
        "--heading",
        "back",
        "--vary",
        "left_arm_joint=0,20",
        "--format",
        "csv",
    ).out
    assert {line.split(",")[0] for line in vary.splitlines()[1:]} == {
        "left_arm_joint=0 back",
        "left_arm_joint=20 back",
    }
    assert "different robots" in run(capfd, "fall", figure.robot, "go2").err


def test_a_disc_lands_on_its_edge_and_then_flat(tmp_path):
    """A rod with flat ends, which falls with the box that carries it: its end is a strike of its
    own when it lands flat.
    """
    rod = (
        '<origin xyz="0.175 0 0.15" rpy="0 1.5707963267948966 0"/><geometry><cylinder radius="0.1" '
        'length="0.25"/></geometry>'
    )
    box = '<origin xyz="0 0 0.1"/><geometry><box size="0.1 0.1 0.2"/></geometry>'
    inertia = '<inertia ixx="1" iyy="1" izz="0.1" ixy="0" ixz="0" iyz="0"/><origin xyz="0 0 2"/>'
    solid = f"<collision>{box}</collision><collision>{rod}</collision>"
    robot = tmp_path / "post.urdf"
    robot.write_text(
        f'<robot name="post"><link name="post"><inertial><mass '
        f'value="10"/>{inertia}</inertial>{solid}</link></robot>'
    )
    found = fall(Scene(robot=str(robot), friction=0.6), headings=("front",), least=0.3)
    assert math.degrees(found.strikes[0].rotation) == pytest.approx(90.0)
    assert all(strike.struck for strike in found.strikes)


def test_a_fall_without_a_strike_of_that_speed_is_listed(falls):
    """With what it does until it rests, beside those that strike."""
    strikes = tuple(strike for strike in falls.strikes if strike.fall == "front")
    results = tuple(result for result in falls.results if result.strike.fall == "front")
    of_front = falls.table.columns["fall"] == "front"
    columns = {name: values[of_front] for name, values in falls.table.columns.items()}
    table = replace(falls.table, columns=columns)
    front = fall_report(replace(falls, strikes=strikes, results=results, table=table))
    (row,) = [row for row in front.text("table").splitlines() if row.startswith("left  ")]
    assert "pivots to" in row
    assert row.split()[-3:] == ["0", "–", "–"]
