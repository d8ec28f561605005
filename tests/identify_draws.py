"""How often the 95 % intervals of `shockpc identify` hold the true values: simulated landings with
noise, drawn anew each time.

python tests/identify_draws.py 300
"""

import sys
from pathlib import Path

import numpy as np
from robot_texts import joint, link, urdf

import shockpc
from shockpc import Contact, Scene
from shockpc.evaluation.variations.vary import variation
from shockpc.landing.resolve import landing_of
from shockpc.landing.scenes.scene_file import robot_of

BLOCKS = Path(__file__).parents[1] / "robots" / "measured" / "elbow" / "elbow.urdf"
FREE = '<limit effort="1" velocity="1" lower="-3" upper="3"/>'
BELOW = '<origin xyz="0 0 -0.25"/>'
LIGHT = (
    '<origin xyz="0 0 -0.12"/><inertia ixx="0.003" ixy="0" ixz="0" iyy="0.003" iyz="0" '
    'izz="0.0005"/>'
)
LEG = urdf(
    '<link name="world"/>',
    link("hub", "2"),
    link("thigh", "0.6", LIGHT),
    link("shank", "0.25", LIGHT),
    '<link name="foot"/>',
    joint("rail", "world", "hub", "prismatic", "0 0 1", FREE),
    joint("hip", "hub", "thigh", more=FREE),
    joint("knee", "thigh", "shank", more=FREE + BELOW),
    joint("sole", "shank", "foot", "fixed", more=BELOW),
    name="leg",
)
"""A leg of two links on a rail."""


def simulated(scene, table, true, noise, rng):
    """A table of landings with the jumps for true values by subject, and normal noise on the
    velocities after (by column).
    """
    from shockpc.wings.recordings.identify.predictor import Predictor
    from shockpc.wings.recordings.tables.reader import rows_of

    robot = robot_of(scene)
    n = len(next(iter(table.values())))
    table = {**table, **{f"after_{name}": np.zeros(n) for name in noise}}
    rows = rows_of(table, landing_of(scene, robot))
    known = tuple(
        variation(robot, subject, f"0:{max(2.0 * value, 1.0)}") for subject, value in true.items()
    )
    predictor = Predictor(rows, robot, known, rows.measured)
    jumps = predictor(tuple(true.values())).jumps
    for column, jump in zip(predictor.measured, jumps.T, strict=True):
        before = table.get(f"before_{column.name}", np.zeros(n))
        table[f"after_{column.name}"] = before + jump + noise[column.name] * rng.normal(size=n)
    kept = np.isfinite(jumps).all(axis=1)
    return {name: np.asarray(values)[kept] for name, values in table.items()}


def blocks(rng, n, true=None, noise=1.0):
    """Two hinged blocks that fall on a corner, thrown at random."""
    true = {"friction": 0.3, "restitution": 0.25} if true is None else true
    quaternion = rng.normal(size=(n, 4))
    quaternion /= np.linalg.norm(quaternion, axis=1)[:, None]
    table = {f"q{axis}": values for axis, values in zip("wxyz", quaternion.T, strict=True)}
    table |= {
        "q_hinge_1_to_2": rng.uniform(-2.0, 2.0, n),
        "before_hinge_1_to_2": rng.normal(size=n),
    }
    table |= {f"before_v{axis}": rng.normal(0.0, 0.5, n) - 1.5 * (axis == "z") for axis in "xyz"}
    table |= {f"before_w{axis}": rng.normal(0.0, 1.0, n) for axis in "xyz"}
    spread = {
        **{f"v{axis}": 0.1 * noise for axis in "xyz"},
        **{f"w{axis}": noise for axis in "xyz"},
        "hinge_1_to_2": noise,
    }
    return simulated(Scene(robot=str(BLOCKS), contact="elbow_1_corner_1"), table, true, spread, rng)


def leg(rng, n, folder, true=None, noise=0.05, alike=0.0):
    """A leg on a rail that lands in different postures, or nearly in one."""
    (folder / "leg.urdf").write_text(LEG)
    true = {"armature:hip": 0.004, "armature:knee": 0.009} if true is None else true
    hip, knee = (
        middle + (alike if alike else 0.5) * rng.uniform(-1.0, 1.0, n) for middle in (0.7, -1.4)
    )
    table = {"q_hip": hip, "q_knee": knee, "before_rail": -rng.uniform(1.0, 2.0, n)}
    table |= {
        f"before_{name}": rng.normal(0.0, 0.0 if alike else 0.5, n) for name in ("hip", "knee")
    }
    return simulated(leg_scene(folder), table, true, {"hip": noise, "knee": noise}, rng)


def csv_text(table):
    """A table as the text of a CSV file."""
    return (
        "\n".join(
            [
                ",".join(table),
                *(",".join(map(str, row)) for row in zip(*table.values(), strict=True)),
            ]
        )
        + "\n"
    )


def leg_scene(folder):
    """Of the leg."""
    return Scene(
        robot=str(folder / "leg.urdf"), contact=Contact(frame="foot", directions=("x", "z"))
    )


def coverage(make, scene, true, ranges, draws):
    """Write how often the interval of each unknown holds the true value, of those that have one,
    and how wide it is.
    """
    held = {name: [] for name in true}
    found, widths = ({name: [] for name in true} for _ in range(2))
    for seed in range(draws):
        for one in shockpc.identify(make(np.random.default_rng(seed)), scene, ranges).unknowns:
            name = one.variation.subject
            found[name].append(one.value)
            if one.state == "identified":
                held[name].append(one.low <= true[name] <= one.high)
                widths[name].append(one.high - one.low)
    for name, value in true.items():
        n, share = len(held[name]), 100.0 * float(np.mean(held[name] or [np.nan]))
        error = np.sqrt(share * (100.0 - share) / max(n, 1))
        text = (
            f"held in {share:.1f} ± {error:.1f} % of {n} intervals, {draws - n} draws without one"
        )
        middle, width = np.median(found[name]), np.median(widths[name] or [np.nan])
        sys.stdout.write(
            f"  {name} = {value:g}: {text}; median value {middle:.4g}, width {width:.2g}\n"
        )
        sys.stdout.flush()


def main(draws):
    """All cases."""
    import tempfile

    true = {"friction": 0.3, "restitution": 0.25}
    scene = Scene(robot=str(BLOCKS), contact="elbow_1_corner_1")
    sys.stdout.write("80 tosses of two blocks\n")
    coverage(
        lambda rng: blocks(rng, 80), scene, true, {"friction": "0:1.5", "restitution": "0:1"}, draws
    )
    with tempfile.TemporaryDirectory() as folder:
        true = {"armature:hip": 0.004, "armature:knee": 0.009}
        ranges = dict.fromkeys(true, "0.0003:0.3:log")
        for n in (10, 30):
            sys.stdout.write(f"{n} landings of a leg on a rail in different postures\n")
            leg(np.random.default_rng(0), n, Path(folder))
            coverage(
                lambda rng, n=n: leg(rng, n, Path(folder)),
                leg_scene(Path(folder)),
                true,
                ranges,
                draws,
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 300)
