"""Names: one rule for links, bodies, joints, contacts and points, in every command."""

import json

import pytest
import robot_texts
from commands import good, run
from robot_texts import joint, link, urdf
from trees import known_robot, robot_from

from shockpc.evaluation.variations.vary import read_changes
from shockpc.landing.contact import landing_frames, match_contacts
from shockpc.landing.scenes.scene import Scene
from shockpc.landing.scenes.scene_file import points_at
from shockpc.profile import shock_profile
from shockpc.robot.changes import changed, links_with_mass
from shockpc.studies.sweep.study import sweep
from shockpc.text.errors import UnknownName
from shockpc.text.names import match, matches

FEET = ("LF_FOOT", "LH_FOOT", "RF_FOOT", "RH_FOOT")
NAMES = ("foot[1]", "foot1", "foot*", "Foot", "leg?", "foot1")


@pytest.mark.parametrize(
    ("pattern", "found"),
    [
        ("foot[1]", ("foot[1]",)),
        ("foot*", ("foot*",)),
        ("leg?", ("leg?",)),
        ("foot[[]*", ("foot[1]",)),
        ("foot?", ("foot1", "foot*")),
        ("f*", ("foot[1]", "foot1", "foot*")),
        ("[Ff]oot*", ("foot[1]", "foot1", "foot*", "Foot")),
        ("FOOT", ()),
        ("oot", ()),
        ("", ()),
    ],
)
def test_an_exact_name_goes_before_a_glob_and_case_counts(pattern, found):
    """An exact name is that name even where it would be a glob; each name once, in order; a part of
    a name means nothing.
    """
    assert matches(pattern, NAMES) == found


@pytest.mark.parametrize(
    ("pattern", "words"),
    [
        ("lf_kne_", ("nearest:", '"lf_knee"')),
        ("knee", ('"*knee*" matches "lf_knee", "rf_knee"',)),
        ("KNEE", ('"*knee*" matches "lf_knee", "rf_knee"',)),
        ("LF_KNEE", ("nearest", '"lf_knee"')),
        ("?", ('"lf_knee"', '"rf_knee"')),
    ],
)
def test_what_means_nothing_is_answered_with_the_nearest_and_a_glob(pattern, words):
    with pytest.raises(UnknownName) as refusal:
        match(pattern, ("lf_knee", "rf_knee"), "joint", 'robot "dog"', "shockpc robots dog")
    assert refusal.value.name == pattern
    assert all(
        word in str(refusal.value)
        for word in (f'no joint "{pattern}" in robot "dog"', *words, "shockpc robots dog")
    )


# Contacts


@pytest.mark.parametrize(
    ("name", "feet"), [("talos", ("left_sole_link", "right_sole_link")), ("anymal_b", FEET)]
)
def test_an_unknown_contact_is_answered_with_the_feet(name, feet):
    with pytest.raises(UnknownName) as refusal:
        match_contacts(known_robot(name), "foot")
    assert all(f'"{foot}"' in str(refusal.value) for foot in feet)


@pytest.mark.parametrize("pattern", ["LF_FOTO", "*_foot", "*_KFE", ""])
def test_a_contact_glob_means_no_joints(pattern):
    """A joint is a frame too, but one that only its exact name means."""
    assert match_contacts(known_robot("anymal_b"), "LF_KFE") == ("LF_KFE",)
    with pytest.raises(UnknownName, match="LF_FOOT"):
        match_contacts(known_robot("anymal_b"), pattern)


def test_a_glob_means_sites_and_geoms_of_an_mjcf(tmp_path):
    """Links, sites and geoms that move; what is fixed to the world is a contact of no landing."""
    parts = robot_texts.BODY + '<site name="toe_site"/><geom name="toe_geom" size="0.1" mass="0"/>'
    text = robot_texts.mjcf(
        '<site name="toe_world"/>' + robot_texts.floating(robot_texts.body("toe", parts))
    )
    robot = robot_texts.loaded(tmp_path, text, "dog.xml")
    assert set(match_contacts(robot, "toe*")) == {"toe", "toe_site", "toe_geom"}
    assert landing_frames(robot, "toe_s* + toe_g*") == [("toe_site", "toe_geom")]
    assert [
        robot.bodies[i].name for name in ("toe_site", "toe_g*") for i in robot.match_bodies(name)
    ] == ["toe", "toe"]


# Links and bodies


def test_a_glob_of_points_with_an_offset():
    points = points_at(known_robot("anymal_b"), "L?_FOOT:0,0,0.1")
    assert [(point.frame, point.offset) for point in points] == [
        (name, (0.0, 0.0, 0.1)) for name in FEET[:2]
    ]


LINK = ["anymal_b", "--contact", "LF_FOOT"]


@pytest.mark.parametrize(
    "words",
    [
        ("analyze", *LINK, "--format", "csv", "--body"),
        ("sweep", *LINK, "--vary", "speed=1,2", "--rows", "csv", "--out", "out", "--body"),
        ("place", *LINK, "--within", "0:0.1,0:0.1,0:0.1", "--format", "csv", "--body"),
    ],
    ids=lambda words: words[0],
)
def test_a_link_means_its_body(capfd, tmp_path, monkeypatch, words):
    """What is printed for a link that is fixed to a body is what is printed for the body."""
    printed = []
    for name in ("imu_link", "base", "LF_FOOT"):
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        printed.append(good(capfd, *words, name))
    assert printed[0] == printed[1] != printed[2]


def test_one_body_is_asked_for(capfd):
    outcome = run(capfd, "place", *LINK, "--body", "*_SHANK")
    assert outcome.code == 2
    assert all(word in outcome.err for word in ('no single body "*_SHANK"', '_SHANK", "'))


# Masses


def heavy(share):
    """A base of 2 kg with a plate, which holds a share of the mass of their body, and a leg."""
    mass = 2.0 * share / (1.0 - share)
    return robot_from(
        urdf(
            link("base", "2"),
            link("plate", repr(mass)),
            link("leg"),
            joint("weld", "base", "plate", "fixed"),
            joint("hip", "base", "leg"),
        )
    )


@pytest.mark.parametrize(
    ("share", "pattern", "warned"),
    [
        (0.009, "plate", True),
        (0.011, "plate", False),
        (0.009, "base", False),
        (0.009, "*", False),
        (0.009, "p*", True),
    ],
)
@pytest.mark.parametrize("what", ["mass", "inertia", "com-x"])
def test_a_change_of_less_than_a_hundredth_of_a_body_is_a_warning(share, pattern, warned, what):
    """All changed links of a body count together; the warning holds their share, and names the link
    with the most mass.
    """
    robot = changed(
        heavy(share), read_changes(f"{what}:{pattern}={'0.01' if what == 'com-x' else '2x'}")
    )
    found = [(one.subject, one.value) for one in robot.change_warnings]
    assert found == ([("base", pytest.approx(share))] if warned else [])
    assert all('main link "base" (2 kg)' in one.text for one in robot.change_warnings)


def test_a_part_without_mass_names_the_main_link():
    robot = heavy(0.0)
    with pytest.raises(
        UnknownName, match='"plate" has no mass; the main link of its body is "base"'
    ):
        changed(robot, read_changes("mass:plate=2x"))
    assert links_with_mass(robot, "*") == {"base": 2.0, "leg": 1.0}


def test_the_warning_reaches_the_commands(capfd, tmp_path):
    """ANYmal B's base link has a millionth of its body's mass."""
    words = (
        '"base" has 6e-06 % of the mass of its body; to change the body, name its main link '
        '"base_inertia" (16.79 kg)'
    )
    assert words in good(capfd, "compare", *LINK, "--change", "mass:base=2x")
    document = json.loads(
        good(capfd, "compare", *LINK, "--change", "mass:base=2x", "--format", "json")
    )
    assert words in json.dumps(document, ensure_ascii=False).replace('\\"', '"')
    assert words in good(capfd, "sweep", *LINK, "--vary", "mass:base=1x,2x", "--out", tmp_path)


def test_a_glob_of_masses_is_varied_as_it_is_changed():
    """A row of a sweep is the landing of the robot with that change."""
    robot, scene = known_robot("anymal_b"), Scene(robot="anymal_b", contact="LF_FOOT")
    (chunk,) = sweep(scene, {"mass:*_SHANK": "1x,2x"}, robot=robot, at=["imu_link"])
    (point,) = shock_profile(scene, changed(robot, read_changes("mass:*_SHANK=2x"))).points
    assert chunk.columns["shock@imu_link"][1] == pytest.approx(point.shock, rel=1e-12)
    assert chunk.columns["shock@imu_link"][0] != pytest.approx(point.shock, rel=1e-3)
