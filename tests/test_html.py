"""report.html: its numbers are those of the analysis for every strike, and a browser draws it
without a network.
"""

import base64
import html
import importlib.util
import io
import json
import re
import shlex
import shutil
import subprocess
import tracemalloc
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from browser import CHROMIUM, Browser
from commands import STICK_WITH_IMU, good, run

import shockpc
from shockpc import Contact, Joints, Posture, Scene, SolveError, Strike, shock_profile
from shockpc.impact.landed import CONTRADICTION
from shockpc.robot.shapes.convex import Shape
from shockpc.robot.shapes.mesh import Mesh
from shockpc.show.folder import report_files
from shockpc.show.html.surfaces import surfaces
from shockpc.show.tables import Sheet
from shockpc.studies.analyze.report import analyze_report, landing_report

BROWSER = pytest.mark.skipif(
    CHROMIUM is None, reason="no Chromium is installed, which draws report.html"
)

MOVING = Scene(
    robot="stick.urdf",
    contact=Contact(frame="foot", restitution=0.3),
    strike=Strike(
        velocity=(0.2, 0.1, -1.5), angular_velocity=(0.1, 0.4, 0.0), joint_velocities={"knee": 0.7}
    ),
    joints=Joints(armature={"*": 0.01}),
    pulse="half-sine:5ms",
)
"""A landing whose jumps are not proportional to the velocity of the base."""


@pytest.fixture
def moving(here):
    (here / "stick.urdf").write_text(STICK_WITH_IMU)
    return shock_profile(MOVING)


class Page(HTMLParser):
    """The texts of a page by the element that they are in."""

    def __init__(self, text):
        super().__init__()
        self.texts, self._open = {}, ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self._open = dict(attrs).get("id") or tag

    def handle_endtag(self, tag):
        self._open = ""

    def handle_data(self, data):
        self.texts.setdefault(self._open, []).append(data)


def html_of(report):
    return report_files(report, "shockpc analyze")["report.html"]


def data_of(text):
    """What the script of a page computes from."""
    (found,) = Page(text).texts["data"]
    return json.loads(found)


def rotated(landing, angle, heading, speed):
    """The velocity that the page's controls mean [m/s]."""
    theta, psi = np.radians([angle, heading])
    forward, left, up = (np.array(landing[name]) for name in ("forward", "left", "up"))
    return speed * (
        np.sin(theta) * (np.cos(psi) * forward + np.sin(psi) * left) - np.cos(theta) * up
    )


@pytest.mark.parametrize("plane", ["xz", "yz", (1.0, 1.0, 0.0)])
@pytest.mark.slow
def test_data_give_the_shock_of_every_strike(moving, plane):
    """Δv = M s + a and the speed that normalises it are those of an analysis with that strike, also
    with moving joints.
    """
    profile = shock_profile(replace(MOVING, plane=plane), moving.robot)
    (landing,) = data_of(html_of(landing_report(profile)))["landings"]
    by_angle = Strike(speed=2.0, strike_angle_deg=25.0).vector(profile.plane)
    np.testing.assert_allclose(rotated(landing, 25.0, 0.0, 2.0), by_angle, atol=1e-12)
    s = rotated(landing, 25.0, 40.0, 2.0)
    other = shock_profile(
        replace(MOVING, plane=plane, strike=replace(MOVING.strike, velocity=tuple(s)))
    )
    for model, expected in (
        ("with drives", other.proof),
        ("free", other.proof_with("free")),
        ("locked", other.proof_with("locked")),
    ):
        columns = np.array(landing["models"][model]["jumps"])
        np.testing.assert_allclose(
            columns[..., :3] @ s + columns[..., 3], expected.jumps[..., 3], rtol=1e-12, atol=1e-13
        )
        assert landing["models"][model]["left"] == []
    (reference,) = landing["reference"]
    np.testing.assert_allclose(np.linalg.norm(reference["extra"] + s), other.v_in, rtol=1e-14)


def test_speed_of_the_centre_of_mass(moving):
    """With v_in = "com" the reference is the velocity of the centre of mass."""
    profile = shock_profile(replace(MOVING, v_in="com"))
    np.testing.assert_allclose(
        np.linalg.norm(profile.reference_velocities), profile.v_in, rtol=1e-15
    )
    assert profile.v_in != moving.v_in


def test_a_joint_model_without_a_solution_is_not_offered(here):
    """Locked joints of a robot on a fixed base leave nothing that the contact could move."""
    bent = Scene(robot="stick.urdf", contact=Contact(frame="foot", directions=("z",)), base="fixed")
    profile = shock_profile(replace(bent, posture=Posture(joints_deg={"knee": 30.0})))
    assert profile.proof_with("locked") is None
    (landing,) = data_of(html_of(landing_report(profile)))["landings"]
    assert landing["models"]["locked"] is None


def sphere(n):
    """A closed mesh of the unit sphere; its 20 triangles are divided n times."""
    import trimesh

    found = trimesh.creation.icosphere(subdivisions=n)
    return Shape(
        "a", found.vertices, mesh=Mesh(np.asarray(found.vertices), np.asarray(found.faces))
    )


def area(surface):
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0


def test_a_simplified_sphere_has_no_holes():
    """Every ray from the centre meets a triangle, near the sphere."""
    (surface,) = surfaces([[sphere(6)]], 4000)
    assert 1000 < len(surface.triangles) <= 4000
    np.testing.assert_allclose(area(surface), 4.0 * np.pi, rtol=0.02)
    corners = surface.vertices[surface.triangles].swapaxes(1, 2)
    rays = np.random.default_rng(0).normal(size=(500, 3))
    # At a point of the triangle the coordinates in its corners are positive, and their sum is the
    # inverse of the distance.
    shares = np.linalg.inv(corners) @ (rays / np.linalg.norm(rays, axis=1)[:, None]).T
    hit = (shares > -1e-9).all(axis=1)
    assert hit.any(axis=0).all()
    np.testing.assert_allclose(1.0 / shares.sum(axis=1)[hit], 1.0, atol=5e-3)


def test_a_box_keeps_its_area_and_has_short_edges():
    """Large triangles are divided and none is lost; a body without shapes has no triangles."""
    corners = np.array(np.meshgrid([-0.5, 0.5], [-0.3, 0.3], [-0.1, 0.1])).reshape(3, -1).T
    box, nothing = surfaces([[Shape("a", corners)], []], 100_000)
    assert len(nothing.triangles) == 0
    np.testing.assert_allclose(area(box), 2.0 * (0.6 + 0.2 + 0.12), rtol=1e-12)
    sides = box.vertices[box.triangles] - box.vertices[np.roll(box.triangles, -1, axis=1)]
    assert np.linalg.norm(sides, axis=2).max() <= 1.0 / 30.0


@pytest.mark.slow
def test_large_triangles_are_divided_up_to_a_number():
    """Ten thousand triangles as large as the robot would become millions; a body after them keeps
    its own.
    """
    corners = np.random.default_rng(0).normal(size=(30_000, 3))
    large = Shape("a", corners, mesh=Mesh(corners, np.arange(30_000).reshape(-1, 3)))
    tracemalloc.start()
    many, one = surfaces([[large], [sphere(1)]], 20_000)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(many.triangles) + len(one.triangles) <= 20_000
    assert len(one.triangles) > 0
    assert most < 3e8


def test_triangles_at_random_are_fewer_and_do_not_vanish():
    """They lie all around the origin, where the corner of a cell would part them however large it
    is.
    """
    corners = np.random.default_rng(0).uniform(-0.1, 0.1, (60_000, 3))
    soup = Shape("a", corners, mesh=Mesh(corners, np.arange(60_000).reshape(-1, 3)))
    (surface,) = surfaces([[soup]], 1000)
    assert 0 < len(surface.triangles) <= 1000


@pytest.mark.slow
@pytest.mark.parametrize(
    "failure", [MemoryError(), ValueError("Out of range float values are not JSON compliant")]
)
def test_a_page_that_cannot_be_made_is_a_warning(capfd, here, monkeypatch, failure):
    """The other files are written, and the results printed."""

    def fails(*_):
        raise failure

    good(capfd, "analyze", "stick.urdf", "--contact", "foot", "--out", "whole")
    monkeypatch.setattr("shockpc.show.html.landing_data.surfaces", fails)
    outcome = run(capfd, "analyze", "stick.urdf", "--contact", "foot", "--out", "out")
    assert outcome.code == 0
    reason = str(failure) or "the memory of this computer does not suffice"
    assert (outcome.err.count("\n"), "report.html" in outcome.err, reason in outcome.err) == (
        1,
        True,
        True,
    )
    whole, found = (
        {path.name for path in (here / folder).iterdir()} for folder in ("whole", "out")
    )
    assert whole - found == {"report.html"}


def test_page_of_several_landings(moving):
    """One page for all, the geometry of their robot once, the report of each landing apart."""
    other = shock_profile(replace(MOVING, strike=Strike()), moving.robot)
    text = html_of(analyze_report({"one": moving, "two": other}))
    data = data_of(text)
    assert [one["layout"]["uirevision"] for one in data["landings"]] == ["one", "two"]
    assert len(data["geometries"]) == 1
    assert text.count("<section data-landing=0>") == text.count("<section data-landing=1>") == 3


def test_page_holds_scene_and_command(capfd, here):
    """The scene can be copied from the page, and is read as the same scene, in which what was
    chosen is given.
    """
    good(capfd, "analyze", "stick.urdf", "--contact", "foot", "--set", "knee=-30", "--out", "out")
    page = Page((here / "out" / "report.html").read_text(encoding="utf-8"))
    scene, command = page.texts["pre"]
    assert command == "shockpc analyze stick.urdf --contact foot --set knee=-30"
    (here / "again.toml").write_text(scene, encoding="utf-8")
    again = good(capfd, "analyze", "again.toml")
    typed = good(
        capfd, "analyze", "stick.urdf", "--contact", "foot", "--set", "knee=-30"
    ).splitlines()
    assert again.splitlines() == [line for line in typed if not line.startswith("assumed ")]


def test_every_number_of_a_table_sorts(moving):
    """What the script sorts by is read by JavaScript, whether the number is of Python or of NumPy;
    shocks are of the latter.
    """
    values = re.findall(r'data-v="([^"]*)"', html_of(landing_report(moving)))
    assert len(values) > 20
    assert np.isfinite([float(value) for value in values]).all()


def test_without_plotly(capfd, here, monkeypatch):
    """Everything else is written, and one line says what is missing."""
    find = importlib.util.find_spec
    monkeypatch.setattr(
        "importlib.util.find_spec", lambda name: None if name == "plotly" else find(name)
    )
    outcome = run(capfd, "analyze", "stick.urdf", "--contact", "foot", "--out", "out")
    assert outcome.code == 0
    assert outcome.err == (
        "shockpc: report.html is not written, because it needs Plotly; install it with: pip "
        "install plotly\n"
    )
    assert (here / "out" / "shock.svg").exists()
    assert not (here / "out" / "report.html").exists()


WARNINGS = """const warnings = require(%s), fs = require("fs"), given = JSON.parse(fs.readFileSync(0, "utf-8"));
console.log(JSON.stringify({ below: warnings.below(given.landing, given.geometry, given.state, given.points),
  limits: warnings.limits(given.sliders), refused: warnings.refused(given.sliders) }));"""


@pytest.mark.skipif(shutil.which("node") is None, reason="no Node.js is installed")
@pytest.mark.parametrize(
    ("joints", "low", "limits", "refused"),
    [
        ({}, None, [], ""),
        ({"FL_thigh_joint": 60.0, "FL_calf_joint": -110.0}, "depth", [], ""),
        ({"FL_calf_joint": -20.0}, None, ["FL_calf_joint is 28 deg outside its limits"], ""),
        (
            {"FL_calf_joint": 500.0},
            "any",
            ["FL_calf_joint is 548 deg outside its limits"],
            "FL_calf_joint: 500 deg is outside its limits and more than a whole turn",
        ),
    ],
)
def test_the_page_warns_of_other_postures_as_the_command_does(joints, low, limits, refused):
    """Feet that are not the lowest, by the drawn surfaces, and joints beyond their limits; more
    than a whole turn is refused.
    """
    scene = Scene(robot="go2", contact="FL_foot")
    profile = shock_profile(scene)
    data = data_of(html_of(landing_report(profile)))
    (landing,), (geometry,) = data["landings"], data["geometries"]
    vertices = np.frombuffer(base64.b64decode(geometry["vertices"]), "<f4").reshape(-1, 3)
    body = np.repeat(
        np.arange(len(landing["bodies"])), np.diff([*geometry["starts"], len(vertices)])
    )
    q = profile.landing.q.copy()
    for name, angle in joints.items():
        profile.robot.joint(name).set(np.radians(angle), q)
    there = profile.landing.at(q)
    sliders = [
        slider
        | {"x": np.radians(joints[slider["name"]]) if slider["name"] in joints else slider["value"]}
        for slider in landing["sliders"]
    ]
    given = {
        "landing": landing,
        "sliders": sliders,
        "points": [contact["r"] for contact in landing["contacts"]],
        "geometry": {"vertices": vertices.ravel().tolist(), "body": body.tolist()},
        "state": {
            "rotation": there.state.rotation[0].tolist(),
            "position": there.state.position[0].tolist(),
        },
    }
    script = WARNINGS % json.dumps(str(Path(shockpc.__file__).parent / "show/html/warnings.js"))
    done = subprocess.run(
        ["node", "-e", script], input=json.dumps(given), capture_output=True, text=True, check=True
    )
    found = json.loads(done.stdout)
    assert (found["limits"], found["refused"]) == (limits, refused)
    assert bool(found["below"]) == bool(low)
    if low == "depth":
        posture = Posture(joints_deg=joints)
        depth = float(
            shock_profile(replace(scene, posture=posture)).value("depth_below_contacts", "robot")[0]
        )
        (shown,) = re.findall(
            r"lies (\S+) m below the contact, so flat ground meets it first", found["below"][0]
        )
        assert float(shown) == pytest.approx(depth, abs=3e-3)
        assert depth > 0.05


def test_page_is_small_enough():
    """ANYmal's meshes have more triangles than a screen shows; the page has at most 8 MB."""
    profile = shock_profile(Scene(robot="anymal_b", contact="LF_FOOT"))
    text = html_of(landing_report(profile))
    (geometry,) = data_of(text)["geometries"]
    width = 4 if geometry["wide"] else 2
    assert 50_000 < len(base64.b64decode(geometry["triangles"])) / (3 * width) < 100_000
    assert len(text.encode()) < 8e6


SET = """(() => {
  const input = document.getElementById("%s");
  input.value = "%s";
  input.dispatchEvent(new Event("input", { bubbles: true }));
  return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
})()"""

CELLS = (
    "[...document.querySelectorAll('#%s tbody tr')].map((row) => [...row.cells].map((cell) => "
    "cell.dataset.v ?? cell.textContent))"
)


def cells(page, table):
    """The rows of a table that follows the controls, by the name in the second column."""
    number = re.compile(r"[-+.\d]|Infinity|–")
    rows = page.evaluate(CELLS % table)
    return {
        name: [np.nan if cell == "–" else float(cell) for cell in row if number.match(cell)]
        for _, name, *row in rows
    }


def colours(page):
    """The colours (n, 3) of the view, from 0 to 1."""
    x, y, width, height = page.evaluate(
        "(({x, y, width, height}) => [x, y, width, height])(view.getBoundingClientRect())"
    )
    clip = {"x": x, "y": y, "width": width, "height": height, "scale": 1}
    picture = page.call("Page.captureScreenshot", clip=clip, captureBeyondViewport=True)["data"]
    return matplotlib.image.imread(io.BytesIO(base64.b64decode(picture)))[..., :3].reshape(-1, 3)


def compare_impulses(page, profile):
    """The tables of contacts and joints against an analysis with this strike and these joints."""
    size = np.linalg.norm(profile.total_impulse)
    for contact in (*profile.contacts, *profile.stance):
        row = [
            *contact.impulse,
            np.nan if contact.friction_needed is None else contact.friction_needed,
        ]
        np.testing.assert_allclose(
            cells(page, "contact-rows")[contact.frame], row, rtol=1e-9, atol=1e-11 * size
        )
    for load in profile.loads:
        row = [load.along, np.linalg.norm(load.force), np.linalg.norm(load.moment)]
        np.testing.assert_allclose(
            cells(page, "joint-rows")[load.joint], row, rtol=1e-9, atol=1e-11 * size
        )


@pytest.mark.slow
@BROWSER
def test_browser_follows_the_controls(moving, here, tmp_path_factory):
    """Angle, heading, speed and joint model give the numbers of an analysis with them; a leaving
    contact gives none.
    """
    (here / "report.html").write_text(html_of(landing_report(moving)), encoding="utf-8")
    with Browser(here / "report.html", tmp_path_factory.mktemp("browser")) as page:
        at_first = cells(page, "point-rows")["imu_link"]
        np.testing.assert_allclose(
            at_first,
            [moving.points[0].shock, *moving.points[0].delta_v, moving.points[0].peak_g],
            rtol=1e-9,
        )
        for control, value in (("angle-range", 20), ("heading", -35), ("speed", 2.5)):
            page.evaluate(SET % (control, value))
        (landing,) = data_of((here / "report.html").read_text(encoding="utf-8"))["landings"]
        other = shock_profile(
            replace(
                MOVING,
                strike=replace(MOVING.strike, velocity=tuple(rotated(landing, 20.0, -35.0, 2.5))),
            )
        )
        (point,), row = other.points, cells(page, "point-rows")["imu_link"]
        np.testing.assert_allclose(row, [point.shock, *point.delta_v, point.peak_g], rtol=1e-9)
        for k, (name, values) in enumerate(cells(page, "body-rows").items()):
            assert name == other.bodies[k]
            spin = np.linalg.norm(other.delta_omega[k])
            expected = [other.shock_com[k], spin, *other.copc[k], other.ropc[k]]
            np.testing.assert_allclose([values[0], *values[3:]], expected, rtol=1e-9, atol=1e-15)
        compare_impulses(page, other)
        for model in ("free", "locked"):
            page.evaluate(SET % ("model", model))
            compare_impulses(
                page, shock_profile(replace(other.scene, joints=Joints(model=model)), other.robot)
            )
            (expected,) = other.value(f"shock_{model}", "point")
            np.testing.assert_allclose(
                cells(page, "point-rows")["imu_link"][0], expected, rtol=1e-9
            )
        page.evaluate(SET % ("angle", 120))
        assert "no impact" in page.evaluate("document.getElementById('state').textContent")
        assert np.isnan(cells(page, "point-rows")["imu_link"]).all()
        page.evaluate("document.getElementById('reset').click()")
        np.testing.assert_allclose(cells(page, "point-rows")["imu_link"], at_first, rtol=1e-9)
        assert page.faults == []


@pytest.mark.slow
@BROWSER
def test_browser_draws_anymal(here, tmp_path_factory):
    """Bodies have the colours of their bands; the slider gives the shock; tables fit into 800 px;
    nothing is requested.
    """
    scene = Scene(robot="anymal_b", contact="LF_FOOT")
    (here / "report.html").write_text(
        html_of(landing_report(shock_profile(scene))), encoding="utf-8"
    )
    with Browser(here / "report.html", tmp_path_factory.mktemp("browser")) as page:
        page.wait("document.querySelectorAll('#view canvas').length > 0")
        red, green, blue = colours(page).T
        assert np.mean((blue > 0.75) & (red < 0.65)) > 0.002  # the thigh
        assert np.mean((red > 0.5) & (green < 0.35)) > 0.0005  # its knee
        page.evaluate(SET % ("angle-range", 20))
        other = shock_profile(replace(scene, strike=Strike(strike_angle_deg=20.0)))
        np.testing.assert_allclose(
            cells(page, "point-rows")["imu_link"][0], other.points[0].shock, rtol=1e-6
        )
        mostly = page.evaluate(
            "[...document.querySelectorAll('#body-rows tbody tr')].map((row) => "
            "row.cells[10].textContent == 'mostly out of plane')"
        )
        assert mostly == ((other.out_of_plane_share > 0.5) & ~other.translates).tolist()
        x, y = page.evaluate(
            "(({x, y, width, height}) => [x + width / 2, y + height / "
            "2])(view.getBoundingClientRect())"
        )
        page.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
        page.wait(
            "document.getElementById('pointer').textContent.includes(' m in its frame: shock ')"
        )
        text = page.evaluate("document.getElementById('pointer').textContent")
        body, *numbers = re.fullmatch(
            r"(\S+) at \((\S+), (\S+), (\S+)\) m in its frame: shock (\S+), \|Δv\| \S+ m/s", text
        ).groups()
        *r, shock = map(float, numbers)
        np.testing.assert_allclose(other.shock_at(body, np.array(r)), shock, atol=1e-3)
        order = page.evaluate(
            "document.querySelectorAll('#body-rows th')[2].click(); " + CELLS % "body-rows"
        )
        assert [row[1] for row in order] == [other.bodies[k] for k in np.argsort(-other.shock_com)]
        page.call(
            "Emulation.setDeviceMetricsOverride",
            width=800,
            height=1000,
            deviceScaleFactor=1,
            mobile=False,
        )
        assert page.evaluate(
            "[...document.querySelectorAll('.scroll')].every((box) => box.scrollWidth <= "
            "box.clientWidth)"
        )
        assert (page.faults, page.requests) == ([], [])


SLIDE = """(() => {
  const label = [...document.querySelectorAll("#posture label")].find((one) => one.textContent.startsWith("%s"));
  label.lastChild.value = %s;
  label.lastChild.dispatchEvent(new Event("input"));
  return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
})()"""

OVERLAPS = """(() => {
  document.querySelectorAll("details").forEach((one) => { one.open = true; });
  const boxes = [...document.querySelectorAll("#controls > :not(.wide, [hidden]), #posture label > *, #posture summary")].map(
    (one) => one.getBoundingClientRect()).filter(({ width }) => width);
  const right = document.querySelector("main").getBoundingClientRect().right + 1;
  return boxes.filter((a, k) => a.right > right || boxes.some((b, n) => n < k && a.left < b.right - 1 && b.left < a.right - 1 &&
    a.top < b.bottom - 1 && b.top < a.bottom - 1)).length;
})()"""


@pytest.mark.slow
@BROWSER
def test_browser_follows_the_sliders_of_the_posture(moving, here, tmp_path_factory):
    """They give the numbers of an analysis with them; a singular posture has none, and is grey."""
    scene = replace(MOVING, strike=Strike(velocity=(0.2, 0.1, -1.5)))
    held = replace(
        scene,
        base="fixed",
        contact=Contact(frame="foot", directions=("z",)),
        posture=Posture(joints_deg={"knee": 30.0}),
    )
    landings = {
        name: shock_profile(one, moving.robot)
        for name, one in (("free", scene), ("held", held), ("moving", MOVING))
    }
    (here / "report.html").write_text(
        html_of(analyze_report(landings, live=("knee",))), encoding="utf-8"
    )
    with Browser(here / "report.html", tmp_path_factory.mktemp("browser")) as page:
        page.wait("document.querySelectorAll('#view canvas').length > 0")
        for name, value in (
            ("knee", 40),
            ("pitch", 10),
            ("roll", -5),
            ("foot x", 0.03),
            ("imu_link z", 0.2),
            ("speed", 2),
        ):
            page.evaluate((SET if name == "speed" else SLIDE) % (name, value))
        velocity = tuple(
            2.0 / np.linalg.norm(scene.strike.velocity) * np.array(scene.strike.velocity)
        )
        posture = Posture(joints_deg={"knee": 40.0}, base_rpy_deg=(-5.0, 10.0, 0.0))
        contact = replace(scene.contact[0], offset=(0.03, 0.0, 0.0))
        other = shock_profile(
            replace(scene, posture=posture, contact=contact, strike=Strike(velocity=velocity)),
            moving.robot,
        )
        body = other.shock_at("body", np.array([0.02, 0.0, 0.2]))
        np.testing.assert_allclose(cells(page, "point-rows")["imu_link"][0], body, rtol=1e-10)
        for k, row in enumerate(cells(page, "body-rows").values()):
            expected = [
                other.shock_com[k],
                np.linalg.norm(other.delta_omega[k]),
                *other.copc[k],
                other.ropc[k],
            ]
            np.testing.assert_allclose([row[0], *row[3:]], expected, rtol=1e-10, atol=1e-14)
        compare_impulses(page, other)
        for width in (390, 800, 1300):
            page.call(
                "Emulation.setDeviceMetricsOverride",
                width=width,
                height=1000,
                deviceScaleFactor=1,
                mobile=False,
            )
            page.wait("document.documentElement.scrollWidth <= innerWidth")  # Plotly takes its time
            assert page.evaluate(OVERLAPS) == 0
        page.evaluate("document.getElementById('reset').click()")
        assert page.evaluate("document.getElementById('state').textContent").startswith(
            "the contact velocity of the scene"
        )
        page.evaluate(SET % ("landing", 1))
        page.evaluate(SLIDE % ("knee", "1e-9"))
        assert "singular" in page.evaluate("document.getElementById('state').textContent")
        assert np.isnan(cells(page, "point-rows")["imu_link"]).all()
        assert page.evaluate("document.getElementById('view').data[0].colorscale")[0][1] == "#999"
        page.evaluate(SET % ("landing", 2))
        notes = (
            "[...document.querySelectorAll('main .note')].filter((one) => !one.hidden).map((one) "
            "=> one.textContent)"
        )
        assert any("rotates" in note for note in page.evaluate(notes))
        assert (page.faults, page.requests) == ([], [])


def test_histories_reach_the_peaks_of_the_tables(moving):
    """The largest force and acceleration of the charts are those of the quantities, but for the
    samples.
    """
    profile = shock_profile(Scene(robot="stick.urdf", contact="foot", contact_stiffness=1e4))
    ((force, acceleration),) = [
        one["histories"] for one in data_of(html_of(landing_report(profile)))["landings"]
    ]
    ((name, forces),) = [(line["name"], line["y"]) for line in force["data"]]
    assert name == "foot"
    np.testing.assert_allclose(max(forces), profile.value("peak_force", "contact"), rtol=1e-3)
    np.testing.assert_allclose(
        max(acceleration["data"][0]["y"]), profile.value("peak_acceleration", "point"), rtol=1e-3
    )
    assert acceleration["data"][0]["x"][-1] == 1e3 * profile.stiffness.motion.duration


def test_a_contact_with_a_velocity_does_not_follow_the_base(moving):
    """Its velocity is the same for every strike, and so is the speed that normalises shock."""
    contacts = (
        replace(MOVING.contact[0], velocity=(0.0, 0.0, -2.0)),
        Contact(frame="foot", offset=(0.1, 0.0, 0.0), directions=("z",)),
    )
    (landing,) = data_of(html_of(landing_report(shock_profile(replace(MOVING, contact=contacts)))))[
        "landings"
    ]
    moved, following = landing["contacts"]
    assert (moved["follows"], moved["extra"]) == (False, [0.0, 0.0, -2.0])
    s = np.array([0.3, 0.0, -0.5])
    other = shock_profile(
        replace(MOVING, contact=contacts, strike=replace(MOVING.strike, velocity=tuple(s)))
    )
    np.testing.assert_allclose(
        other.approach, [moved["extra"], following["extra"] + s], rtol=1e-13, atol=1e-15
    )
    M = np.array(landing["models"]["with drives"]["jumps"])
    np.testing.assert_allclose(
        M[..., :3] @ s + M[..., 3], other.proof.jumps[..., 3], rtol=1e-12, atol=1e-13
    )


def test_a_strike_that_contradicts_the_contacts_is_told_from_others(here):
    """A leg on a fixed base moves in its plane; what is left of a strike across it is in the data."""
    (here / "stick.urdf").write_text(STICK_WITH_IMU)
    scene = Scene(
        robot="stick.urdf", contact=Contact(frame="foot", directions=("z", "y")), base="fixed"
    )
    profile = shock_profile(replace(scene, posture=Posture(joints_deg={"knee": 30.0})))
    (landing,) = data_of(html_of(landing_report(profile)))["landings"]
    left = np.array(landing["models"]["with drives"]["left"])
    assert left.shape == (1, 4)
    assert np.abs(left[:, :3] @ profile.strike + left[:, 3]).max() < 1e-12
    across = tuple(profile.strike + np.array([0.0, 0.5, 0.0]))
    assert np.abs(left[:, :3] @ across + left[:, 3]).max() > 0.1
    with pytest.raises(SolveError):
        shock_profile(replace(profile.scene, strike=Strike(velocity=across)))


@pytest.mark.slow
@pytest.mark.parametrize("across", [1e-12, 1e-10, 1e-8, 1e-7, 1e-2])
def test_page_and_analysis_refuse_the_same_strikes(here, across):
    """What `contradicts` of report.js computes of the data decides as the analysis does, with the
    analysis's number.
    """
    (here / "stick.urdf").write_text(STICK_WITH_IMU)
    scene = Scene(
        robot="stick.urdf", contact=Contact(frame="foot", directions=("z", "y")), base="fixed"
    )
    profile = shock_profile(replace(scene, posture=Posture(joints_deg={"knee": 30.0})))
    data = data_of(html_of(landing_report(profile)))
    model, s = (
        data["landings"][0]["models"]["with drives"],
        np.append(profile.strike + np.array([0.0, across, 0.0]), 1.0),
    )
    left, speeds = (np.abs(np.array(model[key]) @ s) for key in ("left", "speeds"))
    length = np.sqrt(s @ np.array(model["motion"]) @ s)
    refused = bool(
        np.any(left > data["contradiction"] * speeds.max() + np.array(model["rounding"]) * length)
    )
    assert refused == (across > CONTRADICTION)
    try:
        shock_profile(replace(profile.scene, strike=Strike(velocity=tuple(s[:3].tolist()))))
    except SolveError:
        assert refused
    else:
        assert not refused


STUDIES = {
    "sensitivity": ("anymal_b", "--contact", "LF_FOOT", "--at", "imu_link"),
    "limits": (
        "hyq",
        "--contact",
        "lf_foot",
        "--joint",
        "lf_kfe_joint",
        "--at",
        "trunk_imu",
        "--max",
        "0.1",
        "--step",
        "5",
    ),
    "batch": ("bolt", "solo12", "--figures"),
    "sweep": (
        "anymal_b",
        "--contact",
        "LF_FOOT",
        "--vary",
        "armature:*_KFE=0:0.1",
        "--sample",
        "20",
        "--rows",
        "csv",
    ),
    "paper": ("1",),
}


@pytest.mark.slow
@pytest.mark.parametrize("study", STUDIES)
def test_every_study_has_a_page(capfd, tmp_path, monkeypatch, study):
    """Figures, tables, warnings and the command in one file, which needs neither Plotly nor a
    network.
    """
    for module in ("show.folder", "wings.paper.report"):
        monkeypatch.setattr(f"shockpc.{module}.plotly", lambda: None)
    good(capfd, study, *STUDIES[study], "--out", tmp_path)
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    page, figures = Page(text), len(list(tmp_path.glob("*.svg")))
    assert text.count('<img class="figure"') == figures > 0
    assert text.count("<table>") > 0
    assert page.texts["pre"] == [shlex.join(["shockpc", study, *STUDIES[study]])]
    assert "data" not in page.texts
    assert len(text.encode()) < 8e6


ANSWERS = {
    "place": (
        ("anymal_b", "--contact", "LF_FOOT", "--body", "base"),
        "<caption>places on base",
        "<p>imu_link sees",
    ),
    "compare": (
        ("anymal_b", "anymal_c", "--contact", "LF_FOOT"),
        'alt="what changes between the designs"',
    ),
    "check": (("budgets.toml",), "<caption>budgets of 1 landing: 1 passed"),
}
"""Arguments of commands, and what their pages begin with."""


@pytest.mark.slow
@pytest.mark.parametrize("command", ANSWERS)
def test_a_page_begins_with_the_answer_of_its_command(capfd, here, command):
    """Places, changes and outcomes are before the view of the landing."""
    (here / "budgets.toml").write_text(
        '[[case]]\nname = "one"\nrobot = "anymal_b"\ncontact = "LF_FOOT"\n[[budget]]\nmetric = '
        '"shock"\nat = "imu_link"\nmax = 9\n'
    )
    arguments, *answers = ANSWERS[command]
    good(capfd, command, *arguments, "--out", here / "out")
    text = (here / "out" / "report.html").read_text(encoding="utf-8")
    view = text.index("<main>")
    assert all(text.count(answer) == 1 and text.index(answer) < view for answer in answers)


def test_tables_without_rows_are_left_out(moving):
    """A heading over nothing says nothing."""
    report = landing_report(moving)
    lines, *others = report.body(True)
    empty = Sheet("nothing to see", ("name", "number [m]"), ())
    text = html_of(report._replace(page_body=lambda: [lines, empty, *others]))
    assert "nothing to see" not in text
    assert "nothing to see" in html_of(
        report._replace(page_body=lambda: [lines, empty._replace(rows=[("a", 1.0)]), *others])
    )


def test_tables_that_follow_the_strike_are_on_the_page_once(moving):
    """The report has them too; the page has the other tables for the strike of the scene."""
    report = landing_report(moving)
    captions = [section.title for section in report.body(True) if isinstance(section, Sheet)]
    text = html_of(report)
    shown = [title for title in captions if f"<caption>{html.escape(title)}" in text]
    left_out = [title.split(" (")[0] for title in captions if title not in shown]
    assert left_out == ["bodies", "sensors and points", "contacts", "impulse through the joints"]
    assert "effect of the joint model" in shown
    assert text.count('class="scroll live"') == 4


@BROWSER
@pytest.mark.slow
def test_browser_sorts_the_tables_of_a_study(capfd, tmp_path, tmp_path_factory):
    good(capfd, "batch", "bolt", "solo12", "--out", tmp_path)
    with Browser(tmp_path / "report.html", tmp_path_factory.mktemp("browser")) as page:
        rows = "[...document.querySelectorAll('tbody tr')].map((row) => +row.cells[4].dataset.v)"
        masses = f"document.querySelectorAll('th')[4].click(); {rows}"
        values = page.evaluate(masses)
        assert values == sorted(values, reverse=True)
        assert page.evaluate(masses) == values[::-1]
        assert (page.faults, page.requests) == ([], [])
