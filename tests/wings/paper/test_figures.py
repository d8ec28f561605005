"""Figures of the paper: labels, centres of percussion, pins and numbers."""

import itertools

import numpy as np
import pytest
import shapely
from test_figure import outside, words

from shockpc.show.figure.silhouette import to_plane
from shockpc.show.figure.style import settings
from shockpc.show.figure.view import view_of
from shockpc.wings.paper.report import paper_picture
from shockpc.wings.paper.study import FIGURES, paper_figures


def paper_figure(number):
    """A figure of the paper, its profiles, and the axes of its panels."""
    figure = next(figure for figure in FIGURES if figure.number == number)
    drawing = paper_picture(figure).draw()
    return drawing, figure.profiles, drawing.axes[1 : 1 + len(figure.panels)]


@pytest.mark.slow
@pytest.mark.parametrize("number", [1, 2, 3, 5])
def test_labels_of_a_paper_figure_keep_apart(number):
    """No label lies on another or on the number of a body, and no text leaves the page."""
    with settings():
        drawing, _, panels = paper_figure(number)
        assert outside(drawing) == []
        for axes in panels:
            boxes = [text.get_window_extent() for text in axes.texts]
            assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))


@pytest.mark.parametrize("number", [2, 3, 5])
def test_every_centre_of_percussion_is_in_the_panel_or_in_its_caption(number):
    """A crossed circle, or its coordinates under the panel."""
    drawing, profiles, panels = paper_figure(number)
    written = "\n".join(words(drawing))
    for profile, axes in zip(profiles, panels, strict=True):
        marks = np.array(
            [line.get_xydata()[0] for line in axes.lines if line.get_markersize() == 8.0]
        ).reshape(-1, 2)
        for place in to_plane(profile.copc_world, profile.plane)[~profile.translates]:
            inside = np.linalg.norm(marks - place, axis=1).min(initial=np.inf) < 1e-9
            x, z = place.round(2) + 0.0
            assert inside != (f"at ({x:.2f}, {z:.2f}) m".replace("-", "−") in written)


def test_every_pin_of_a_loop_has_its_dot():
    """Figure 3: hip, ankle, motor, crank pin, and the pin of rod and leg that closes the loop."""
    _, (profile,), (axes,) = paper_figure(3)
    dots = np.array([line.get_xydata()[0] for line in axes.lines if line.get_markersize() == 2.6])
    places = [
        profile.position[profile.bodies.index(body)] for body in ("leg", "foot", "crank", "rod")
    ]
    for frame in ("rod_end", "leg_lever"):
        end = profile.robot.frame(frame)
        places.append(profile.position[end.body] + profile.rotation[end.body] @ end.offset)
    assert len(dots) == 5
    assert all(
        np.linalg.norm(dots - pin, axis=1).min() < 1e-9
        for pin in to_plane(np.array(places), profile.plane)
    )


def test_numbers_of_thin_links_are_beside_them():
    """The links of the paper's leg are thinner than a ring with a number, which then covers no
    link.
    """
    figure = next(figure for figure in paper_figures(("2",)))
    drawn = paper_picture(figure).draw()
    panels = [
        axes for axes in drawn.axes if any(line.get_markersize() == 9.5 for line in axes.lines)
    ]
    for axes, profile in zip(panels, figure.profiles, strict=True):
        bodies = shapely.union_all([one.region for one in view_of(profile).drawn])
        rings = [line.get_xydata()[0] for line in axes.lines if line.get_markersize() == 9.5]
        inch = np.ptp(axes.get_xlim()) / (axes.get_position().width * drawn.get_figwidth())
        assert len(rings) == len(profile.bodies)
        assert (
            min(bodies.distance(shapely.Point(place)) for place in rings)
            > 0.9 * 9.5 / 2.0 / 72.0 * inch
        )
