"""The figure: what is coloured how, what is written, and that the file is small and always the
same.
"""

import io
import time
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
import shapely
from commands import python
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.text import Text

import shockpc
import shockpc.show.figure.body_shapes
from shockpc import Contact, Joints, Posture, Scene, Strike, load_robot, sensitivity, shock_profile
from shockpc.core.spatial import plane_from
from shockpc.landing.scenes.scene_file import with_plane
from shockpc.robot.shapes.convex import Shape
from shockpc.robot.shapes.mesh import Mesh
from shockpc.show.figure.field import Field, field_of
from shockpc.show.figure.labels import LETTERS, PALE, SMALL
from shockpc.show.figure.layout import Page
from shockpc.show.figure.picture import layers
from shockpc.show.figure.plane import draw_landing
from shockpc.show.figure.silhouette import silhouette, to_plane
from shockpc.show.figure.style import BANDS, DPI, EDGES, band, plain_numbers, render, settings
from shockpc.show.figure.view import view_of
from shockpc.studies.sensitivity.figure import draw_tornado

SAGITTAL = plane_from((0.0, -1.0, 0.0))
BOX = shapely.box(-1.0, -1.0, 1.0, 1.0)


def landing(robot, *frames, angle=0.0, **scene):
    """A profile; every case is computed once."""
    return shock_profile(
        Scene(
            robot=robot,
            contact=tuple(Contact(frame=f) for f in frames),
            strike=Strike(speed=1.0, strike_angle_deg=angle),
            **scene,
        )
    )


@pytest.fixture(scope="module")
def anymal():
    return landing("anymal_b", "LF_FOOT")


@pytest.fixture(scope="module")
def beam():
    return landing("beam", "tip")


def drawn(profile):
    """The files of a landing's figure."""
    return render("shock", lambda: draw_landing(profile))


def words(figure):
    """Everything written in a figure, save the coordinates."""
    legends = [
        text for axes in figure.axes if axes.get_legend() for text in axes.get_legend().get_texts()
    ]
    return [
        text.get_text()
        for text in [*(text for axes in figure.axes for text in axes.texts), *legends]
    ]


def shape(points, radius=0.0, triangles=None):
    """A shape in the plane's axes: x forward, z up."""
    points = np.asarray(points, dtype=float)
    mesh = None if triangles is None else Mesh(points, np.asarray(triangles))
    return Shape("link", points, radius * np.eye(3), mesh)


def projection(*shapes, resolution=1e-3):
    return silhouette(shapes, SAGITTAL, resolution)


# Silhouettes


SQUARE = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]], dtype=float)
TILTED_DISC = np.array([[1.0, 0.0, 0.0], [0.0, -0.6, 0.0], [0.0, 0.8, 0.0]])
AREAS = {
    "a ball is a disc": (
        [shape([[0.3, 0.1, -0.2]], 0.25)],
        np.pi * 0.25**2,
        (0.05, -0.45, 0.55, 0.05),
    ),
    "a capsule is a stadium": (
        [shape([[0, 0, 0], [0.6, 0, 0.8]], 0.1)],
        0.2 + np.pi * 0.01,
        (-0.1, -0.1, 0.7, 0.9),
    ),
    "a tilted cylinder is an ellipse swept along a segment": (
        [Shape("link", np.array([[0, -0.4, 0], [0, 0.4, 0.6]]), 0.2 * TILTED_DISC)],
        np.pi * 0.04 * 0.8 + 0.4 * 0.6,
        (-0.2, -0.16, 0.2, 0.76),
    ),
    "what overlaps counts once": (
        [shape(SQUARE), shape(SQUARE + np.array([0.5, 0, 0.5]))],
        1.75,
        (0, 0, 1.5, 1.5),
    ),
}


@pytest.mark.parametrize("name", AREAS)
def test_silhouettes_have_the_area_and_extent_of_their_closed_form(name):
    """A plate seen from its edge has an area too, for there would be nothing to colour."""
    shapes, area, bounds = AREAS[name]
    found = projection(*shapes)
    assert found.area == pytest.approx(area, rel=5e-3)
    assert found.bounds == pytest.approx(bounds, abs=1e-3)
    assert projection(shape([[0, 0, 0], [1, 0, 0], [0, 1, 0]])).area > 0.0


def ring(inner, outer, count):
    """Triangles of a flat ring, alternately turned over, so that it is no closed surface."""
    turn = 2 * np.pi * np.arange(count) / count
    circle = np.stack([np.cos(turn), 0 * turn, np.sin(turn)], axis=1)
    k = np.arange(count)
    following = (k + 1) % count
    one = np.stack([k, following, k + count], axis=1)
    other = np.stack([following, k + count, following + count], axis=1)
    return np.concatenate([inner * circle, outer * circle]), np.concatenate([one, other])


@pytest.mark.parametrize("count", [8, 60, 50_000])
def test_a_mesh_keeps_its_hole(count):
    """A ring of triangles keeps its area and its hole, coarse or fine, though it is not closed and
    faces both ways; and quickly.
    """
    points, triangles = ring(0.5, 1.0, count)
    start = time.process_time()
    region = projection(shape(points, triangles=triangles))
    assert time.process_time() - start < 1.5
    polygon = 0.5 * count * np.sin(2 * np.pi / count)
    assert region.area == pytest.approx(0.75 * polygon, rel=5e-3)
    assert not region.contains(shapely.Point(0, 0))
    assert sum(len(part.interiors) for part in shapely.get_parts(region)) == 1


def area(corners):
    """Of a triangle x1 y1 x2 y2 x3 y3."""
    x1, y1, x2, y2, x3, y3 = corners
    return abs((x2 - x1) * (y3 - y1) - (x3 - x1) * (y2 - y1)) / 2


# The exact union is wrong where coordinates are products of numbers such as 1e-308.
MICROMETRES = st.integers(-1_000_000, 1_000_000).map(lambda count: count * 1e-6)


@given(
    st.lists(
        st.tuples(*[MICROMETRES] * 6).filter(lambda corners: area(corners) > 1e-3),
        min_size=1,
        max_size=12,
    )
)
def test_a_mesh_is_projected_to_the_union_of_its_triangles(corners):
    """Any set of triangles: its projection differs from the exact union by no more than the
    resolution along its edges.
    """
    flat = np.array(corners).reshape(-1, 2)
    points = np.stack([flat[:, 0], 0 * flat[:, 0], flat[:, 1]], axis=1)
    triangles = np.arange(len(points)).reshape(-1, 3)
    exact = shapely.union_all(shapely.polygons(flat[triangles]))
    found = projection(shape(points, triangles=triangles), resolution=4e-3)
    assert found.difference(exact.buffer(6e-3)).area == pytest.approx(0.0, abs=1e-4)
    assert exact.buffer(-6e-3).difference(found).area == pytest.approx(0.0, abs=1e-9)


# Colours

SPEEDS = st.tuples(*[st.floats(-3, 3)] * 3).map(np.array)
SPINS = st.one_of(
    SPEEDS,
    st.floats(-5, 5).map(lambda w: np.array([0.0, w, 0.0])),
    SPEEDS.map(lambda w: w * [1, 0, 1]),
    SPEEDS.map(lambda w: 1e-7 * w),
    st.just(np.zeros(3)),
)


def field(omega, v, points=((0.0, 0.0, 0.0),)):
    """The field of a body at the origin, in the sagittal plane, for a strike of 1 m/s; the points
    are on its surface.
    """
    profile = SimpleNamespace(
        rotation=[np.eye(3)],
        plane=SAGITTAL,
        delta_omega=[omega],
        delta_v=[v],
        v_in=1.0,
        position=np.zeros((1, 3)),
    )
    return field_of(profile, 0, np.array(points))


@given(SPINS, SPEEDS)
def test_a_leaning_limb_is_coloured_along_itself(omega, v):
    """|Δv + Δω × r| at points of the plane; where a body leans across it, of the body's points, not
    of those at that depth.
    """
    r = np.array([0.3, 0.0, -0.7])
    assert field(omega, v).at(r[[0, 2]]) == pytest.approx(
        np.linalg.norm(v + np.cross(omega, r)), abs=1e-12
    )
    along = np.array([0.2, 0.5, -1.0])
    limb = np.linspace(0.0, 1.0, 20)[:, None] * along + [0.1, 0.3, 0.0]
    found = field(omega, v, limb).at(to_plane(limb, SAGITTAL))
    # The slope is held back by a hundredth of the limb's spread.
    slack = 0.02 * np.linalg.norm(omega)
    np.testing.assert_allclose(
        found, np.linalg.norm(v + np.cross(omega, limb), axis=1), atol=slack + 1e-12
    )


@pytest.mark.parametrize("plane", ["xz", "yz", (1.0, 1.0, 0.2)])
@pytest.mark.parametrize(
    ("robot", "frame"), [("anymal_b", "LF_FOOT"), ("hyq", "lf_foot"), ("talos", "left_sole_link")]
)
def test_the_struck_point_has_the_colour_of_the_strike(robot, frame, plane):
    """Shock is 1 where the robot is struck, in whatever plane it is drawn."""
    profile = landing(robot, frame, plane=plane)
    drawn = next(d for d in view_of(profile).drawn if d.body == profile.robot.frame(frame).body)
    assert drawn.field.at(to_plane(profile.contacts[0].point, profile.plane)) == pytest.approx(
        1.0, abs=0.08
    )


def inside(patch, points):
    """Which points a rectangle or an ellipse holds."""
    if isinstance(patch, Rectangle):
        x0, y0, x1, y1 = patch.get_bbox().extents
        return np.all((points >= (x0, y0)) & (points <= (x1, y1)), axis=1)
    turn = np.radians(patch.angle)
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    return (
        np.linalg.norm(
            (points - patch.center) @ axes.T / (0.5 * np.array([patch.width, patch.height])), axis=1
        )
        <= 1.0
    )


GRID = np.stack(
    np.meshgrid(np.linspace(-0.99, 0.99, 21), np.linspace(-0.99, 0.99, 21)), axis=-1
).reshape(-1, 2)


@given(SPINS, SPEEDS)
def test_every_point_has_the_colour_of_its_shock(omega, v):
    """The band painted last over a point is that of its shock, to the accuracy of a line; the first
    one covers the body.
    """
    f = field(omega, v)
    seen = np.full(len(GRID), -1)
    for k, patch in layers(BOX, f):
        seen[inside(patch, GRID)] = k
    assert np.all(seen >= 0)
    # a change over the body of up to 1e-3 is left out
    shock, edges, slack = f.at(GRID), np.array(EDGES), 2e-3
    assert np.all(edges[seen] - slack <= shock)
    assert np.all(shock <= edges[seen + 1] + slack)


def test_shocks_that_round_to_1_are_grey_and_nothing_is_clipped():
    """The band around 1 goes from 0.95 to 1.05; shock far above 1 has a colour of its own, darker
    than all others.
    """
    shocks = (0.0, 0.1, 0.94, 0.96, 1.0, 1.03, 1.06, 2.0, 2.01, 1e9)
    assert [band(s) for s in shocks] == [0, 0, 4, 5, 5, 5, 6, 8, 9, 9]
    assert np.hypot(*lightness(BANDS[5])[1:]) < 5.0
    ((k, patch),) = layers(BOX, Field(np.array([50.0, 0, 0]), np.zeros((3, 2))))
    assert k == len(BANDS) - 1
    assert np.all(inside(patch, GRID))


def lightness(colour, blindness=None):
    """L* of a colour, and its chroma a*, b*, as seen by an eye of that kind (Machado and others,
    2009, severity 1).
    """
    channels = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    seen = {
        None: np.eye(3),
        "protan": [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ],
        "deutan": [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ],
        "tritan": [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ],
    }[blindness]
    to_xyz = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    xyz = to_xyz @ np.clip(np.array(seen) @ linear, 0, 1) / [0.9505, 1.0, 1.089]
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("blindness", [None, "protan", "deutan", "tritan"])
def test_every_eye_can_order_the_bands(blindness):
    """Lightness falls by 5 L* from band to band, so grey paper keeps the order; the limits around 1
    are the largest steps.
    """
    seen = np.array([lightness(colour, blindness) for colour in BANDS])
    steps = np.linalg.norm(np.diff(seen, axis=0), axis=1)
    assert np.all(np.diff(seen[:, 0]) < -5.0)
    assert np.all(steps > 8.0)
    if blindness != "tritan":
        assert set(np.argsort(steps)[-2:]) == {EDGES.index(0.95) - 1, EDGES.index(1.05) - 1}


# The whole figure


BAR = "normalised shock |Δv| / v_in [-]; grey: 1.0 when rounded"
WRITTEN = {
    "anymal_b: shock of landing on LF_FOOT": {},
    "posture standing; base planar; speed 2 m/s, 30 deg from the vertical; contact slides; "
    "restitution 0.5": {
        "base": "planar",
        "strike": Strike(speed=2.0, strike_angle_deg=30.0),
        "contact": Contact(frame="LF_FOOT", directions=("z",), restitution=0.5),
    },
    # Of the contact's velocity, as in the report.
    "speed 3.723 m/s, −40.06 deg from the vertical, robot rotates at (0, 5, 0) rad/s": {
        "strike": Strike(angular_velocity=(0.0, 5.0, 0.0))
    },
    "joint model: free (zero reflected inertia; a stiff gearbox changes the results considerably)": {
        "joints": Joints(drives="none")
    },
    "peak acceleration for a pulse half-sine:5ms": {"pulse": "half-sine:5ms"},
    "contact that moves perpendicular to the plane": {"plane": "xy"},
}


@pytest.mark.parametrize("sentence", WRITTEN)
def test_the_figure_states_what_was_computed(sentence):
    """Robot, posture, strike and joint model can be read off it, with units; what is not drawn is
    in no key.
    """
    scene = WRITTEN[sentence]
    profile = shock_profile(Scene(**({"robot": "anymal_b", "contact": "LF_FOOT"} | scene)))
    figure, up = draw_landing(profile), "y [m]" if "plane" in scene else "z [m]"
    written = set(words(figure))
    assert any(sentence in text for text in written)
    assert {
        "imu_link",
        "LF_SHANK",
        "CoPc x",
        up,
        "RoPc [m]",
        "shock [-]",
        BAR,
        f"{profile.points[0].shock:.2f}",
    } <= written
    assert ("peak [g]" in written) == ("pulse" in scene)
    assert ("velocity of the contact before the impact" in written) == ("plane" not in scene)
    picture = figure.axes[1]
    assert (picture.get_xlabel(), picture.get_ylabel()) == ("x [m]", up)


def test_every_contact_has_an_arrow_of_its_own_velocity():
    """A robot that pitches forward comes down faster in front than behind, and the lengths of the
    arrows are as the speeds.
    """
    strike = Strike(angular_velocity=(0.0, 1.0, 0.0))
    contacts = (Contact(frame="LF_FOOT"), Contact(frame="LH_FOOT"))
    profile = shock_profile(Scene(robot="anymal_b", contact=contacts, strike=strike))
    picture = draw_landing(profile).axes[1]
    lines = [
        np.subtract(*patch._posA_posB[::-1])
        for patch in picture.patches
        if getattr(patch, "_posA_posB", None)
    ]
    arrows = np.array([line for line in lines if np.linalg.norm(line) > 0.0])
    for contact in profile.contacts:
        along = to_plane(contact.approach, profile.plane)
        share = np.linalg.norm(along) / np.linalg.norm(profile.strike)
        length = share * max(np.linalg.norm(arrows, axis=1))
        assert any(
            np.allclose(arrow, along / np.linalg.norm(along) * length, atol=1e-9)
            for arrow in arrows
        )
    front, hind = (np.linalg.norm(contact.approach) for contact in profile.contacts)
    assert front > 1.5 * hind


def test_nearer_limbs_cover_farther_ones_but_not_the_struck_one(anymal):
    """Left legs are far in the sagittal picture, so the right fore leg, which hides the struck one,
    is drawn by its edge.
    """
    view = view_of(anymal)
    order = [anymal.bodies[drawn.body] for drawn in view.drawn]
    assert order.index("LH_SHANK") < order.index("base") < order.index("RH_SHANK")
    outlined = {anymal.bodies[drawn.body] for drawn in view.drawn if drawn.outlined}
    assert {"RF_THIGH", "RF_SHANK"} <= outlined
    assert not any(name.startswith(("LF", "RH", "LH", "base")) for name in outlined)
    assert [anymal.bodies[i] for i in view.numbers] == ["base", "LF_HIP", "LF_THIGH", "LF_SHANK"]


def test_every_centre_of_percussion_is_in_the_table():
    """Struck near its middle, a beam rotates about a point 1.7 m beyond its end: not in the
    picture, but beside it.
    """
    profile = shock_profile(
        Scene(robot="beam", contact=Contact(frame="center", offset=(0.04, 0.0, 0.0)))
    )
    figure = draw_landing(profile)
    x, z = to_plane(profile.copc_world, profile.plane)[0]
    assert x < figure.axes[1].get_xlim()[0]
    assert {f"{x:.2f}".replace("-", "−"), f"{z + 0.0:.2f}"} <= set(words(figure))
    assert "CoPc of the body with this number" not in words(figure)


def test_a_long_line_under_the_title_is_wrapped():
    """Many joint angles are read as easily as few: the letters stay as large, and the lines hold
    all of them.
    """
    angles = dict.fromkeys(
        ("FL_calf_joint", "FR_calf_joint", "RL_calf_joint", "RR_calf_joint"), -90.0
    )
    figure = draw_landing(
        landing("go2", "FL_foot", posture=Posture(joints_deg=angles), base="planar")
    )
    texts = [text for text in figure.axes[0].texts if text.get_fontsize() == 8.0]
    lines = [text.get_text() for text in texts]
    assert len(lines) > 2
    whole = " ".join(lines)
    assert all(f"{name} = −90 deg" in whole for name in angles)
    assert "speed 1 m/s, 0 deg from the vertical" in whole
    width = figure.get_size_inches()[0] * figure.dpi
    assert all(text.get_window_extent().x1 < width for text in texts)
    heading = Page(4.0, 2.0, ["title", "words " * 60]).figure.axes[0].texts[1:]
    assert len(heading) > 3
    assert {text.get_fontsize() for text in heading} == {8.0}


def test_a_centre_of_percussion_that_says_little_is_faint():
    """The trunk of Go2 on one foot rotates mostly out of the plane: its CoPc is in brackets and
    grey, not that of the thigh.
    """
    profile = landing("go2", "FL_foot")
    trunk, thigh = (profile.bodies.index(name) for name in ("base", "FL_thigh"))
    assert profile.out_of_plane_share[trunk] > 0.5 > profile.out_of_plane_share[thigh]
    figure = draw_landing(profile)
    written = words(figure)
    assert f"({profile.ropc[trunk]:.2f})" in written
    assert f"{profile.ropc[thigh]:.2f}" in written
    inks = {
        text.get_text(): text.get_color()
        for text in figure.axes[1].texts
        if text.get_fontsize() == LETTERS
    }
    assert inks["(1)"] == PALE
    assert inks["3"] != PALE


def test_a_body_that_only_translates_has_no_centre():
    """Struck in the middle, the beam has one colour, no CoPc and no RoPc; and nothing of it moves
    out of the plane.
    """
    profile = landing("beam", "center")
    written = words(draw_landing(profile))
    assert {"none", "inf"} <= set(written)
    assert not any(
        "CoPc of" in text or "RoPc:" in text or "out of the plane" in text for text in written
    )
    assert any(
        "out of the plane" in text for text in words(draw_landing(landing("anymal_b", "LF_FOOT")))
    )
    ((k, _),) = layers(view_of(profile).drawn[0].region, view_of(profile).drawn[0].field)
    assert k == band(1.0)


BARE = (
    '<robot name="bare"><link name="trunk"><inertial><mass value="3"/>'
    '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>{}</link>'
    '<link name="empty"/><joint name="j" type="revolute"><parent link="trunk"/><child '
    'link="empty"/><axis xyz="0 1 0"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
)
LOST = '<visual><geometry><mesh filename="package://bare/trunk.stl"/></geometry></visual>'
MARKER = '<visual><geometry><box size="0.001 0.001 0.001"/></geometry></visual>'


@pytest.mark.parametrize(
    "shapes", ["", LOST, LOST + MARKER], ids=["none", "a missing mesh", "and a marker"]
)
def test_a_body_without_shapes_is_the_box_of_its_inertia(tmp_path, monkeypatch, shapes):
    """A marker does not stand for it; what is missing is named, also where there is no inertia; an
    empty picture says so.
    """
    (tmp_path / "bare.urdf").write_text(BARE.format(shapes))
    contact = Contact(frame="trunk", offset=(0.2, 0.0, -0.2))
    scene = Scene(
        robot=str(tmp_path / "bare.urdf"), contact=contact, joints=Joints(armature={"j": 0.01})
    )
    profile = shock_profile(scene)
    (trunk,) = (drawn for drawn in view_of(profile).drawn if drawn.body == 0)
    assert trunk.box
    assert trunk.region.area == pytest.approx(6 * 0.1 / 3)
    written = set(words(draw_landing(profile)))
    assert {
        "box of the inertia: there is no shape to draw",
        "not drawn, neither shape nor valid inertia: empty",
    } <= written
    assert ("meshes that are missing or cannot be read: trunk.stl" in written) == bool(shapes)
    if not shapes:
        monkeypatch.setattr(shockpc.show.figure.body_shapes, "inertia_box", lambda _: None)
        with settings():
            # not the one whose silhouettes are kept
            figure = draw_landing(shock_profile(scene, load_robot(scene.robot)))
            assert "no body has a shape\nor a valid inertia" in words(figure)
            assert outside(figure) == []


def test_a_box_of_inertia_that_is_larger_than_the_robot_is_an_outline(tmp_path):
    """The trunk has no shape and an inertia like that of a cube of 0.45 m; all that is known of the
    shape is a ball of 0.1 m.
    """
    ball = '<link name="empty"><visual><geometry><sphere radius="0.05"/></geometry></visual></link>'
    (tmp_path / "bare.urdf").write_text(BARE.format("").replace('<link name="empty"/>', ball))
    scene = Scene(
        robot=str(tmp_path / "bare.urdf"), contact="trunk", joints=Joints(armature={"j": 0.01})
    )
    assert [
        (drawn.box, drawn.outlined) for drawn in sorted(view_of(shock_profile(scene)).drawn)
    ] == [(True, True), (False, False)]


@pytest.mark.parametrize("inertia", [1e-4, 1.0])
def test_without_shapes_a_box_is_compared_with_the_places_of_the_robot(tmp_path, inertia):
    """A hand at the end of an arm of 0.4 m, with the inertia of a cube of 6 m, is an outline and
    does not shrink the picture.
    """
    moments = " ".join(
        f'{name}="{inertia * (name[1] == name[2])}"'
        for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    )
    hand = f'<inertial><mass value="0.1"/><inertia {moments}/></inertial>'
    text = BARE.format("").replace('<link name="empty"/>', f'<link name="empty">{hand}</link>')
    (tmp_path / "bare.urdf").write_text(
        text.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0"/><origin xyz="0.4 0 0"/>')
    )
    view = view_of(shock_profile(Scene(robot=str(tmp_path / "bare.urdf"), contact="empty")))
    assert {drawn.body: drawn.outlined for drawn in view.drawn} == {0: False, 1: inertia > 0.1}
    assert view.size < 1.0


def test_a_fall_to_the_side_is_in_the_frontal_plane(anymal):
    """Numbers and picture are those of --plane yz; a plane that is given is kept."""
    scene = Scene(robot="anymal_b", contact="LF_FOOT", strike=Strike(velocity=(0.0, -0.8, -0.6)))
    profile, frontal, sagittal = (
        shock_profile(replace(scene, plane=plane)) for plane in ("auto", "yz", "xz")
    )
    assert profile.scene.plane == "yz"
    assert np.array_equal(profile.ropc, frontal.ropc)
    assert not np.allclose(profile.ropc, sagittal.ropc)
    assert draw_landing(profile).axes[1].get_xlabel() == "y [m]"
    assert any(text.endswith("plane yz (frontal)") for text in words(draw_landing(profile)))
    assert draw_landing(sagittal).axes[1].get_xlabel() == "x [m]"


@pytest.mark.parametrize(
    ("omega", "plane"),
    [
        ((3.0, 0.0, 0.0), "yz"),
        ((0.3, 0.0, 0.0), "xz"),
        ((0.0, 3.0, 0.0), "xz"),
        ((3.0, 3.0, 1.0), "yz"),
    ],
)
def test_a_body_that_tips_to_the_side_falls_in_the_frontal_plane(omega, plane):
    """The base moves straight down, in both planes: the rotation decides, and a slow one does not."""
    scene = with_plane(
        Scene(robot="any", strike=Strike(velocity=(0.0, 0.0, -1.0), angular_velocity=omega))
    )
    assert scene.plane == plane


def test_the_figure_has_the_warnings_and_names_colours_beyond_the_table(tmp_path):
    """Colours are of the visible cube, the table of a collision cube a tenth as large; the first
    warnings stand beside them.
    """
    cubes = "".join(
        f'<{kind}><geometry><box size="{a} {a} {a}"/></geometry></{kind}>'
        for kind, a in (("visual", 1), ("collision", 0.1))
    )
    (tmp_path / "cube.urdf").write_text(BARE.format(cubes))
    scene = Scene(
        robot=str(tmp_path / "cube.urdf"),
        contact=Contact(frame="trunk", offset=(0.5, 0.0, -0.5)),
        pulse="half-sine:5ms",
    )
    profile = shock_profile(replace(scene, joints=Joints(armature={"j": 0.01})))
    (trunk,) = (drawn for drawn in view_of(profile).drawn if drawn.body == 0)
    greatest = trunk.field.at(np.array([[x, z] for x in (-0.5, 0.5) for z in (-0.5, 0.5)])).max()
    written = " ".join(words(draw_landing(profile)))
    assert greatest > 1.5 * profile.shock_max[0]
    assert f"reach {greatest:.2f} on 1;" in written
    assert "CoPc in world axes" in written
    assert f"warning: {profile.health.warnings[0]}"[:40] in written


def outside(figure):
    """Texts that leave the page, in pixels of the canvas."""
    FigureCanvasAgg(figure).draw()
    width, height = figure.canvas.get_width_height()
    ticks = {
        text for axes in figure.axes for text in (*axes.get_xticklabels(), *axes.get_yticklabels())
    }
    texts = [
        text
        for text in figure.findobj(Text)
        if text.get_visible() and text.get_text() and text not in ticks
    ]
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts]
    return [name for name, b in boxes if b.x0 < 0 or b.y0 < 0 or b.x1 > width or b.y1 > height]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "frames", "angle", "plane"),
    [
        ("anymal_b", ["LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"], 0.0, "xz"),
        ("talos", ["left_sole_link"], 30.0, "yz"),
        ("solo12", ["FL_FOOT"], 30.0, "xz"),
        ("quadruped", ["hind_foot"], 0.0, "xz"),
        ("hyq", ["lf_foot"], 0.0, (1.0, 1.0, 0.2)),
    ],
)
def test_no_letter_leaves_the_page_or_covers_a_number(robot, frames, angle, plane):
    """Robots of every shape, in every plane; no label is written over the number of a body."""
    with settings():
        figure = draw_landing(landing(robot, *frames, angle=angle, plane=plane))
        assert outside(figure) == []
        texts = figure.axes[1].texts
        rings = [text.get_window_extent() for text in texts if text.get_fontsize() == 6.5]
        labels = [text.get_window_extent() for text in texts if text.get_fontweight() == "bold"]
    assert rings
    assert labels
    assert not any(ring.overlaps(label) for ring in rings for label in labels)


def test_names_beside_bars_are_on_the_page_of_the_png():
    """The layout is found at the resolution of the SVG; at that of the PNG the letters are as wide."""
    with settings():
        figure = draw_tornado(
            sensitivity(Scene(robot="g1", contact="left_ankle_roll_link"), "shock@imu_in_torso")
        )
        figure.savefig(io.BytesIO(), format="svg")
        figure.set_layout_engine("none")
        figure.set_dpi(DPI)
        assert outside(figure) == []
        assert min(name.get_window_extent().x0 for name in figure.axes[0].get_yticklabels()) >= 0.0


@pytest.mark.parametrize(
    ("limits", "written"),
    [((0.004, 0.05), "0.005 0.006 0.01 0.02"), ((0.012, 0.45), "0.02 0.05 0.1 0.2")],
)
def test_numbers_of_a_short_logarithmic_axis_are_plain(limits, written):
    """Those between powers of ten are written too, and none as a formula."""
    with settings():
        axes = Figure().add_subplot(yscale="log", ylim=limits)
        plain_numbers(axes.yaxis)
        FigureCanvasAgg(axes.figure).draw()
        assert set(written.split()) <= {
            label.get_text() for label in axes.get_yticklabels(which="both")
        }


def test_every_circle_has_the_number_of_its_body():
    """It is written on the circle."""
    with settings():
        profile = landing("talos", "left_sole_link", joints=Joints(model="free"))
        axes = draw_landing(profile).axes[1]
    view = view_of(profile)
    texts = [text for text in axes.texts if text.get_fontsize() == SMALL]
    assert sorted(text.get_text() for text in texts) == ["4", "5"]
    for text in texts:
        i = next(i for i, number in view.numbers.items() if str(number) == text.get_text())
        assert np.linalg.norm(np.array(text.get_position()) - view.centres[i]) == pytest.approx(
            view.radii[i]
        )


def test_the_other_arm_does_not_hide_the_struck_one():
    """A hand is struck, and the trunk is between it and the base: the other arm in front is
    outlined, the head is not.
    """
    profile = landing("talos", "arm_left_7_link")
    outlined = {profile.bodies[one.body] for one in view_of(profile).drawn if one.outlined}
    assert "arm_right_4_link" in outlined
    assert not any(name.startswith(("arm_left", "torso")) for name in outlined)


def test_names_are_written_as_they_are(tmp_path):
    """Dollar signs are no formula, control characters become escapes, a long name is cut, and any
    script is valid.
    """
    name = "a$b$c\n足" + "long" * 40
    (tmp_path / "odd.urdf").write_text(
        BARE.format("").replace("trunk", name.replace("\n", "&#10;")), encoding="utf-8"
    )
    profile = shock_profile(
        Scene(robot=str(tmp_path / "odd.urdf"), contact=name, joints=Joints(armature={"j": 0.01}))
    )
    written = "".join(ElementTree.fromstring(drawn(profile)["shock.svg"]).itertext())
    assert "a$b$c\\n足" in written
    assert "long" * 40 not in written


def test_the_files_are_small_and_always_the_same(anymal):
    """ANYmal with its meshes is below 300 kB; two runs write the same bytes, with no date, and
    change no setting of matplotlib.
    """
    before = dict(matplotlib.rcParams)
    files = drawn(anymal)
    assert dict(matplotlib.rcParams) == before
    assert set(files) == {"shock.svg", "shock.png"}
    assert files == drawn(anymal)
    assert len(files["shock.svg"]) < 300_000
    assert b"<dc:date>" not in files["shock.svg"]
    assert "anymal_b: shock of landing on LF_FOOT" in "".join(
        ElementTree.fromstring(files["shock.svg"]).itertext()
    )
    assert files["shock.png"].startswith(b"\x89PNG\r\n")


SCRIPT = """
import hashlib, sys
from shockpc import Contact, Scene, shock_profile
from shockpc.show.figure.style import render
from shockpc.show.figure.plane import draw_landing
profile = shock_profile(Scene(robot="beam", contact="tip"))
files = render("shock", lambda: draw_landing(profile))
print(hashlib.sha256(b"".join(files.values())).hexdigest(), "matplotlib.pyplot" in sys.modules)
"""


@pytest.mark.slow
def test_settings_of_matplotlib_change_nothing(tmp_path, monkeypatch):
    """Neither a matplotlibrc in the current folder nor a backend; pyplot is not imported."""
    plain = python(SCRIPT)
    (tmp_path / "matplotlibrc").write_text("font.size: 40\naxes.facecolor: no-such-colour\n")
    monkeypatch.chdir(tmp_path)
    changed = python(SCRIPT, MPLBACKEND="pdf", PYTHONPATH=str(Path(shockpc.__file__).parents[1]))
    assert (plain.returncode, changed.returncode) == (0, 0), changed.stderr
    assert changed.stdout == plain.stdout
    assert plain.stdout.endswith(" False\n")


WATCHED = """
import os, sys
import numpy  # which itself sets a variable for a moment
seen = []
sys.addaudithook(lambda event, _: seen.append(event) if event in ("os.chdir", "os.putenv", "os.unsetenv") else None)
before = os.getcwd(), dict(os.environ)
import shockpc.show.figure
assert (os.getcwd(), dict(os.environ)) == before
print(seen)
import matplotlib
print(matplotlib.get_backend(), matplotlib.rcParams["font.size"])
"""


def test_importing_figures_changes_neither_folder_nor_environment(tmp_path, monkeypatch):
    """Not even for a moment, in which other threads would see it; and the user's settings hold for
    the user's figures.
    """
    (tmp_path / "matplotlibrc").write_text("font.size: 40\n")
    monkeypatch.chdir(tmp_path)
    folders = {"MPLCONFIGDIR": str(tmp_path), "PYTHONPATH": str(Path(shockpc.__file__).parents[1])}
    outcome = python(WATCHED, MPLBACKEND="pdf", **folders)
    assert outcome.returncode == 0, outcome.stderr
    assert outcome.stdout.splitlines() == ["[]", "pdf 40.0"]


@pytest.mark.slow
def test_settings_that_matplotlib_refuses_are_named(tmp_path, monkeypatch):
    """A file that is no text is an error of one line; a backend, which no figure needs, is none of
    a command.
    """
    monkeypatch.chdir(tmp_path)
    command = (
        "from shockpc.cli.entry import entry; import sys; sys.argv[1:] = 'analyze beam --contact "
        "tip --out o'.split(); entry()"
    )
    path = {"PYTHONPATH": str(Path(shockpc.__file__).parents[1])}
    assert python(command, MPLBACKEND="no-such-backend", **path).returncode == 0
    (tmp_path / "matplotlibrc").write_bytes(b"font.size: 40\n\xff")
    refused = python(command, **path)
    assert (refused.returncode, refused.stderr.count("\n")) == (2, 1)
    assert "matplotlibrc" in refused.stderr
