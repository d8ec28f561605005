"""The figure: what is coloured how, what is written, and that the file is small and always the same."""

import re
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from shockpc.core.spatial import plane_from
from shockpc.errors import OutputError
from shockpc.model.contact import Contact
from shockpc.model.posture import Posture
from shockpc.profile import shock_profile
from shockpc.robot.geometry import Shape
from shockpc.robot.meshes import Mesh
from shockpc.scene import Scene, Strike
from shockpc.show.figure.bodies import layers
from shockpc.show.figure.field import Field, below, field_of
from shockpc.show.figure.landing import draw, save_figure
from shockpc.show.figure.palette import BANDS, EDGES, band
from shockpc.show.figure.silhouette import silhouette, to_plane
from shockpc.show.figure.view import view_of
from shockpc.show.tables.sheets import header_lines

SAGITTAL = plane_from((0.0, -1.0, 0.0))
BOX = (-1.0, -1.0, 1.0, 1.0)
HERE = np.zeros(3)


def landing(robot, *frames, angle=0.0, **scene):
    """A profile; every case is computed once."""
    return shock_profile(
        Scene(
            robot=robot, contact=tuple(Contact(frame=f) for f in frames), strike=Strike(speed=1.0, strike_angle_deg=angle), **scene
        )
    )


@pytest.fixture(scope="module")
def anymal():
    return landing("anymal_b", "LF_FOOT")


@pytest.fixture(scope="module")
def beam():
    return landing("beam", "tip")


def words(figure):
    """Everything written in a figure."""
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def shape(points, radius=0.0, triangles=None):
    """A shape in the plane's own axes: x forward, z up."""
    points = np.asarray(points, dtype=float)
    mesh = None if triangles is None else Mesh(points, np.asarray(triangles))
    return Shape("link", points, radius, mesh)


def shadow(*shapes, resolution=1e-3):
    return silhouette(shapes, np.eye(3), HERE, SAGITTAL, resolution)


# Silhouettes


def test_a_ball_casts_a_disc():
    """Area π r² and both extents 2 r, wherever it is."""
    disc = shadow(shape([[0.3, 0.1, -0.2]], 0.25))
    assert disc.area == pytest.approx(np.pi * 0.25**2, rel=2e-3)
    assert disc.bounds == pytest.approx((0.05, -0.45, 0.55, 0.05), abs=1e-3)


def test_a_capsule_casts_a_stadium():
    """Area 2 r l + π r²."""
    assert shadow(shape([[0, 0, 0], [0.6, 0, 0.8]], 0.1)).area == pytest.approx(0.2 + np.pi * 0.01, rel=5e-3)


def test_shapes_that_overlap_count_once():
    """Two boxes of 1 m² that share a quarter cover 1.75 m²."""
    square = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]], dtype=float)
    assert shadow(shape(square), shape(square + np.array([0.5, 0, 0.5]))).area == pytest.approx(1.75)


def ring(inner, outer, count):
    """Triangles of a flat ring, alternately turned over, which no reader of meshes would call closed."""
    turn = 2 * np.pi * np.arange(count) / count
    circle = np.stack([np.cos(turn), 0 * turn, np.sin(turn)], axis=1)
    k = np.arange(count)
    following = (k + 1) % count
    one = np.stack([k, following, k + count], axis=1)
    other = np.stack([following, k + count, following + count], axis=1)
    return np.concatenate([inner * circle, outer * circle]), np.concatenate([one, other])


@pytest.mark.parametrize("count", [8, 60, 20_000])
def test_a_mesh_keeps_its_hole(count):
    """A ring of triangles keeps its area and its hole, coarse or fine, though it is not closed and its triangles face both ways."""
    points, triangles = ring(0.5, 1.0, count)
    region = shadow(shape(points, triangles=triangles))
    polygon = 0.5 * count * np.sin(2 * np.pi / count)
    assert region.area == pytest.approx(0.75 * polygon, rel=5e-3)
    assert not region.contains(shapely.Point(0, 0))
    assert sum(len(part.interiors) for part in region.geoms) == 1


def area(corners):
    """Of a triangle x1 y1 x2 y2 x3 y3."""
    x1, y1, x2, y2, x3, y3 = corners
    return abs((x2 - x1) * (y3 - y1) - (x3 - x1) * (y2 - y1)) / 2


@given(st.lists(st.tuples(*[st.floats(-1, 1)] * 6).filter(lambda corners: area(corners) > 1e-3), min_size=1, max_size=12))
def test_a_mesh_casts_the_union_of_its_triangles(corners):
    """Any soup of triangles: its shadow differs from the exact union by no more than the resolution along its edges."""
    flat = np.array(corners).reshape(-1, 2)
    points = np.stack([flat[:, 0], 0 * flat[:, 0], flat[:, 1]], axis=1)
    triangles = np.arange(len(points)).reshape(-1, 3)
    exact = shapely.union_all(shapely.polygons(flat[triangles]))
    found = shadow(shape(points, triangles=triangles), resolution=4e-3)
    assert found.difference(exact.buffer(6e-3)).area == pytest.approx(0.0, abs=1e-4)
    assert exact.buffer(-6e-3).difference(found).area == pytest.approx(0.0, abs=1e-9)


def test_a_fine_mesh_is_quick():
    """A hundred thousand triangles take a fraction of a second."""
    points, triangles = ring(0.5, 1.0, 50_000)
    start = time.perf_counter()
    shadow(shape(points, triangles=triangles), resolution=2e-3)
    assert time.perf_counter() - start < 1.0


def test_a_plate_seen_edge_on_is_still_seen():
    """Without width there would be nothing to colour."""
    assert shadow(shape([[0, 0, 0], [1, 0, 0], [0, 1, 0]])).area > 0.0


# Colours

SPEEDS = st.tuples(*[st.floats(-3, 3)] * 3).map(np.array)
SPINS = st.one_of(
    SPEEDS,
    st.floats(-5, 5).map(lambda w: np.array([0.0, w, 0.0])),
    SPEEDS.map(lambda w: w * [1, 0, 1]),
    SPEEDS.map(lambda w: 1e-7 * w),
    st.just(np.zeros(3)),
)


def field(omega, v):
    """The field of a body at the origin, in the sagittal plane, for a strike of 1 m/s."""
    profile = SimpleNamespace(
        rotation=[np.eye(3)], plane=SAGITTAL, delta_omega=[omega], delta_v=[v], v_in=1.0, position=np.zeros((1, 3))
    )
    return field_of(profile, 0)


@given(SPINS, SPEEDS)
def test_the_field_is_that_of_the_body(omega, v):
    """|Δv + Δω × r| at points of the plane."""
    r = np.array([0.3, 0.0, -0.7])
    assert field(omega, v).at(np.array([0.3, -0.7])) == pytest.approx(np.linalg.norm(v + np.cross(omega, r)), abs=1e-12)


@given(SPINS, SPEEDS)
def test_a_leaning_limb_is_coloured_along_itself(omega, v):
    """Where a body leans across the plane, its colours are the shocks of its own points, not of those at the depth of its frame."""
    along = np.array([0.2, 0.5, -1.0])
    limb = np.linspace(0.0, 1.0, 20)[:, None] * along + [0.1, 0.3, 0.0]
    profile = SimpleNamespace(
        rotation=[np.eye(3)], plane=SAGITTAL, delta_omega=[omega], delta_v=[v], v_in=1.0, position=np.zeros((1, 3))
    )
    found = field_of(profile, 0, limb).at(to_plane(limb, SAGITTAL))
    # The slope is held back by a hundredth of the limb's own spread.
    slack = 0.02 * np.linalg.norm(omega)
    np.testing.assert_allclose(found, np.linalg.norm(v + np.cross(omega, limb), axis=1), atol=slack + 1e-12)


@pytest.mark.parametrize("plane", ["xz", "yz", (1.0, 1.0, 0.2)])
@pytest.mark.parametrize(("robot", "frame"), [("anymal_b", "LF_FOOT"), ("hyq", "lf_foot"), ("talos", "left_sole_link")])
def test_the_struck_point_has_the_colour_of_the_strike(robot, frame, plane):
    """Shock is 1 where the robot is struck, in whatever plane it is drawn."""
    profile = landing(robot, frame, plane=plane)
    drawn = next(d for d in view_of(profile).drawn if d.body == profile.robot.frame(frame).body)
    assert drawn.field.at(to_plane(profile.contacts[0].point, profile.plane)) == pytest.approx(1.0, abs=0.08)


@given(SPINS, SPEEDS, st.sampled_from(EDGES[1:-1]))
def test_below_a_value_is_where_the_field_is_below(omega, v, value):
    """Points of the box are inside just where shock is smaller, but for the width of a chord of the sampled arc."""
    found, f = below(field(omega, v), value, BOX), field(omega, v)
    grid = np.stack(np.meshgrid(np.linspace(-0.99, 0.99, 21), np.linspace(-0.99, 0.99, 21)), axis=-1).reshape(-1, 2)
    inside = shapely.contains_xy(found, *grid.T)
    shock = f.at(grid)
    slope = np.linalg.norm(f.A, 2)
    slack = 2e-3 * slope + 1e-6
    assert not np.any(inside & (shock > value + slack))
    assert not np.any(~inside & (shock < value - slack))


@given(SPINS, SPEEDS)
def test_every_band_holds_its_shocks(omega, v):
    """Points drawn from what stays visible of each band have shock within the band's edges, and the bands leave nothing out."""
    f, region = field(omega, v), shapely.MultiPolygon([shapely.box(*BOX)])
    painted = layers(region, f)
    assert painted[0][1].area == pytest.approx(region.area)
    slack = 2e-3 * np.linalg.norm(f.A, 2) + 1e-6
    for n, (k, part) in enumerate(painted):
        seen = part if n + 1 == len(painted) else part.difference(painted[n + 1][1])
        for piece in shapely.get_parts(seen):
            shock = f.at(shapely.get_coordinates(piece.representative_point())[0])
            assert EDGES[k] - slack <= shock <= EDGES[k + 1] + slack


def test_the_break_at_1_is_the_circle_of_percussion():
    """In the plane the border between blue and red lies at r_p from the CoPc."""
    f = field(np.array([0.0, 2.0, 0.0]), np.array([0.0, 0.0, 0.6]))  # CoPc at x = 0.3, r_p = 0.5
    border = shapely.get_coordinates(below(f, 1.0, (-2.0, -2.0, 2.0, 2.0)))
    np.testing.assert_allclose(np.hypot(border[:, 0] - 0.3, border[:, 1]), 0.5, rtol=1e-12)


def test_nothing_is_clipped():
    """Shock far above 1 has a colour of its own, darker than all others."""
    assert EDGES.index(1.0) < len(BANDS) - 1
    assert [band(s) for s in (0.0, 0.1, 1.0, 1.0001, 2.0, 2.01, 1e9)] == [0, 0, 4, 5, 7, 8, 8]
    (k, part), *_ = layers(shapely.MultiPolygon([shapely.box(*BOX)]), Field(np.zeros(2), np.array([50.0, 0, 0]), np.zeros((3, 2))))
    assert (k, part.area) == (len(BANDS) - 1, pytest.approx(4.0))


def lightness(colour, blindness=None):
    """L* of a colour, and its chroma a*, b*, as seen by an eye of that kind (Machado and others, 2009, severity 1)."""
    channels = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    seen = {
        None: np.eye(3),
        "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
        "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    }[blindness]
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = to_xyz @ np.clip(np.array(seen) @ linear, 0, 1) / [0.9505, 1.0, 1.089]
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("blindness", [None, "protan", "deutan", "tritan"])
def test_every_eye_can_order_the_bands(blindness):
    """From band to band lightness falls by at least 5 L*, so grey paper keeps the order, and no two neighbours look alike."""
    seen = np.array([lightness(colour, blindness) for colour in BANDS])
    assert np.all(np.diff(seen[:, 0]) < -5.0)
    assert np.all(np.linalg.norm(np.diff(seen, axis=0), axis=1) > 8.0)


def test_the_break_at_1_is_the_greatest():
    """Blue turns to red there, for the colour-blind too."""
    for blindness in (None, "protan", "deutan"):
        steps = np.linalg.norm(np.diff([lightness(colour, blindness) for colour in BANDS], axis=0), axis=1)
        assert np.argmax(steps) == EDGES.index(1.0) - 1


# The whole figure


def test_the_title_states_robot_posture_strike_and_joint_model(anymal):
    """What was computed can be read off the picture, with units."""
    written = words(draw(anymal))
    assert "anymal_b: shock of landing on LF_FOOT" in written
    assert "posture standing; strike 1 m/s, straight down" in written
    assert "joint model: free (zero reflected inertia); plane xz, x to the right, z up" in written
    assert "normalised shock |Δv| / v_in [-]; 1 is the strike itself" in written
    assert {"0.1", "1", "> 2", "0.1 m", "imu_link", "LF_SHANK", "0.44 m"} <= set(written)


def test_what_bears_on_the_numbers_is_said():
    """A turned base, joints set, an oblique strike, bounce and slip stand in the title."""
    scene = Scene(
        robot="leg",
        base="planar",
        posture=Posture(base_rpy_deg=(0.0, -15.0, 0.0), joints_deg={"knee": -20.0}),
        strike=Strike(speed=2.0, strike_angle_deg=30.0),
        contact=(Contact(frame="heel", directions=("z",), restitution=0.5),),
    )
    line = next(text for text in words(draw(shock_profile(scene))) if text.startswith("posture"))
    posture, strike = line.split("; ")
    assert posture.endswith("1 joint set, base pitch −15°, base moves in the plane only")
    assert strike == "strike 2 m/s, 30° from the vertical, restitution 0.5, free to slide"


def test_the_figure_tells_the_strike_of_the_report():
    """With a robot that turns, one speed and one angle in both: those of the contact's velocity."""
    strike = Strike(angular_velocity=(0.0, 5.0, 0.0))
    profile = shock_profile(Scene(robot="anymal_b", contact=(Contact(frame="LF_FOOT"),), strike=strike))
    x, _, z = profile.strike
    angle = f"{np.degrees(np.arctan2(x, -z)):.4g}"
    assert angle == "-40.06"
    assert dict(header_lines(profile))["strike"].startswith(
        f"3.723 m/s, {angle} deg from the vertical: velocity (-2.396, 0, -2.85)"
    )
    assert "posture standing; strike 3.72 m/s, −40.06° from the vertical, turning at (0, 5, 0) rad/s" in words(draw(profile))


def test_every_contact_has_an_arrow_of_its_own_velocity():
    """A robot that pitches forward comes down faster in front than behind, and the lengths of the arrows are as the speeds."""
    strike = Strike(angular_velocity=(0.0, 1.0, 0.0))
    contacts = (Contact(frame="LF_FOOT"), Contact(frame="LH_FOOT"))
    profile = shock_profile(Scene(robot="anymal_b", contact=contacts, strike=strike))
    picture = draw(profile).axes[1]
    lines = [np.subtract(*patch._posA_posB[::-1]) for patch in picture.patches if getattr(patch, "_posA_posB", None)]
    arrows = np.array([line for line in lines if np.linalg.norm(line) > 0.0])
    for contact in profile.contacts:
        along = to_plane(contact.approach, profile.plane)
        share = np.linalg.norm(along) / np.linalg.norm(profile.strike)
        length = share * max(np.linalg.norm(arrows, axis=1))
        assert any(np.allclose(arrow, along / np.linalg.norm(along) * length, atol=1e-9) for arrow in arrows)
    front, hind = (np.linalg.norm(contact.approach) for contact in profile.contacts)
    assert front > 1.5 * hind


def test_nearer_limbs_cover_farther_ones_but_not_the_struck_one(anymal):
    """Left legs are far in the sagittal picture, so the right fore leg, which hides the struck one, is drawn by its edge."""
    view = view_of(anymal)
    order = [anymal.bodies[drawn.body] for drawn in view.drawn]
    assert order.index("LH_SHANK") < order.index("base") < order.index("RH_SHANK")
    glass = {anymal.bodies[drawn.body] for drawn in view.drawn if drawn.glass}
    assert {"RF_THIGH", "RF_SHANK"} <= glass
    assert not any(name.startswith(("LF", "RH", "LH", "base")) for name in glass)
    assert [anymal.bodies[i] for i in view.struck] == ["base", "LF_HIP", "LF_THIGH", "LF_SHANK"]


def test_a_centre_outside_has_a_pointer_with_its_distance():
    """Struck near its middle, a beam turns about a point 1.7 m beyond its end: an arrow at the border says how far."""
    profile = shock_profile(Scene(robot="beam", contact=(Contact(frame="center", offset=(0.04, 0.0, 0.0)),)))
    figure = draw(profile)
    (label,) = [text for text in words(figure) if re.fullmatch(r"1: [\d.]+ m", text)]
    border = figure.axes[1].get_xlim()[0]
    centre = to_plane(profile.copc_world, profile.plane)[0, 0]
    assert centre < border
    assert float(label[3:-2]) == pytest.approx(border - centre, abs=0.03)
    assert "CoPc lies so far beyond the border" in words(figure)


def test_a_body_that_only_translates_has_no_centre():
    """Struck in the middle, the beam has one colour, no CoPc and no RoPc."""
    profile = landing("beam", "center")
    written = words(draw(profile))
    assert "none" in written
    assert not any("CoPc" in text for text in written)
    ((k, _),) = layers(view_of(profile).drawn[0].region, view_of(profile).drawn[0].field)
    assert k == 4


def test_a_robot_without_shapes_is_drawn_by_its_inertia(tmp_path):
    """The box of the inertia stands for what the file does not show, and the legend says so."""
    (tmp_path / "bare.urdf").write_text(
        '<robot name="bare"><link name="trunk"><inertial><mass value="3"/>'
        '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link></robot>'
    )
    profile = shock_profile(Scene(robot=str(tmp_path / "bare.urdf"), contact=(Contact(frame="trunk", offset=(0.2, 0.0, -0.2)),)))
    (drawn,) = view_of(profile).drawn
    assert drawn.box
    assert drawn.region.area == pytest.approx(6 * 0.1 / 3)
    assert "no shape in the file: box of its inertia" in words(draw(profile))


def test_motion_across_the_plane_is_told(anymal, beam):
    """Where a plane cannot show all of it, the figure says how much, and only there."""
    assert any("of the motion is across" in text for text in words(draw(anymal)))
    assert not any("is across" in text for text in words(draw(beam)))


def inside(figure):
    """Texts that leave the page, in pixels of the canvas."""
    figure.canvas.draw()
    width, height = figure.canvas.get_width_height()
    boxes = [(text.get_text(), text.get_window_extent()) for axes in figure.axes for text in axes.texts]
    return [name for name, b in boxes if b.x0 < 0 or b.y0 < 0 or b.x1 > width or b.y1 > height]


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
def test_no_letter_leaves_the_page(robot, frames, angle, plane):
    """Robots of every shape, in every plane."""
    assert inside(draw(landing(robot, *frames, angle=angle, plane=plane))) == []


def test_the_files_are_small_and_always_the_same(anymal, tmp_path):
    """ANYmal with its real meshes stays below 300 kB, and two runs write the same bytes: no dates, no random names."""
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        paths = save_figure(anymal, tmp_path / folder)
        assert [path.name for path in paths] == ["shock.svg", "shock.png"]
        assert sorted(path.name for path in (tmp_path / folder).iterdir()) == ["shock.png", "shock.svg"]
    for name in ("shock.svg", "shock.png"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    svg = (tmp_path / "one" / "shock.svg").read_text(encoding="utf-8")
    assert len(svg.encode()) < 300_000
    assert "<dc:date>" not in svg
    texts = "".join(ElementTree.fromstring(svg).itertext())
    assert "anymal_b: shock of landing on LF_FOOT" in texts


def test_a_folder_that_is_not_there_is_one_clear_error(beam, tmp_path):
    """Nothing half-written, and the error of the house."""
    with pytest.raises(OutputError):
        save_figure(beam, tmp_path / "missing")


def test_drawing_leaves_matplotlib_as_it_was(beam):
    """No pyplot, no settings changed."""
    import matplotlib

    before = dict(matplotlib.rcParams)
    draw(beam)
    assert dict(matplotlib.rcParams) == before
    script = "import sys, shockpc.show.figure.landing; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0
