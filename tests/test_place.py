"""The place of smallest shock: cone programs against closed forms and fine grids; the command."""

import dataclasses
import itertools
import json
import math
import re
import sys

import numpy as np
import pytest
from commands import STICK, good, run

import shockpc
from shockpc.robot.load import load_robot
from shockpc.robot.shapes.convex import facets, half_spaces
from shockpc.robot.shapes.geometry import outline
from shockpc.studies.place.best_first import best_places, box_faces, first_bounds
from shockpc.studies.place.cone import ConvexCell, least_shock
from shockpc.studies.place.field import fields_of

TOLERANCE = 1e-8
"""Of values near 1: the accuracy asked of the solver is 1e-11, and its gap is checked."""


def fields(seed, landings=4, limit=None):
    """Random jumps: screw axes pass the origin at about 0.3 m."""
    rng = np.random.default_rng(seed)
    found = fields_of(
        rng.normal(size=(landings, 3)),
        0.3 * rng.normal(size=(landings, 3)),
        rng.uniform(0.5, 2.0, landings),
    )
    return found._replace(limit=limit)


def corners(low, high):
    return np.array(list(itertools.product(*zip(low, high, strict=True))), dtype=float)


def lattice(low, high, n):
    """Points of a box on a grid, and the largest distance of any point of the box from one of them."""
    steps = [np.linspace(a, b, n) for a, b in zip(low, high, strict=True)]
    spacing = np.array([s[1] - s[0] for s in steps])
    return np.stack(np.meshgrid(*steps), axis=-1).reshape(-1, 3), float(
        np.linalg.norm(spacing)
    ) / 2.0


def slope(found):
    """How much the shock can change over a metre."""
    return float(np.linalg.norm(found.A, axis=(1, 2), ord=2).max())


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("limit", [None, 10.0, 0.9])
def test_the_least_shock_in_a_box_is_that_of_a_fine_grid(seed, limit):
    """The largest, or the mean of those that have a limit."""
    low, high = np.array([-0.2, -0.1, 0.05]), np.array([0.3, 0.2, 0.4])
    found = fields(seed, 5, limit)
    optimum = least_shock(found, ConvexCell(corners(low, high)))
    points, reach = lattice(low, high, 60)
    allowed = found.shocks(points).max(axis=1) <= (limit or np.inf)
    brute = float(found.at(points[allowed]).min())
    assert optimum.value <= brute + TOLERANCE
    assert brute <= optimum.value + slope(found) * reach
    assert optimum.bound <= optimum.value <= optimum.bound + TOLERANCE
    assert np.all(optimum.point >= low - TOLERANCE)
    assert np.all(optimum.point <= high + TOLERANCE)
    assert float(found.at(optimum.point[None])[0]) == pytest.approx(optimum.value, abs=1e-15)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("shape", ["capsule", "cylinder"])
def test_the_least_shock_in_a_rounded_hull_cut_by_a_plane_is_that_of_a_fine_grid(seed, shape):
    ends, radius = np.array([[-0.1, 0.0, 0.0], [0.2, 0.1, 0.0]]), 0.08
    found, normal = fields(seed, 3), np.array([0.0, 0.6, 0.8])
    length = float(np.linalg.norm(ends[1] - ends[0]))
    axis = (ends[1] - ends[0]) / length
    rounding = radius * (np.eye(3) - (shape == "cylinder") * np.outer(axis, axis))
    optimum = least_shock(found, ConvexCell(ends, rounding).within(normal, 0.02))
    points, reach = lattice([-0.2, -0.1, -0.1], [0.3, 0.2, 0.1], 70)
    height = (points - ends[0]) @ axis
    along = np.clip(height, 0.0, length)
    inside = np.linalg.norm(points - ends[0] - along[:, None] * axis, axis=1) <= radius
    inside &= (shape == "capsule") | (height == along)
    brute = float(found.at(points[inside & (points @ normal >= 0.02)]).min())
    # The grid may miss the rim of the set by more than its reach, where the plane meets the ball at
    # a small angle.
    assert optimum.value <= brute + TOLERANCE
    assert brute <= optimum.value + 3.0 * slope(found) * reach
    assert optimum.value <= optimum.bound + TOLERANCE
    assert optimum.point @ normal >= 0.02 - TOLERANCE


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("limit", [None, 10.0])
def test_the_first_bound_of_a_rounded_cell_is_below_the_shock_everywhere_in_it(seed, limit):
    """Brute force over balls, ellipsoids and capsules: a hull alone has a smaller part of them, and
    so a bound that is too high.
    """
    found, rng = fields(seed, 4, limit), np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    ends, middle = rng.uniform(-0.2, 0.2, (2, 3)), rng.uniform(-0.2, 0.2, (1, 3))
    cells = [
        ConvexCell(middle, 0.05 * np.eye(3)),
        ConvexCell(middle, axes * (0.02, 0.05, 0.1)),
        ConvexCell(ends, 0.03 * np.eye(3)),
    ]
    directions = rng.normal(size=(4000, 3))
    sphere = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    for cell, bound in zip(cells, first_bounds(found, cells), strict=True):
        points = (cell.points[:, None] + sphere @ cell.rounding.T).reshape(-1, 3)
        least = float(found.at(points).min())
        assert least - 2.0 * slope(found) * 0.2 <= bound <= least


def test_with_one_landing_the_best_place_is_on_the_screw_axis():
    """The smallest shock of one landing is |ω · v| / |ω|, on the axis; in a ball beside it, it
    grows with the distance.
    """
    omega, v = np.array([0.3, 2.0, -0.4]), np.array([0.5, 0.1, -0.2])
    found = fields_of(omega[None], v[None], np.array([2.0]))
    axis = np.cross(omega, v) / (omega @ omega)
    along = abs(omega @ v) / np.linalg.norm(omega) / 2.0
    optimum = least_shock(found, ConvexCell(corners(axis - 1.0, axis + 1.0)))
    assert optimum.value == pytest.approx(along, abs=TOLERANCE)
    aside = np.cross(omega, [1.0, 0.0, 0.0])
    aside /= np.linalg.norm(aside)
    optimum = least_shock(found, ConvexCell((axis + 0.5 * aside)[None], 0.2 * np.eye(3)))
    assert optimum.value == pytest.approx(
        math.hypot(along, 0.3 * np.linalg.norm(omega) / 2.0), abs=TOLERANCE
    )
    # the value is quadratic across the radius
    np.testing.assert_allclose(optimum.point, axis + 0.3 * aside, atol=1e-5)


def test_a_body_that_translates_sees_the_same_everywhere():
    found = fields_of(np.zeros((1, 3)), np.array([[0.0, 0.0, 0.5]]), np.ones(1))
    optimum = least_shock(found, ConvexCell(corners([0, 0, 0], [1, 1, 1])))
    assert (optimum.value, optimum.bound) == pytest.approx((0.5, 0.5), abs=TOLERANCE)


@pytest.mark.parametrize("limit", [None, 10.0])
def test_tangents_are_never_above_the_shock(limit):
    found = fields(3, 30, limit)
    at, points = np.random.default_rng(0).normal(size=(2, 200, 3))
    values, slopes = found.tangents(at)
    assert np.all(values + np.sum((points - at) * slopes, axis=1) <= found.at(points) + 1e-12)


def test_many_landings_give_the_optimum_of_all_of_them():
    """Only landings that decide are in a program; the value and the bound hold for all."""
    found, cell = fields(5, 400), ConvexCell(corners([-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]))
    optimum = least_shock(found, cell)
    nearby, reach = lattice(optimum.point - 0.05, optimum.point + 0.05, 30)
    assert optimum.value <= optimum.bound + TOLERANCE
    assert float(found.at(nearby).min()) == pytest.approx(optimum.value, abs=slope(found) * reach)


BOXES = (([-0.3, -0.2, -0.1], [0.2, 0.2, 0.1]), ([0.0, -0.1, -0.2], [0.5, 0.1, 0.3]))


@pytest.mark.parametrize("seed", range(2))
def test_the_best_place_of_a_union_is_in_its_best_piece(seed):
    found, cells = fields(seed), [ConvexCell(corners(*one)) for one in BOXES]
    best = next(best_places(found, cells))
    assert best.value == pytest.approx(
        min(least_shock(found, cell).value for cell in cells), abs=TOLERANCE
    )


@pytest.mark.parametrize("seed", range(2))
def test_the_best_place_on_a_surface_is_that_of_a_fine_grid_on_it(seed):
    """Two boxes that overlap: what of one lies inside the other is not surface."""
    found = fields(seed)
    faces = [
        ConvexCell(
            corners(np.where(np.arange(3) == k, side, low), np.where(np.arange(3) == k, side, high))
        )
        for low, high in BOXES
        for k in range(3)
        for side in (low[k], high[k])
    ]
    best = next(
        best_places(found, faces, [box_faces(np.array(low), np.array(high)) for low, high in BOXES])
    )
    brute, reach = np.inf, 0.0
    for low, high in BOXES:
        for k, end in itertools.product(range(3), (0, 1)):
            points, near = lattice(low, high, 41)
            points = (
                points[points[:, k] == points[:, k].max()]
                if end
                else points[points[:, k] == points[:, k].min()]
            )
            hidden = [
                np.all((points > np.array(a) + 1e-9) & (points < np.array(b) - 1e-9), axis=1)
                for a, b in BOXES
            ]
            brute, reach = (
                min(brute, float(found.at(points[~np.any(hidden, axis=0)]).min())),
                max(reach, near),
            )
    assert best.value <= brute + TOLERANCE
    assert brute <= best.value + 2.0 * slope(found) * reach
    assert best.value <= best.bound + TOLERANCE


@pytest.mark.parametrize("seed", range(2))
def test_alternatives_are_the_best_places_of_a_fine_grid_at_the_distance(seed):
    found, apart = fields(seed), 0.11
    cells = [ConvexCell(corners(*one)) for one in BOXES]
    ranked = list(itertools.islice(best_places(found, cells, (), apart), 4))
    grids = [lattice(low, high, 50) for low, high in BOXES]
    points, reach = np.concatenate([points for points, _ in grids]), max(near for _, near in grids)
    for k, one in enumerate(ranked):
        far = (
            np.all(
                [np.abs(points - before.point).max(axis=1) >= apart for before in ranked[:k]],
                axis=0,
            )
            if k
            else slice(None)
        )
        assert one.value <= float(found.at(points[far]).min()) + TOLERANCE
        assert float(found.at(points[far]).min()) <= one.value + 2.0 * slope(found) * reach
        assert one.value <= one.bound + TOLERANCE
        assert all(np.abs(one.point - before.point).max() >= apart - 1e-6 for before in ranked[:k])
    assert [one.value for one in ranked] == sorted(one.value for one in ranked)


def test_facets_of_a_shape_are_the_surface_of_its_half_spaces():
    """Corners of every facet lie on a face, and inside of all others."""
    shapes = outline(load_robot("anymal_b"), "collision").shapes[0]
    assert shapes
    for shape in shapes:
        solid = half_spaces(shape)
        for corner in np.concatenate(facets(shape)):
            assert solid.depth(corner) == pytest.approx(0.0, abs=1e-9)
        assert solid.depth(shape.points.mean(axis=0)) > 1e-4


def landings(robot="anymal_b", feet=("LF_FOOT", "RH_FOOT"), angles=(0.0, 45.0), **more):
    return {
        f"{foot} {angle:g}": shockpc.Scene(
            robot=robot, contact=foot, strike=shockpc.Strike(strike_angle_deg=angle), **more
        )
        for foot in feet
        for angle in angles
    }


@pytest.fixture(scope="module")
def study():
    return shockpc.place(landings(pulse="half-sine:5ms", range_g=2.0))


def test_contacts_that_vary_are_those_of_one_landing_each():
    """Whatever the contacts were that they replace, each is computed once and named once."""
    feet = {foot: shockpc.Scene(robot="anymal_b", contact=foot) for foot in ("LF_FOOT", "RH_FOOT")}
    vary = {"contact": "LF_FOOT,RF_FOOT", "strike-angle": (0.0, 30.0)}
    names = [
        f"contact={foot} strike-angle={angle}"
        for foot in ("LF_FOOT", "RF_FOOT")
        for angle in (0, 30)
    ]
    study = shockpc.place(feet, vary=vary, alternatives=0)
    assert list(study.landings) == names
    single = {
        "contact=LF_FOOT": feet["LF_FOOT"],
        "contact=RF_FOOT": shockpc.Scene(robot="anymal_b", contact="RF_FOOT"),
    }
    again = shockpc.place(single, vary={"strike-angle": (0.0, 30.0)}, alternatives=0)
    assert (list(again.landings), again.places[0].shocks.tolist()) == (
        names,
        study.places[0].shocks.tolist(),
    )
    posture = shockpc.place(
        {"crouched": feet["LF_FOOT"]}, vary={"contact": "RF_FOOT"}, alternatives=0
    )
    assert list(posture.landings) == ["crouched contact=RF_FOOT"]


def test_the_numbers_of_a_place_are_those_of_single_analyses(study):
    """Each shock is the proven one of an analysis with that point, to the last digit."""
    for one in (*study.today, *study.places):
        point = shockpc.Point(frame="base", offset=tuple(one.position))
        for k, scene in enumerate(landings().values()):
            profile = shockpc.shock_profile(shockpc.Scene(**{**vars(scene), "point": (point,)}))
            assert one.shocks[k] == profile.points[-1].shock
        assert one.combined == one.shocks.max()


def test_the_best_place_is_better_than_any_point_of_the_body(study):
    points = np.concatenate(
        [
            lattice(s.points.min(axis=0), s.points.max(axis=0), 20)[0]
            for s in outline(study.robot, "collision").shapes[0]
        ]
    )
    inside = [
        s.depth(p) >= 0.0
        for s in map(half_spaces, outline(study.robot, "collision").shapes[0])
        for p in points[::7]
    ]
    assert any(inside)
    within = np.array(inside).reshape(-1, len(points[::7])).any(axis=0)
    assert study.combined <= study.fields.at(points[::7][within]).min()
    assert study.combined < study.today[0].combined
    assert study.complete
    assert study.gap < TOLERANCE


def test_margins_are_peaks_of_the_pulse_along_the_axes(study):
    """π Δv / 2T for a half-sine, and the share of the range that they leave."""
    one = study.places[0]
    peaks = math.pi * np.abs(one.delta_v).max(axis=0) / (2.0 * 5e-3) / 9.80665
    np.testing.assert_allclose(one.margin.peak_g, peaks, rtol=1e-12)
    np.testing.assert_allclose(one.margin.left, 1.0 - peaks / 2.0, rtol=1e-12)
    behind = shockpc.place(
        {"one": shockpc.Scene(robot="anymal_b", contact="LF_FOOT", imu_bandwidth="200Hz")}
    ).places[0]
    np.testing.assert_allclose(
        behind.margin.peak_g,
        400.0 * math.pi * np.abs(behind.delta_v).max(axis=0) / 9.80665,
        rtol=1e-12,
    )


def test_a_box_replaces_the_geometry_and_limits_the_surface(tmp_path):
    box_ = ((0.1, -0.05, 0.0), (0.2, 0.05, 0.1))
    body = '<link name="body"><collision><geometry><box size="0.4 0.3 0.2"/></geometry></collision>'
    (tmp_path / "stick.urdf").write_text(STICK.replace('<link name="body">', body))
    few = landings(str(tmp_path / "stick.urdf"), ("foot",))
    inside = shockpc.place(few, within=box_, alternatives=0)
    assert np.all(inside.places[0].position >= np.array(box_[0]) - 1e-8)
    assert np.all(inside.places[0].position <= np.array(box_[1]) + 1e-8)
    low, high = (-0.3, -0.3, 0.0), (0.3, 0.3, 0.3)
    above = shockpc.place(few, within=(low, high), surface=True, alternatives=0)
    anywhere = shockpc.place(few, surface=True, alternatives=0)
    assert above.places[0].position[2] >= -1e-8
    with pytest.raises(shockpc.ShockError, match="no place on the surface"):
        shockpc.place(few, within=((0.0, 0.0, 0.05), (0.01, 0.01, 0.06)), surface=True)
    assert above.combined >= anywhere.combined - TOLERANCE
    assert anywhere.combined >= shockpc.place(few, alternatives=0).combined - TOLERANCE


def test_a_surface_is_what_one_sees():
    """Where the body has a visual geometry, as Go2's, whose solid is that for collisions."""
    scenes = {"FL": shockpc.Scene(robot="go2", contact="FL_foot")}
    on, within = (
        shockpc.place(scenes, surface=surface, alternatives=0) for surface in (True, False)
    )
    assert "on the surface of the visual geometry of base" in on.region.text
    assert "inside the collision geometry of base" in within.region.text
    visible = outline(on.robot, "visual").shapes[0]
    a, b, c = np.concatenate([np.array(facets(shape)) for shape in visible]).swapaxes(0, 1)
    edges, offset = np.stack([b - a, c - a], axis=-1), on.places[0].position - a
    share = np.linalg.pinv(edges) @ offset[..., None]
    inside = (share >= -1e-6).all(axis=(1, 2)) & (share.sum(axis=(1, 2)) <= 1.0 + 1e-6)
    assert np.linalg.norm(offset - (edges @ share)[..., 0], axis=1)[inside].min() < 1e-7


ONE = landings(feet=("LF_FOOT",), angles=(45.0,))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"body": "bse"}, ['no body "bse"', '"base"']),
        ({"within": ((1.0, 1.0, 1.0), (2.0, 2.0, 2.0))}, ["outside base", "x -0.2"]),
        ({"within": ((0.1, 0.0, 0.0), (0.0, 1.0, 1.0))}, ["no x between 0.1 and 0"]),
        (
            {"within": ((-1e308, 0.0, 0.0), (1e308, 1.0, 1.0))},
            ["within must be ≥ -1e+06 and ≤ 1e+06 m"],
        ),
        ({"alternatives": 100}, ["≤ 20"]),
    ],
)
def test_what_cannot_be_placed_is_refused_with_what_would_be_valid(more, words):
    with pytest.raises(shockpc.ShockError) as refusal:
        shockpc.place(ONE, **more)
    assert all(word in str(refusal.value) for word in words), str(refusal.value)


def test_scenes_have_to_be_of_one_robot():
    with pytest.raises(shockpc.StudyError, match="different robots"):
        shockpc.place(landings() | {"other": shockpc.Scene(robot="hyq", contact="lf_foot")})
    with pytest.raises(shockpc.StudyError, match="no landing"):
        shockpc.place({})


def test_a_landing_that_cannot_be_computed_is_named_with_its_reason(capfd):
    """The others are computed; with --strict exit code 3 says that some are missing, and 2 that
    none was computed.
    """
    words = ("place", "anymal_b", "--contact", "LF_FOOT", "--vary", "strike-angle=0,100")
    found = run(capfd, *words)
    assert (found.code, run(capfd, *words, "--strict").code) == (0, 3)
    assert "not computed: LF_FOOT strike-angle=100: contact" in found.out
    assert run(capfd, "place", "anymal_b", "--vary", "strike-angle=100").code == 2


def test_the_table_names_the_gain_and_the_gap(capfd):
    text = good(capfd, "place", "anymal_b")
    assert re.search(r"landings +9: .*4 edges.*single feet", text)
    assert re.search(
        r"imu_link sees 0\.0487; the best place, at \(.*\) m, sees 0\.0468, a factor of 1\.04", text
    )
    assert re.search(r"optimum: .*\(9 convex pieces\) is below 0\.0463\d+ \(gap", text)


def test_document_and_files(capfd, tmp_path):
    words = (
        "place",
        "anymal_b",
        "--contact",
        "LF_FOOT",
        "--vary",
        "strike-angle=0,30",
        "--pulse",
        "half-sine:5ms",
    )
    document = json.loads(good(capfd, *words, "--format", "json", "--out", tmp_path))
    assert document["schema"] == "shockpc.place/2"
    assert [one["landing"] for one in document["landings"]] == [
        "LF_FOOT strike-angle=0",
        "LF_FOOT strike-angle=30",
    ]
    assert document["combined"] == max(row["best"] for row in document["tables"]["landings"])
    assert document["tables"]["margins"][0].keys() == {"place", "peak_x", "peak_y", "peak_z"}
    assert {path.name for path in tmp_path.iterdir()} == {
        "landings.csv",
        "velocity_changes.csv",
        "margins.csv",
        "drives.csv",
        ".place.sha256",
        "place.json",
        "place.png",
        "place.svg",
        "places.csv",
        "report.html",
        "report.md",
    }
    assert json.loads((tmp_path / "place.json").read_text()) == document
    svg = (tmp_path / "place.svg").read_text()
    assert all(word in svg for word in ("imu_link", "2nd", "CoPc of a landing"))


def test_a_body_without_a_shape_is_drawn(capfd, tmp_path):
    """It has no geometry, and an inertia that no box has."""
    (tmp_path / "stick.urdf").write_text(STICK.replace('ixx="0.02"', 'ixx="20"'))
    words = (
        "place",
        tmp_path / "stick.urdf",
        "--contact",
        "foot",
        "--body",
        "body",
        "--within=-0.1:0.1,-0.1:0.1,0:0.1",
    )
    assert "the best place" in good(capfd, *words, "--out", tmp_path / "out")
    assert (tmp_path / "out" / "place.png").exists()


def test_scene_files_and_postures_on_the_command_line(capfd, tmp_path):
    scene = tmp_path / "jump.toml"
    scene.write_text('robot = "anymal_b"\n[[contact]]\nframe = "LF_FOOT"\n')
    other = tmp_path / "fall.toml"
    other.write_text(
        'robot = "anymal_b"\n[strike]\ndrop_height = 0.3\n[[contact]]\nframe = "RH_FOOT"\n'
    )
    words = (
        "place",
        scene,
        other,
        "--vary",
        "*_KFE=-80:-60:2",
        "--format",
        "json",
        "--body",
        "imu_link",
    )
    document = json.loads(good(capfd, *words))
    names = [
        "jump LF_FOOT *_KFE=-80",
        "jump LF_FOOT *_KFE=-60",
        "fall RH_FOOT *_KFE=-80",
        "fall RH_FOOT *_KFE=-60",
    ]
    assert [one["landing"] for one in document["landings"]] == names


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--vary", "strike-angle=1:2"), "n values from a to b"),
        (("--vary", "nothing=1,2"), 'no joint or quantity "nothing"'),
        (("--within", "0:1,0:1"), "-0.1:0.1,-0.05:0.05,0:0.1"),
        (("--drop-height", "0.1", "--vary", "speed=1,2"), "leave that out"),
    ],
)
def test_wrong_options_are_refused_by_what_would_be_valid(capfd, words, message):
    found = run(capfd, "place", "anymal_b", *words)
    assert found.code == 2
    assert found.out == ""
    assert message in found.err


def test_without_clarabel_the_command_says_what_to_install(monkeypatch, capfd):
    monkeypatch.setitem(sys.modules, "clarabel", None)
    found = run(capfd, "place", "anymal_b")
    assert found.code == 2
    assert "pip install clarabel" in found.err


def test_with_friction_places_see_the_shock_of_contacts_that_slide():
    """The field over the body, the numbers at the places, and those of analyses with a point there
    are the same.
    """
    scene = shockpc.Scene(robot="go2", contact=(shockpc.Contact(frame="FL_foot"),), friction=0.2)
    found = shockpc.place(
        {"slides": scene, "sticks": dataclasses.replace(scene, friction=0.9)}, alternatives=0
    )
    (best,) = found.places
    np.testing.assert_allclose(found.fields.shocks(best.position), best.shocks, atol=1e-9)
    for friction, shock in zip((0.2, 0.9), best.shocks, strict=True):
        point = shockpc.Point(frame="base", offset=tuple(best.position))
        profile = shockpc.shock_profile(
            dataclasses.replace(scene, friction=friction, point=(point,))
        )
        assert profile.value("shock_friction", "point")[-1] == pytest.approx(shock, abs=1e-12)
    assert found.profiles[0].friction.state == ("slides",)
    assert abs(best.shocks[0] - found.profiles[0].shock_com[0]) > 1e-3


def test_the_best_place_is_given_at_both_ends_of_the_drives(capfd, tmp_path):
    """Nobody knows the drives of A1: the ends are free and locked joints, stated apart here, and
    the places are far apart.
    """
    study = shockpc.place("a1", alternatives=0)
    for end, model in (("smallest", "free"), ("largest", "locked")):
        stated = shockpc.place(shockpc.Scene(robot="a1", joints={"model": model}), alternatives=0)
        assert not stated.ends
        assert study.ends[end].combined == pytest.approx(stated.combined, rel=1e-9)
        np.testing.assert_allclose(
            study.ends[end].places[0].position, stated.places[0].position, atol=1e-5
        )
    apart = np.linalg.norm(
        study.ends["smallest"].places[0].position - study.ends["largest"].places[0].position
    )
    assert 0.1 < apart < 0.3
    assert study.kept is study.today[0], "all feet together: the trunk translates"
    text = good(capfd, "place", "a1", "--out", tmp_path)
    assert "keep imu_link, which sees 0.00355: no place is better by more than 1 %" in text
    assert re.search(
        r"drives: .*moves by 1\d cm, and its shock is 0\.00354 to 1$", text, flags=re.MULTILINE
    )
    document = json.loads((tmp_path / "place.json").read_text(encoding="utf-8"))
    assert document["keep"] == "imu_link"
    rows = document["tables"]["drives"]
    assert [row["drives"] for row in rows if row["place"] == "best"] == ["smallest", "largest"]
    assert not places_over_drives(
        good(capfd, "place", "a1", "--joints", "free", "--alternatives", "0")
    )


def places_over_drives(text):
    """Lines that say something of ends of drives."""
    return [
        line
        for line in text.splitlines()
        if line.startswith("drives:") or "largest inertias" in line
    ]
