"""A row of a sweep as options of `shockpc analyze`."""

import shlex

from shockpc.evaluation.variations.rows import VariedLandings
from shockpc.landing.scenes.scene import Scene


def row_text(landings: VariedLandings, row: int) -> str:
    """The variations of a row in words: options of `shockpc analyze`, and what has none."""
    options, without_option = row_options(landings, row)
    if options and without_option:
        return f"{options}   (and {without_option})"
    return options or without_option


def row_options(landings: VariedLandings, row: int) -> tuple[str, str]:
    """The variations of a row as options of `shockpc analyze`, and what has no option."""
    scene, _ = landings.case(row)
    options: list[tuple[str, str]] = []
    without_option: list[str] = []
    for varied, value in landings.values_of(row).items():
        of_value = varied.kind.options(varied, value, scene, landings.scene)
        if of_value is None:
            unit = "x" if varied.factor else varied.unit
            without_option.append(f"{varied.subject} = {value:g} {unit}")
        else:
            options += of_value
    if landings.separate:
        options += _closed_loops(scene, landings.scene)
    words: list[str] = []
    for option in dict.fromkeys(options):
        words += option
    return shlex.join(words), ", ".join(without_option)


def _closed_loops(scene: Scene, base: Scene) -> list[tuple[str, str]]:
    """Options for the joints that close loops, as they were followed.

    Args: scene, of the row; base, that varies.
    """
    options = []
    for name in scene.assemble:
        value = scene.posture.joints_deg.get(name)
        if value is not None:
            options.append(("--set", f"{name}={value!r}"))
    # No option takes the rotation of a ball joint, which follows from the other joints.
    assembled = [name for name in scene.assemble if name in scene.posture.joint_quaternions]
    if not assembled and not base.assemble:
        assembled = list(scene.assemble)
    return options + [("--assemble", name) for name in assembled]
