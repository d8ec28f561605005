"""`shockpc compare`: designs side by side."""

from shockpc.cli.declare import argument, command, group
from shockpc.cli.options import QUANTITY, OutputOptions, SceneOptions
from shockpc.cli.parse import pair_of, robot_name

_in_designs = group("Designs")


@command(
    'shockpc compare go2 --contact FL_foot --change "mass:*_calf=0.9x"',
    "shockpc compare anymal_b anymal_c --contact LF_FOOT --out compare/",
    more=(
        "The options of the landing hold for every design. One --contact is for all; with as many as there are designs,"
        " each has its own."
    ),
)
def compare(
    *,
    designs: tuple[str, ...] = argument("Robot files, robots by name or scenes (TOML).", "DESIGN...", robot_name, default=...),
    change: tuple[str, ...] = _in_designs(
        "A change of the one design, such as 'mass:*_shank=0.9x; armature:*=0.01', which makes another design; "
        "mass, inertia (a factor), com-x, com-y, com-z (moved by) of links, armature of joints, place of joints, fixed ones too, "
        "in the frame of the link that carries them, such as 'place:*_KFE=0,0,-0.3' or =1.1x for longer thighs.",
        "CHANGES",
    ),
    pair: tuple[tuple[str, str], ...] = _in_designs(
        "Partners of different names: a body, joint or point of the first design and of the others; with a * in both, which stands "
        "for the same. Others are partners by name.",
        "A=B",
        pair_of,
    ),
    quantity: tuple[str, ...] = QUANTITY,
    options: SceneOptions,
    output: OutputOptions,
) -> None:
    from shockpc.cli.output import emit
    from shockpc.cli.scenes import one_scene
    from shockpc.robot.changes import read_changes
    from shockpc.show.reports.compare import compare_report
    from shockpc.studies.compare import Design, design_with
    from shockpc.studies.compare import compare as study
    from shockpc.text.errors import StudyError

    if change and len(designs) > 1:
        raise StudyError("--change makes other designs of one, but several are given; give one design, or a file for each")
    changes = [read_changes(text) for text in change]
    one_each = len(options.contact) == len(designs) > 1 and not options.together
    own = [options._replace(contact=(name,)) for name in options.contact] if one_each else [options] * len(designs)
    every = []
    for name, own_options in zip(designs, own, strict=True):
        robot, scene = one_scene(name, own_options)
        every.append(Design(name, scene, robot))
    every += [design_with(every[0], design_change) for design_change in changes]
    emit(compare_report(study(every, quantity, pair)), output)
