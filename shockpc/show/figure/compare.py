"""The figure of a comparison: the designs side by side, in one colour scale."""

import textwrap

from matplotlib.figure import Figure

from shockpc.printed import printable
from shockpc.show.figure.canvas import render
from shockpc.show.figure.landing import numbered
from shockpc.show.figure.panels import draw_panels
from shockpc.show.figure.view import view_of
from shockpc.show.header import contact_name, joint_model_text
from shockpc.show.tables.compare import letters
from shockpc.studies.compare import Comparison

__all__ = ["compare_figure", "draw_comparison"]

WIDE = 34
"""Letters in a line under a panel."""


def compare_figure(comparison: Comparison) -> dict[str, bytes]:
    """The figure as SVG and PNG, by file name."""
    return {f"compare.{format_}": data for format_, data in render(lambda: draw_comparison(comparison)).items()}


def draw_comparison(comparison: Comparison) -> Figure:
    """Draw each design; numbered are the bodies between contact and base of each, and its heaviest one."""
    profiles = comparison.profiles
    views = [view_of(profile) for profile in profiles]
    chosen = [[profile.bodies[i] for i in numbered(profile, view)] for profile, view in zip(profiles, views, strict=True)]
    names = list(dict.fromkeys(name for own in chosen for name in own))
    numbers = [{i: names.index(name) + 1 for i, name in enumerate(profile.bodies) if name in names} for profile in profiles]
    captions = [
        [*textwrap.wrap(printable(design.label, 4 * WIDE), WIDE), f"on {printable(contact_name(profile), WIDE)}"]
        for design, profile in zip(comparison.designs, profiles, strict=True)
    ]
    models = " or ".join(dict.fromkeys(joint_model_text(profile) for profile in profiles))
    title = "Shock of " + " and ".join(dict.fromkeys(printable(profile.robot.label, 40) for profile in profiles))
    return draw_panels(
        profiles, views, numbers, f"{title}: designs side by side", f"joint model: {models}", letters(comparison), captions
    )
