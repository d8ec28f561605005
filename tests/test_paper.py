"""The claims of the method's paper, and its dimensioned models against an independent solution."""

import re

import mpmath
import numpy as np
import pytest
from commands import good, run
from mpmath import mpf
from planar import STICKS, at, difference, falling, pointing, solve
from planar import beam as rod

from shockpc.core.impulse import solve_impact
from shockpc.model.dynamics import dynamics
from shockpc.paper.beam import beam, eq_3_radius
from shockpc.paper.claim import Claim
from shockpc.paper.figures import FIGURES
from shockpc.paper.landings import changed, land, largest, middle_lines, scene
from shockpc.paper.leg import cases, reductions
from shockpc.paper.quadruped import ANGLES, quadruped
from shockpc.paper.skippy import ASSUMED, above_contact, skippy
from shockpc.robot.catalogue import catalogue, own_robots_folder
from shockpc.robot.robot import load_robot
from shockpc.show.files import MANIFEST
from shockpc.show.reports.paper import draw_paper_figure

DIGITS = 1e-12


# The dimensioned models against maximal coordinates in fifty digits


def leg_beams(shank, torso=False, foot=None):
    """Lengths 1 : 1 : 3/2 : 1/2 of 0.4 m; masses 2 : 1 : 6 : 1/2 of 3.5 kg; upper leg at 15°, torso at −5°."""
    hip = (mpf(0), mpf(0))
    length, mass = mpf("0.4"), mpf("3.5")
    bodies = {"upper_leg": rod(hip, 15, length, 2 * mass)}
    bodies["lower_leg"] = rod(bodies["upper_leg"].end, shank, length, mass)
    hinges = [("upper_leg", "lower_leg", bodies["upper_leg"].end)]
    if torso:
        bodies["torso"] = rod(hip, 180 - 5, 3 * length / 2, 6 * mass)
        hinges.append(("torso", "upper_leg", hip))
    if foot is not None:
        bodies["foot"] = rod(bodies["lower_leg"].end, shank + foot, length / 2, mass / 2)
        hinges.append(("lower_leg", "foot", bodies["lower_leg"].end))
    return bodies, hinges


def answer(bodies, hinges, contacts, strike, rotors=()):
    names = list(bodies)
    index = names.index
    return names, solve(
        list(bodies.values()),
        [(index(a), index(b), p) for a, b, p in hinges],
        [(index(a), p, d) for a, p, d in contacts],
        strike,
        [(index(a), index(b), inertia) for a, b, inertia in rotors],
    )


@pytest.mark.parametrize("letter", "ABCDEF")
@pytest.mark.parametrize("shank", [0, -10])
def test_the_leg_agrees_with_fifty_digits(letter, shank):
    """Figure 2, straight from lengths, masses and angles."""
    found = scene(f"fig2_{letter.lower()}")
    torso, foot = letter in "DEF", 105 if letter == "F" else None
    bodies, hinges = leg_beams(shank, torso, foot)
    last = "foot" if letter == "F" else "lower_leg"
    names, jumps = answer(bodies, hinges, [(last, bodies[last].end, STICKS)], falling(found.strike.strike_angle_deg))
    assert difference(land(changed(found, {"knee": shank - 15.0})), names, jumps) < DIGITS


@pytest.mark.parametrize("angle", [0, 10, 20, 30])
def test_the_quadruped_agrees_with_fifty_digits(angle):
    """Figure 5: segments of 0.4 m, masses 20 : 4 : 1 kg, torso two segments long and nose up by 15°."""
    length = mpf("0.4")
    bodies = {"torso": rod((mpf(0), mpf(0)), 90 + 15, 2 * length, 20)}
    hinges = []
    for which, hip, knee in (("hind", bodies["torso"].start, 1), ("front", bodies["torso"].end, -1)):
        upper = rod(hip, knee * angle, length, 4)
        lower = rod(upper.end, -knee * angle, length, 1)
        bodies |= {f"{which}_upper_leg": upper, f"{which}_lower_leg": lower}
        hinges += [("torso", f"{which}_upper_leg", hip), (f"{which}_upper_leg", f"{which}_lower_leg", upper.end)]
    foot = bodies["hind_lower_leg"].end
    names, jumps = answer(bodies, hinges, [("hind_lower_leg", foot, STICKS)], falling(0))
    assert difference(land(f"fig5_{angle:02d}"), names, jumps) < DIGITS


def meeting_point(a, reach_a, b, reach_b, side):
    """Where two links of those lengths, hung at a and b, meet; to the left of the way from a to b if side is 1."""
    dx, dz = b[0] - a[0], b[1] - a[1]
    apart = mpmath.sqrt(dx**2 + dz**2)
    along = (reach_a**2 - reach_b**2 + apart**2) / (2 * apart)
    across = side * mpmath.sqrt(reach_a**2 - along**2)
    return a[0] + (along * dx - across * dz) / apart, a[1] + (along * dz + across * dx) / apart


def between(start, end, mass):
    one = rod(start, 0, 1, mass)
    return one._replace(end=tuple(end))


def test_skippy_agrees_with_fifty_digits():
    """Figure 3: the drive's crank and rod from the law of cosines, its loop closed by a fifth hinge."""
    pitch, hip = mpf("39.22"), (mpf(0), mpf(0))
    torso = rod(hip, 180 - pitch, "0.6", "1.5")
    leg = rod(hip, 38 - pitch, "0.4", "0.3")
    foot = rod(leg.end, 38 + 85 - pitch, "0.16", "0.1")
    motor, lever = at(torso, mpf("0.14") / mpf("0.6")), at(leg, mpf("0.08") / mpf("0.4"))
    pin = meeting_point(motor, mpf("0.08"), lever, mpf("0.16"), 1)
    bodies = {"torso": torso, "leg": leg, "foot": foot, "crank": between(motor, pin, "0.03"), "rod": between(pin, lever, "0.03")}
    hinges = [
        ("torso", "leg", hip),
        ("leg", "foot", leg.end),
        ("torso", "crank", motor),
        ("crank", "rod", pin),
        ("rod", "leg", lever),
    ]
    names, jumps = answer(bodies, hinges, [("foot", foot.end, STICKS)], falling(0))
    assert difference(land("fig3"), names, jumps) < DIGITS


@pytest.mark.parametrize("spread", ["0", "0.06"])
def test_the_five_bar_agrees_with_fifty_digits(spread):
    """Two driven hips at ±60° with a rotor each, knees from the law of cosines, the loop closed at the toe."""
    half = mpf(spread) / 2
    body = between((mpf("-0.15"), mpf(0)), (mpf("0.15"), mpf(0)), "1.2")
    front, rear = rod((half, mpf(0)), 60, "0.1", "0.04"), rod((-half, mpf(0)), -60, "0.1", "0.04")
    toe = meeting_point(rear.end, mpf("0.2"), front.end, mpf("0.2"), -1)
    bodies = {
        "body": body, "front_upper": front, "front_lower": between(front.end, toe, "0.05"),
        "rear_upper": rear, "rear_lower": between(rear.end, toe, "0.05"),
    }  # fmt: skip
    hinges = [
        ("body", "front_upper", front.start), ("front_upper", "front_lower", front.end),
        ("body", "rear_upper", rear.start), ("rear_upper", "rear_lower", rear.end), ("front_lower", "rear_lower", toe),
    ]  # fmt: skip
    rotors = [("front_upper", "body", "4e-5"), ("rear_upper", "body", "4e-5")]
    names, jumps = answer(bodies, hinges, [("front_lower", toe, STICKS)], falling(15), rotors)
    found = land(changed(scene("five_bar"), xacro={"spread": spread}))
    assert difference(found, names, jumps) < DIGITS


def test_the_independent_solution_knows_the_beam():
    """Eq. 1 comes out of it: struck at its end across its length, a slender beam turns about 2/3."""
    one = rod((mpf(0), mpf(0)), 90, 1, 1)
    ((omega, vx, vz),) = solve([one], [], [(0, one.start, ((0, 1),))], falling(0))
    assert vx == 0
    assert abs(mpf(1) / 2 - vz / omega - mpf(2) / 3) < mpf(10) ** -45
    assert pointing(90)[0] == 1


# The claims


def the(beginning) -> Claim:
    """The one claim whose section and statement begin so."""
    (found,) = (claim for figure in FIGURES for claim in figure.claims if claim.statement.startswith(beginning))
    return found


LEANING, FLAT_EF, LINE = "lower leg at −15°", "E and F struck at 45°", "ankle's 75° counted from the line of the lower leg"
FOOT_LENGTHS = ["foot length halved", "foot length doubled"]
BETWEEN, AT_80 = "38° between torso and leg, torso backward", "80° between foot and leg"

OUTCOMES = {
    "Figure 1, beam A": (True, []),
    "Figure 1, beam B": (True, []),
    "Figure 1, beam C": (True, []),
    "Figure 1, beam D": (True, []),
    "Eq. 1": (True, []),
    "Section 2.1: pivot and CoPc": (True, []),
    "Section 2.1: the magnitude": (True, []),
    "Section 2.1: in 3D": (True, ["impact in a plane with the beam"]),
    "Eq. 2": (True, []),
    "Eq. 3": (True, ["sticking contact, impact 45° from across the beam"]),
    "Figure 1: r_p = p": (True, []),
    "Eq. 12": (False, ["with the absolute value of Δω_z"]),
    "Section 3.4: when the robot moves forward": (True, [LEANING]),
    "Section 3.4: upper bodies": (True, ["largest shock on the middle line of a body", "Figure 5 at 0°"]),
    "Section 3.4: the CoPc of a body tends": (True, ["lower leg", "Figure 5 at 0°"]),
    "Section 3.4: a design": (True, ["foot ends at the ankle", "struck 15° from the normal"]),
    "Section 3.4: two slender bodies": (True, ["struck 45° from the normal"]),
    "Section 3.4: for a body at the end": (True, []),
    "Section 4.1: the effect of the torso": (True, ["both struck at 45°", "both struck at 15°"]),
    "Section 4.1: flattening": (True, []),
    "Section 4.1: the foot reduces": (True, [LEANING, FLAT_EF, LINE]),
    "Footnote 4": (True, [LEANING, FLAT_EF, LINE]),
    "Figure 4": (True, ["case C"]),
    "Section 5: the torso": (True, ["distance in the plane", "Figure 5"]),
    "Section 5: sensitive equipment": (True, []),
    "Section 4.2: the radius": (True, [BETWEEN]),
    "Section 4.2: nowhere": (True, [BETWEEN]),
    "Section 4.2: two mounting": (True, [BETWEEN]),
    "Section 4.2: the CoPc": (True, [AT_80, "torso mass halved", "foot mass halved"]),
    "Section 4.2: so little": (True, []),
    "Section 4.2: other extreme": (
        True,
        ["torso backward", BETWEEN, AT_80, "torso mass halved", "leg mass doubled", "foot mass doubled", *FOOT_LENGTHS],
    ),
    "Footnote 5": (True, ["torso leaning, rotated about the axis across the sagittal plane"]),
    "Section 4.3: the torso is relatively": (True, ["legs bent by 10°", "legs bent by 0°"]),
    "Section 4.3: this changes": (True, []),
    "Section 4.3: the CoPc of the torso moves": (True, ["hind knee backward", "nose down"]),
    "Section 4.3: at 10°": (True, []),
    "Section 4.3: the front leg": (False, ["hind leg"]),
    "Section 3.1.2": (False, ["legs straight"]),
    "Section 4.3: the pattern": (True, []),
}
"""Whether each claim holds, and the other interpretations under which the outcome is different."""


@pytest.mark.parametrize("beginning", OUTCOMES)
def test_the_outcome_of_a_claim(beginning):
    """As computed under its interpretation; and no alternative is listed that does not change the outcome."""
    claim = the(beginning if ": " in beginning else f"{beginning}: ")
    assert (claim.holds, list(claim.alternatives)) == OUTCOMES[beginning]
    assert claim.holds == (claim.above < claim.value < claim.below)
    assert all((claim.above < value < claim.below) != claim.holds for value in claim.alternatives.values())


def test_every_claim_has_its_outcome():
    assert sum(len(figure.claims) for figure in FIGURES) == len(OUTCOMES) == 39
    readme = (own_robots_folder().parent / "README.md").read_text(encoding="utf-8")
    assert set(re.findall(r"(\d+) of the paper's (?:statements|claims)", readme)) <= {"39"}


def test_an_outcome_follows_from_the_value():
    """Strictly between the bounds; NaN never holds; what does not change the outcome is no alternative."""
    claim = Claim(
        "here: it is so",
        "size [1]",
        lambda size=1.0: size,
        interpretation="small",
        above=0.5,
        below=2.0,
        options={"same": {"size": 1.5}, "bound": {"size": 2.0}, "none": {"size": np.nan}},
    )
    assert claim.holds
    assert claim.criterion == "between 0.5 and 2"
    assert list(claim.alternatives) == ["bound", "none"]


def test_eq_3_holds_for_an_impact_across_the_beam():
    """A contact that sticks under an oblique impact at the end has r_p = 0.943 l, where Eq. 3 gives 0.589 l."""
    oblique = beam(0.0, angle=45.0, directions=("x", "y", "z"))
    assert float(oblique.ropc[0]) == pytest.approx(0.943, abs=5e-4)
    assert eq_3_radius(0.0, 45.0) == pytest.approx(0.589, abs=5e-4)
    assert the("Eq. 12").value == pytest.approx(-2.0 / 3.0)


def test_eq_6_is_the_partition_of_eq_4():
    """Contact at the joints: with the hip as the struck joint, Δq̇₂ = H₂₂⁻¹ H₂₁ q̇₁⁻ is what Eq. 4 gives."""
    robot = load_robot("leg", xacro={"torso": "true"})
    H = dynamics(robot, land("fig2_e").q[None]).H[0]
    struck, rest, v = np.arange(3), np.arange(3, len(H)), np.array([0.3, 0.0, -1.0])
    by_parts = np.linalg.solve(H[np.ix_(rest, rest)], H[np.ix_(rest, struck)] @ v)
    J_c = np.eye(len(H))[struck]
    whole = solve_impact(H[None], J_c[None], v[None, :, None], lambda _: J_c).delta_qd[0, :, 0]
    np.testing.assert_allclose(whole[struck], -v, atol=1e-14)
    np.testing.assert_allclose(whole[rest], by_parts, atol=1e-12)


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


def test_ratios_of_distances_are_ratios_of_shocks():
    """Eq. 2: the CoPc of case E's lower leg is 1.494 times as far from the knee as from the heel."""
    profile = land("fig2_e")
    low, high = middle_lines(profile)["lower_leg"]
    centre = profile.copc[profile.bodies.index("lower_leg")]
    ratio = np.linalg.norm(centre - high) / np.linalg.norm(centre - low)
    assert the("Section 3.4: the CoPc of a body").alternatives["lower leg"] == pytest.approx(ratio, rel=1e-12)
    assert ratio == pytest.approx(1.494, abs=0.001)


def test_the_copc_of_a_torso_lies_beside_it():
    """Eq. 1 gives its height; in the plane it is off by up to 0.41 of the torso's 0.6 m."""
    found = [(p, p.bodies.index("torso")) for p in map(land, ("fig2_d", "fig2_e", "fig2_f"))]
    beside = max(abs(p.copc[i, 0]) for p, i in found) / 0.6
    assert the("Section 5: the torso").alternatives["distance in the plane"] == pytest.approx(beside)


def test_a_foot_across_the_strike_scales_all_that_is_above():
    """Whatever the foot's mass does to the lower leg, it does to every body above: one common factor."""
    without = land("fig2_e")
    for heel in ("0", "0.03"):
        with_foot = land(changed(scene("fig2_f"), xacro={"heel": heel}))
        ratio = [largest(with_foot)[body] / shock for body, shock in largest(without).items()]
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-10)


def test_the_foot_by_its_links():
    """98 % of every link as drawn; counted from the lower leg's line, the lower leg keeps a third of its shock."""
    assert min(reductions().values()) == pytest.approx(98.34, abs=0.01)
    assert {body: round(value) for body, value in reductions(ankle=75.0).items()} == {"lower_leg": 66, "upper_leg": 95, "torso": 99}


@pytest.mark.parametrize(("forward", "backward"), [(105.0, -75.0), (75.0, -105.0)])
def test_toes_forward_or_backward_are_one_for_a_slender_foot(forward, backward):
    """An impact at one end of a beam has the same effect as at the other: 105° forward is 75° backward."""
    assert reductions(ankle=forward) == pytest.approx(reductions(ankle=backward), abs=1e-9)


def test_no_case_slips_as_drawn():
    """The impulse by its components, and the friction coefficient of the claim."""
    impulses = np.array([land(f"fig2_{letter}").contacts[0].impulse for letter in "abcdef"])
    needed = np.abs(impulses[:, 0]) / impulses[:, 2]
    assert the("Footnote 4").value == pytest.approx(needed.max(), rel=1e-12) == pytest.approx(0.427, abs=0.001)


def test_a_rotated_imu_bears_sqrt_2_of_a_jump_along_an_axis():
    """√2 on an upright torso; a torso that leans by 39.22° loses if the IMU is rotated the way it leans."""
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
    text = (own_robots_folder() / "scenes" / "fig3.toml").read_text() + (own_robots_folder() / "skippy.urdf.xacro").read_text()
    assert text.count("assumed") + text.count("ASSUMED") >= 12
    assert "Assumed" in FIGURES[2].note


@pytest.mark.parametrize("profile", [lambda: land("fig3"), lambda: skippy(hip=-38.0, leg_mass="0.6")])
def test_skippys_centre_of_mass_is_above_its_toe(profile):
    x, y, z = above_contact(profile())
    assert abs(x) < 1e-4
    assert abs(y) < 1e-12
    assert z > 0.2


# Scenes, figures and command


def test_every_panel_has_its_scene_and_every_scene_computes():
    panels = {panel.scene for figure in FIGURES for panel in figure.panels}
    assert {path.stem for path in (own_robots_folder() / "scenes").glob("*.toml")} == panels | {"five_bar"}
    for stem in panels | {"five_bar"}:
        profile = land(stem)
        assert {warning.kind for warning in profile.health.warnings} <= {"height"}, "the beam is no foot, and nothing else is wrong"
        assert profile.health.error_bound < 1e-11
        assert abs(profile.contacts[0].point[2]) < 1e-4


def test_figures_are_drawn_as_the_claims_interpret_them():
    """The defaults of the models are the scenes: same shocks."""
    shown = {f"fig2_{letter}": profile for letter, profile in zip("abcdef", cases(), strict=True)}
    shown |= {f"fig5_{angle:02.0f}": quadruped(angle) for angle in ANGLES} | {"fig3": skippy()}
    for stem, profile in shown.items():
        np.testing.assert_allclose(profile.shock_com, land(stem).shock_com, atol=2e-5)  # the scene rounds the pitch


def test_the_page_of_models_has_their_arguments_and_results():
    """A row for every model and for every scene, with what the files say and compute."""
    folder = own_robots_folder()
    page = (folder / "README.md").read_text(encoding="utf-8")
    rows = {folder / file: row for row, file in re.findall(r"^(\| \[`\w+`\]\((\S+)\).*)$", page, re.MULTILINE)}
    models = {entry.path: load_robot(entry.name) for entry in catalogue() if entry.path.parent == own_robots_folder()}
    scenes = sorted((folder / "scenes").glob("*.toml"))
    assert list(rows) == [*models, *scenes]
    for path, robot in models.items():
        arguments = ", ".join(f"`{name}`" for name in re.findall(r'<xacro:arg name="(\w+)"', path.read_text()))
        assert rows[path].endswith(f"| {len(robot.bodies)} | {robot.mass:.4g} | {arguments} |")
    for path in scenes:
        found = land(path.stem)
        shock = ", ".join(f"{body} {value:.3f}" for body, value in zip(found.bodies, found.shock_com, strict=True))
        assert rows[path].endswith(f"| {found.scene.strike.strike_angle_deg or 0.0:g}° | {shock} |")


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: str(figure.number))
def test_a_figure_names_its_panels_and_bodies(figure):
    drawing = draw_paper_figure(figure)
    words = "\n".join(text.get_text() for text in drawing.axes[0].texts)
    assert all(panel.label in words and panel.words in words for panel in figure.panels)
    assert all(body.replace("_", " ") in words for profile in figure.profiles for body in profile.bodies)


def test_the_command_writes_what_it_computes(capfd, tmp_path):
    out = good(capfd, "paper", "fig1", "--out", tmp_path / "paper")
    assert "1 A     beam  translates" in out
    assert "claims of the paper: 9 hold, 2 hold as interpreted, but not under an alternative, 1 do not hold\n" in out
    scenes = {f"fig1_{letter}.toml" for letter in "abcd"}
    files = scenes | {"bodies.csv", "claims.csv", "figure1.png", "figure1.svg", "paper.md", MANIFEST}
    assert {path.name for path in (tmp_path / "paper").iterdir()} == files
    again = run(capfd, "analyze", tmp_path / "paper" / "fig1_c.toml", "--format", "csv").out
    assert again.splitlines()[1].startswith("percussion,beam,1.5")
    assert "![Figure 1: a slender beam on a slider](figure1.svg)" in (tmp_path / "paper" / "paper.md").read_text()
    rows = (tmp_path / "paper" / "claims.csv").read_text().splitlines()
    assert len(rows) == 1 + sum(1 + len(claim.alternatives) for claim in FIGURES[0].claims)


def test_the_figure_of_skippy_says_what_is_assumed(capfd, tmp_path):
    good(capfd, "paper", "3", "--out", tmp_path)
    svg = (tmp_path / "figure3.svg").read_text()
    assert "Assumed, not published with the paper" in svg
    assert "<dc:date>" not in svg


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("7", 'no figure "7" in the paper; there are: "1", "2", "3", "5". To list them: shockpc paper --help'),
        ("Figure 4", "Figure 4 of the paper is a photograph of a leg prosthesis"),
        ("4", "the claim in its caption is listed with figure 2: shockpc paper 2"),
    ],
)
def test_a_figure_that_cannot_be_drawn(capfd, name, said):
    outcome = run(capfd, "paper", name)
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err
