"""The claims of the method's paper, and its dimensioned models against an independent solution."""

import json
import re

import numpy as np
import pytest
from commands import good, run, says

from shockpc import Point
from shockpc.robot.catalogue import catalogue, project_robots_folder
from shockpc.robot.load import load_robot
from shockpc.wings.paper.beam import beam
from shockpc.wings.paper.claim import Claim
from shockpc.wings.paper.leg import cases, reductions
from shockpc.wings.paper.panel_landings import land, middle_lines
from shockpc.wings.paper.quadruped import ANGLES, quadruped
from shockpc.wings.paper.report import LIVE, paper_picture
from shockpc.wings.paper.skippy import ASSUMED, above_contact, skippy
from shockpc.wings.paper.study import FIGURES
from shockpc.wings.symbols.posture_formulas import live_landing

# The dimensioned models against maximal coordinates in the plane. Points and vectors are complex: x
# to the right, i up.


def pointing(angle):
    """The unit vector at that angle from straight down [deg], counter-clockwise."""
    return -1j * np.exp(1j * np.radians(angle))


def rod(start, angle, length, mass):
    """A slender uniform beam: its ends and its mass."""
    return start, start + length * pointing(angle), mass


def at_point(com, point):
    """Velocity (2, 3) of a point of a beam for ω = 1, v_x = 1 and v_z = 1 at its centre of mass."""
    arm = point - com
    return np.array([[-arm.imag, 1.0, 0.0], [arm.real, 0.0, 1.0]])


def check(found, bodies, hinges, struck, point, strike=0.0, rotors=()):
    """Compare a profile with the solution for named beams: a hinge holds two of them together, a
    rotor turns one by another.
    """
    places = {name: slice(3 * k, 3 * k + 3) for k, name in enumerate(bodies)}
    com = {name: (start + end) / 2.0 for name, (start, end, _) in bodies.items()}
    M = np.diag(
        [
            x
            for start, end, mass in bodies.values()
            for x in (mass * abs(end - start) ** 2 / 12.0, mass, mass)
        ]
    )
    for a, b, inertia in rotors:
        turn = np.zeros(len(M))
        turn[[places[a].start, places[b].start]] = 1.0, -1.0
        M += inertia * np.outer(turn, turn)
    J = np.zeros((2 * len(hinges) + 2, len(M)))
    for k, (a, b, place) in enumerate(hinges):
        J[2 * k : 2 * k + 2, places[a]], J[2 * k : 2 * k + 2, places[b]] = (
            at_point(com[a], place),
            -at_point(com[b], place),
        )
    J[-2:, places[struck]] = at_point(com[struck], point)
    stopped = np.zeros(len(J))
    stopped[-2:] = -pointing(strike).real, -pointing(strike).imag
    M_J = np.linalg.solve(M, J.T)
    jumps = M_J @ np.linalg.solve(J @ M_J, stopped)
    for name, place in places.items():
        i = found.bodies.index(name)
        at_com = found.delta_v[i] + np.cross(found.delta_omega[i], found.robot.bodies[i].com)
        turn, v = found.rotation[i] @ found.delta_omega[i], found.rotation[i] @ at_com
        # counter-clockwise is about −y
        np.testing.assert_allclose([-turn[1], v[0], v[2]], jumps[place], rtol=1e-11, atol=1e-11)
        np.testing.assert_allclose([turn[0], turn[2], v[1]], 0.0, atol=1e-12)


@pytest.mark.parametrize("letter", "abcdef")
@pytest.mark.parametrize("shank", [0, -10])
def test_the_leg_has_its_dimensions(letter, shank):
    """Figure 2: lengths 1 : 1 : 3/2 : 1/2 of 0.4 m; masses 2 : 1 : 6 : 1/2 of 3.5 kg; upper leg at
    15°, torso at −5°.
    """
    found = land(f"fig2_{letter}", {"knee": shank - 15.0})
    bodies = {
        "upper_leg": (upper := rod(0.0, 15, 0.4, 7.0)),
        "lower_leg": (lower := rod(upper[1], shank, 0.4, 3.5)),
    }
    hinges = [("upper_leg", "lower_leg", upper[1])]
    if letter in "def":
        bodies["torso"] = rod(0.0, 175, 0.6, 21.0)
        hinges.append(("torso", "upper_leg", 0.0))
    if letter == "f":
        bodies["foot"] = rod(lower[1], shank + 105, 0.2, 1.75)
        hinges.append(("lower_leg", "foot", lower[1]))
    last = "foot" if letter == "f" else "lower_leg"
    check(found, bodies, hinges, last, bodies[last][1], found.scene.strike.strike_angle_deg)


@pytest.mark.parametrize("angle", [0, 10, 20, 30])
def test_the_quadruped_has_its_dimensions(angle):
    """Figure 5: segments of 0.4 m, masses 20 : 4 : 1 kg, torso two segments long and nose up by
    15°.
    """
    bodies, hinges = {"torso": (torso := rod(0.0, 105, 0.8, 20.0))}, []
    for which, hip, knee in (("hind", torso[0], 1), ("front", torso[1], -1)):
        upper = rod(hip, knee * angle, 0.4, 4.0)
        bodies |= {
            f"{which}_upper_leg": upper,
            f"{which}_lower_leg": rod(upper[1], -knee * angle, 0.4, 1.0),
        }
        hinges += [
            ("torso", f"{which}_upper_leg", hip),
            (f"{which}_upper_leg", f"{which}_lower_leg", upper[1]),
        ]
    check(land(f"fig5_{angle:02d}"), bodies, hinges, "hind_lower_leg", bodies["hind_lower_leg"][1])


def meeting_point(a, reach_a, b, reach_b, side):
    """Where two links of those lengths, hung at a and b, meet; to the left of the way from a to b
    if side is 1.
    """
    apart = abs(b - a)
    along = (reach_a**2 - reach_b**2 + apart**2) / (2.0 * apart)
    return a + (b - a) / apart * (along + 1j * side * np.sqrt(reach_a**2 - along**2))


def test_skippy_has_its_dimensions():
    """Figure 3: the drive's crank and rod from the law of cosines, its loop closed by a fifth
    hinge.
    """
    torso, leg = rod(0.0, 180 - 39.22, 0.6, 1.5), rod(0.0, 38 - 39.22, 0.4, 0.3)
    foot = rod(leg[1], 38 + 85 - 39.22, 0.16, 0.1)
    motor, lever = 0.14 / 0.6 * torso[1], 0.08 / 0.4 * leg[1]
    pin = meeting_point(motor, 0.08, lever, 0.16, 1)
    bodies = {
        "torso": torso,
        "leg": leg,
        "foot": foot,
        "crank": (motor, pin, 0.03),
        "rod": (pin, lever, 0.03),
    }
    hinges = [("torso", "leg", 0.0), ("leg", "foot", leg[1])]
    hinges += [("torso", "crank", motor), ("crank", "rod", pin), ("rod", "leg", lever)]
    check(land("fig3"), bodies, hinges, "foot", foot[1])


@pytest.mark.parametrize("spread", [0.0, 0.06])
def test_the_five_bar_has_its_dimensions(spread):
    """Two driven hips at ±60° with a rotor each, knees from the law of cosines, the loop closed at
    the toe.
    """
    front, rear = rod(spread / 2.0, 60, 0.1, 0.04), rod(-spread / 2.0, -60, 0.1, 0.04)
    toe = meeting_point(rear[1], 0.2, front[1], 0.2, -1)
    bodies = {"body": (-0.15, 0.15, 1.2), "front_upper": front, "rear_upper": rear}
    bodies |= {"front_lower": (front[1], toe, 0.05), "rear_lower": (rear[1], toe, 0.05)}
    hinges = [("front_lower", "rear_lower", toe)]
    for which, upper in (("front", front), ("rear", rear)):
        hinges += [
            ("body", f"{which}_upper", upper[0]),
            (f"{which}_upper", f"{which}_lower", upper[1]),
        ]
    rotors = [("front_upper", "body", 4e-5), ("rear_upper", "body", 4e-5)]
    check(
        land("five_bar", xacro={"spread": str(spread)}),
        bodies,
        hinges,
        "front_lower",
        toe,
        15,
        rotors,
    )


# The claims


def the(beginning) -> Claim:
    """The one claim whose section and statement begin so."""
    (found,) = (claim for claim in CLAIMS if claim.statement.startswith(beginning))
    return found


LEANING, FLAT_EF, LINE = (
    "lower leg at −15°",
    "E and F struck at 45°",
    "ankle's 75° counted from the line of the lower leg",
)
FOOT_LENGTHS = ["foot length halved", "foot length doubled"]
BETWEEN, AT_80 = "38° between torso and leg, torso backward", "80° between foot and leg"

CLAIMS = [claim for figure in FIGURES for claim in figure.claims]
OUTCOMES = {
    "Section 2.1: in 3D": (True, ["impact in a plane with the beam"]),
    "Eq. 3: ": (True, ["sticking contact, impact 45° from across the beam"]),
    "Eq. 12": (False, ["with the absolute value of Δω_z"]),
    "Section 3.4: when the robot moves forward": (True, [LEANING]),
    "Section 3.4: upper bodies": (
        True,
        ["largest shock on the middle line of a body", "Figure 5 at 0°"],
    ),
    "Section 3.4: the CoPc of a body tends": (True, ["lower leg", "Figure 5 at 0°"]),
    "Section 3.4: a design": (True, ["foot ends at the ankle", "struck 15° from the normal"]),
    "Section 3.4: two slender bodies": (True, ["struck 45° from the normal"]),
    "Section 4.1: the effect of the torso": (True, ["both struck at 45°", "both struck at 15°"]),
    "Section 4.1: the foot reduces": (True, [LEANING, FLAT_EF, LINE]),
    "Footnote 4": (True, [LEANING, FLAT_EF, LINE]),
    "Figure 4": (True, ["case C"]),
    "Section 5: the torso": (True, ["distance in the plane", "Figure 5"]),
    "Section 4.2: the radius": (True, [BETWEEN]),
    "Section 4.2: nowhere": (True, [BETWEEN]),
    "Section 4.2: two mounting": (True, [BETWEEN]),
    "Section 4.2: the CoPc": (True, [AT_80, "torso mass halved", "foot mass halved"]),
    "Section 4.2: other extreme": (
        True,
        [
            "torso backward",
            BETWEEN,
            AT_80,
            "torso mass halved",
            "leg mass doubled",
            "foot mass doubled",
            *FOOT_LENGTHS,
        ],
    ),
    "Footnote 5": (True, ["torso leaning, rotated about the axis across the sagittal plane"]),
    "Section 4.3: the torso is relatively": (True, ["legs bent by 10°", "legs bent by 0°"]),
    "Section 4.3: the CoPc of the torso moves": (True, ["hind knee backward", "nose down"]),
    "Section 4.3: the front leg": (False, ["hind leg"]),
    "Section 3.1.2": (False, ["legs straight"]),
}
"""Whether a claim holds, and the other interpretations that change the outcome.

Every other claim holds under all of them.
"""


@pytest.mark.slow
@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.statement[:40])
def test_the_outcome_of_a_claim(claim):
    expected = [
        outcome for beginning, outcome in OUTCOMES.items() if claim.statement.startswith(beginning)
    ]
    assert [(claim.holds, list(claim.alternatives))] == (expected or [(True, [])])


def test_every_claim_is_counted():
    assert all(the(beginning) for beginning in OUTCOMES)
    readme = (project_robots_folder().parent / "README.md").read_text(encoding="utf-8")
    failed = sum(not holds for holds, _ in OUTCOMES.values())
    counts = len(CLAIMS), len(CLAIMS) - len(OUTCOMES), len(OUTCOMES) - failed, failed
    sentence = (
        r"checks (\d+) of its claims: (\d+) hold, (\d+) hold as interpreted but not under an "
        r"alternative, and (\d+) do not hold\."
    )
    assert [tuple(map(int, found)) for found in re.findall(sentence, " ".join(readme.split()))] == [
        counts
    ]
    assert {key for key, (holds, _) in OUTCOMES.items() if not holds} == {
        "Eq. 12",
        "Section 4.3: the front leg",
        "Section 3.1.2",
    }
    assert all(named in readme for named in ("Eq. 12", "Section 4.3", "Section 3.1.2"))


def test_an_outcome_follows_from_the_value():
    """Strictly between the bounds; NaN never holds; what does not change the outcome is no
    alternative.
    """
    options = {"same": {"size": 1.5}, "bound": {"size": 2.0}, "none": {"size": np.nan}}
    claim = Claim(
        "here: so",
        "size [1]",
        lambda size=1.0: size,
        "small",
        above=0.5,
        below=2.0,
        options=options,
    )
    assert (claim.holds, claim.criterion, list(claim.alternatives)) == (
        True,
        "between 0.5 and 2",
        ["bound", "none"],
    )


def test_least_shock_in_space_is_on_the_screw_axis():
    """There it is |Δω·Δv| / |Δω|; no other point has less."""
    profile = beam(1.0, 0.04, 0.04, velocity=(0.3, 0.4, -1.0), directions=("x", "y", "z"))
    omega, v = profile.delta_omega[0], profile.delta_v[0]
    spin, least = np.linalg.norm(omega), the("Section 2.1: in 3D").value
    assert least == pytest.approx(abs(omega @ v) / spin / profile.v_in, rel=1e-12)
    on_axis = np.cross(omega, v) / spin**2 + np.linspace(-1.0, 1.0, 21)[:, None] * omega / spin
    np.testing.assert_allclose(profile.shock_at("beam", on_axis), least, rtol=1e-12)
    beside = on_axis[0] + np.random.default_rng(0).uniform(-2.0, 2.0, (1000, 3))
    assert profile.shock_at("beam", beside).min() > least > 0.1


def test_distances_of_centres_of_percussion_are_those_of_the_claims():
    """Case E's lower leg has it 1.494 times as far from the knee as from the heel; a torso, beside
    it by 0.41 of its length.
    """
    profile = land("fig2_e")
    low, high = middle_lines(profile)["lower_leg"]
    centre = profile.copc[profile.bodies.index("lower_leg")]
    ratio = np.linalg.norm(centre - high) / np.linalg.norm(centre - low)
    assert (
        the("Section 3.4: the CoPc of a body").alternatives["lower leg"]
        == pytest.approx(ratio)
        == pytest.approx(1.494, abs=1e-3)
    )
    beside = (
        max(
            abs(p.copc[p.bodies.index("torso"), 0])
            for p in map(land, ("fig2_d", "fig2_e", "fig2_f"))
        )
        / 0.6
    )
    assert (
        the("Section 5: the torso").alternatives["distance in the plane"]
        == pytest.approx(beside)
        == pytest.approx(0.41, abs=1e-2)
    )


def test_the_foot_by_its_links():
    """98 % of every link as drawn; counted from the lower leg's line, the lower leg keeps a third
    of its shock.
    """
    assert min(reductions().values()) == pytest.approx(98.34, abs=0.01)
    assert {body: round(value) for body, value in reductions(ankle=75.0).items()} == {
        "lower_leg": 66,
        "upper_leg": 95,
        "torso": 99,
    }


@pytest.mark.parametrize(("forward", "backward"), [(105.0, -75.0), (75.0, -105.0)])
def test_toes_forward_or_backward_are_one_for_a_slender_foot(forward, backward):
    """An impact at one end of a beam has the same effect as at the other: 105° forward is 75°
    backward.
    """
    assert reductions(ankle=forward) == pytest.approx(reductions(ankle=backward), abs=1e-9)


def test_no_case_slips_as_drawn():
    """The impulse by its components, and the friction coefficient of the claim."""
    impulses = np.array([land(f"fig2_{letter}").contacts[0].impulse for letter in "abcdef"])
    needed = np.abs(impulses[:, 0]) / impulses[:, 2]
    assert (
        the("Footnote 4").value
        == pytest.approx(needed.max(), rel=1e-12)
        == pytest.approx(0.427, abs=0.001)
    )


def test_a_rotated_imu_bears_sqrt_2_of_a_jump_along_an_axis():
    """√2 on an upright torso; a torso that leans by 39.22° loses if the IMU is rotated the way it
    leans.
    """
    lean = np.radians(39.22)
    found = the("Footnote 5")
    assert found.value == pytest.approx(np.sqrt(2.0), rel=1e-15)
    (across,) = found.alternatives.values()
    assert across == pytest.approx(np.cos(lean) / np.cos(np.radians(45.0) - lean), rel=1e-9)


def test_skippys_assumptions_are_those_of_its_file():
    robot = land("fig3").robot
    masses = {f"{body.name}_mass": body.mass for body in robot.bodies}
    assert masses | {"leg_length": 0.4, "foot_length": 0.16} == pytest.approx(ASSUMED)
    assert -robot.frame("toe").offset[2] == pytest.approx(ASSUMED["foot_length"])
    folder = project_robots_folder()
    text = (folder / "scenes" / "fig3.toml").read_text() + (
        folder / "skippy.urdf.xacro"
    ).read_text()
    assert text.count("assumed") + text.count("ASSUMED") >= 12
    assert "Assumed" in FIGURES[2].note


@pytest.mark.parametrize(
    "profile", [lambda: land("fig3"), lambda: skippy(hip=-38.0, leg_mass="0.6")]
)
def test_skippys_centre_of_mass_is_above_its_toe(profile):
    x, y, z = above_contact(profile())
    assert abs(x) < 1e-4
    assert abs(y) < 1e-12
    assert z > 0.2


# Scenes, figures and command


def test_every_panel_has_its_scene_and_every_scene_computes():
    panels = {panel.scene for figure in FIGURES for panel in figure.panels}
    assert {path.stem for path in (project_robots_folder() / "scenes").glob("*.toml")} == panels | {
        "five_bar",
        "bat",
    }
    for stem in panels | {"five_bar", "bat"}:
        profile = land(stem)
        assert {warning.kind for warning in profile.health.warnings} <= {"height"}, (
            "the beam is no foot, and nothing else is wrong"
        )
        assert profile.health.error_bound < 1e-11
        assert abs(profile.contacts[0].point[2]) < 1e-4


def test_figures_are_drawn_as_the_claims_interpret_them():
    """The defaults of the models are the scenes: same shocks."""
    shown = {f"fig2_{letter}": profile for letter, profile in zip("abcdef", cases(), strict=True)}
    shown |= {f"fig5_{angle:02.0f}": quadruped(angle) for angle in ANGLES} | {"fig3": skippy()}
    for stem, profile in shown.items():
        # the scene rounds the pitch
        np.testing.assert_allclose(profile.shock_com, land(stem).shock_com, atol=2e-5)


def test_the_page_of_models_has_their_arguments_and_results():
    """A row for every model and for every scene, with what the files say and compute."""
    folder = project_robots_folder()
    page = (folder / "README.md").read_text(encoding="utf-8")
    rows = {
        folder / file: row
        for row, file in re.findall(r"^(\| \[`\w+`\]\((\S+)\).*)$", page, re.MULTILINE)
    }
    models = {
        entry.path: load_robot(entry.name)
        for entry in catalogue()
        if entry.path.parent == project_robots_folder()
    }
    scenes = sorted((folder / "scenes").glob("*.toml"))
    assert list(rows) == [*models, *scenes]
    for path, robot in models.items():
        arguments = ", ".join(
            f"`{name}`" for name in re.findall(r'<xacro:arg name="(\w+)"', path.read_text())
        )
        assert rows[path].endswith(f"| {len(robot.bodies)} | {robot.mass:.4g} | {arguments} |")
    for path in scenes:
        found = land(path.stem)
        shock = ", ".join(
            f"{body} {value:.3f}" for body, value in zip(found.bodies, found.shock_com, strict=True)
        )
        assert rows[path].endswith(f"| {found.scene.strike.strike_angle_deg or 0.0:g}° | {shock} |")


def test_hands_are_at_rest_where_the_ball_hits_their_centre_of_percussion():
    """At c + r_g² / (c − h); and Eq. 1 for other hits and bats, and in the program with which a
    page moves the hit.
    """
    shown = [(name, stem, frame) for figure in LIVE.values() for name, stem, frame in figure]
    (hands,) = (frame for _, stem, frame in shown if stem == "bat")
    for inertia, h in ((0.05, 0.15), (0.04, 0.1)):
        sweet = 0.57 + inertia / 0.88 / (0.57 - h)
        for x in (0.3, sweet):
            xacro = {"inertia": str(inertia), "hands": str(h), "ball": repr(x)}
            found = land("bat", xacro=xacro, point=(Point(frame=hands),))
            shock = abs(1.0 + (x - 0.57) * (h - 0.57) * 0.88 / inertia) / (
                1.0 + (x - 0.57) ** 2 * 0.88 / inertia
            )
            assert found.shock_at(hands, np.zeros(3)) == pytest.approx(shock, abs=1e-12)
    live = live_landing(found.landing, boxes=np.array([[[0.0, 0.0, -0.1], [0.84, 0.0, 0.1]]]))
    (where,) = (k for k, one in enumerate(live.sliders) if one.name == "ball x")
    x = np.array([one.value for one in live.sliders])
    x[where] = sweet
    (out,) = live.program(np.array([[*x, *found.landing.before.velocity, *np.eye(3).ravel()]]))
    omega, v = out[12:15], out[15:18]
    assert np.linalg.norm(v + np.cross(omega, [h, 0.0, 0.0])) < 1e-12 < np.linalg.norm(v)


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: str(figure.number))
def test_a_figure_names_its_panels_and_bodies(figure):
    drawing = paper_picture(figure).draw()
    words = "\n".join(text.get_text() for text in drawing.axes[0].texts)
    assert all(panel.label in words and panel.words in words for panel in figure.panels)
    assert figure.note[:30] in words
    assert all(
        body.replace("_", " ") in words for profile in figure.profiles for body in profile.bodies
    )


def test_the_command_writes_what_it_computes(capfd, tmp_path):
    out = good(capfd, "paper", "fig1", "--out", tmp_path / "paper")
    assert out.startswith(
        "claims of the paper: 9 hold, 2 hold as interpreted, but not under an alternative, 1 do "
        "not hold\n"
    )
    outcomes = [line.split("  ")[0] for line in out.splitlines()[3:-1]]
    assert outcomes == ["does not hold", *["as interpreted"] * 2, *["holds"] * 9]
    assert any(
        line.startswith("1 A ") and line.endswith("  translates")
        for line in good(capfd, "paper", "fig1", "--verbose").splitlines()
    )
    claims = json.loads(good(capfd, "paper", "fig1", "--format", "json"))["tables"]["claims"]
    assert [row["claim"] for row in claims if not row["alternative"]] == [
        claim.statement.partition(": ")[2] for claim in FIGURES[0].claims
    ]
    scenes = {f"fig1_{letter}.toml" for letter in "abcd"}
    files = scenes | {
        "bodies.csv",
        "claims.csv",
        "figure1.png",
        "figure1.svg",
        "paper.md",
        "report.html",
        "paper.json",
        ".paper.sha256",
    }
    assert {path.name for path in (tmp_path / "paper").iterdir()} == files
    page = (tmp_path / "paper" / "report.html").read_text(encoding="utf-8")
    assert all(name in page for name, *_ in LIVE[1])
    again = run(capfd, "analyze", tmp_path / "paper" / "fig1_c.toml", "--format", "csv").out
    assert again.splitlines()[1].startswith("percussion,beam,1.5")
    assert (
        "![Figure 1: a slender beam on a slider](figure1.svg)"
        in (tmp_path / "paper" / "paper.md").read_text()
    )
    rows = (tmp_path / "paper" / "claims.csv").read_text().splitlines()
    assert len(rows) == 1 + sum(1 + len(claim.alternatives) for claim in FIGURES[0].claims)


@pytest.mark.parametrize("name", ["7", "Figure 4"])
def test_a_figure_that_cannot_be_drawn(capfd, name):
    outcome = run(capfd, "paper", name)
    assert (outcome.code, outcome.out) == (2, "")
    assert (
        f'no figure "{name}" in the paper that can be drawn (figure 4 is a photograph; '
        in outcome.err
    )
    assert says(outcome.err, '"1", "2", "3", "5"', "shockpc paper")
