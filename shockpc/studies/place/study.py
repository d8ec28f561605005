"""The place on a body where a sensor has the smallest shock over some landings."""

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Annotated, NamedTuple

import numpy as np

from shockpc.core.low_pass import peak_of
from shockpc.core.spatial import Array
from shockpc.evaluation.declare import study
from shockpc.evaluation.drive_ends import MOVED, End, at_drive_ends
from shockpc.evaluation.named_scenes import common_robot, named_scenes, with_default_landings
from shockpc.evaluation.profiles import profiles_and_failures
from shockpc.evaluation.table import Table
from shockpc.evaluation.unused_ground import refuse_ground
from shockpc.evaluation.variations.scene_grid import scene_grid
from shockpc.evaluation.variations.vary import Vary, pairs
from shockpc.landing.bandwidths import scene_low_pass
from shockpc.landing.places import Place, point_place, point_places
from shockpc.landing.resolve import pulse_of
from shockpc.landing.scenes.scene import Point, Scene
from shockpc.landing.scenes.scene_fields import SOFT, Option
from shockpc.landing.scenes.strike import GRAVITY
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.studies.place.best_first import best_places, box_faces
from shockpc.studies.place.cone import ACCURACY, Optimum
from shockpc.studies.place.field import Fields, fields_of
from shockpc.studies.place.region import Box, Region, region_of
from shockpc.text.display import brief, shown_by
from shockpc.text.errors import ShockError, StudyError
from shockpc.text.printed import count

NEAREST = 1e-3
"""Smallest distance between alternatives [m]."""

EQUAL_SHARE = 1.0 - 1e-6
"""Share of the largest shock from which others are equal to it.

Rounding makes them differ; the first is named.
"""

EQUAL = 0.01
"""Share by which largest shocks may exceed the smallest one for the mean over landings to decide.

On all level feet a robot rotates little, so that many places are nearly equal; the landings on some
of them tell these apart.
"""


class AxisPeaks(NamedTuple):
    """Peaks of a pulse along the axes of a sensor, and what is left of its range.

    Attributes:
        peak_g: (3,) largest peak acceleration along each of its axes, in multiples of gravity.
        left: (3,) share of the range that is left along each axis, below zero where it saturates
            [1]; None without a range.
    """

    peak_g: Array
    left: Array | None


class SensorPlace(NamedTuple):
    """A place on the body and the shock that it sees; all numbers are proven ones.

    Attributes:
        name: of the sensor or point that is there today; "best", "2nd" and so on for a new one.
        position: (3,) in the body's frame [m].
        shocks: (L,) in each landing [1].
        combined: the number by which places are compared, the largest of them [1].
        delta_v: (L, 3) jump of velocity in the axes of the sensor, which for a new place are those
            of the body [m/s].
        bound: no allowed place has less than this [1]; None for what is there today.
        margin: for the pulse of the scenes; None without one.
    """

    name: str
    position: Array
    shocks: Array
    combined: float
    delta_v: Array
    bound: float | None
    margin: AxisPeaks | None


@dataclass(frozen=True, eq=False)
class PlaceStudy:
    """The places on a body where a sensor has the smallest shock.

    Attributes:
        robot: the robot.
        body: index of the body.
        region: where a sensor may be.
        landings: names of the landings that were computed.
        profiles: their results.
        fields: shock over the body, and the number by which places are compared.
        today: the body's sensors, and the points that the scenes name.
        places: the best place and its alternatives.
        combined: the number by which places are compared, at the best one [1].
        least: the minimum such number in the region; of landings on feet that are level and on some
            of them, the best place is that of the smallest mean among those within 1 % of it [1].
        bound: nothing in the region is below this [1].
        apart: distance of the alternatives along at least one axis [m].
        failures: name and error of the landings that could not be computed.
        ends: the study with all drives at the smallest inertias that what is known allows, and at
            the largest, or why there is none; empty where all drives are known exactly.
    """

    robot: Robot
    body: int
    region: Region = field(repr=False)
    landings: tuple[str, ...]
    profiles: tuple[ShockProfile, ...] = field(repr=False)
    fields: Fields = field(repr=False)
    today: tuple[SensorPlace, ...]
    places: tuple[SensorPlace, ...]
    combined: float
    least: float
    bound: float
    apart: float
    failures: tuple[tuple[str, ShockError], ...]
    ends: Mapping[End, "PlaceStudy | ShockError"] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("studies.place.report:place_report")

    def __repr__(self) -> str:
        body = self.robot.bodies[self.body].name
        return brief(self, f"{self.robot.name}, body {body}", count(len(self.places), "place"))

    @property
    def table(self) -> Table:
        """A row for each present sensor and for each place found, with the bound of the latter."""
        header = (
            *("place", "x [m]", "y [m]", "z [m]", "maximum shock [-]", "in landing"),
            *("present", "bound [-]"),
        )
        rows = []
        for sensor in (*self.today, *self.places):
            largest = sensor.shocks.max()
            first = (sensor.shocks >= EQUAL_SHARE * largest).argmax()
            shock = largest, self.landings[first], sensor.bound is None, sensor.bound
            rows.append((sensor.name, *sensor.position, *shock))
        return Table.of_rows(header, rows)

    @property
    def gap(self) -> float:
        """Difference between the smallest number and what is proven to be a lower bound [1]."""
        return max(0.0, self.least - self.bound)

    def better(self, sensor: SensorPlace) -> float:
        """By how much the best place is better than another one, as a share of its shock [1]."""
        if self.combined > 0.0:
            return max(0.0, sensor.combined / self.combined - 1.0)
        return math.inf if sensor.combined > 0.0 else 0.0

    @property
    def kept(self) -> SensorPlace | None:
        """The present sensor than which no place is better by more than 1 %; else None."""
        best = min(self.today, key=lambda sensor: sensor.combined, default=None)
        if best is None or self.better(best) > MOVED:
            return None
        return best

    @property
    def complete(self) -> bool:
        """True if the gap is at most a millionth of the number."""
        return self.gap <= 1e-6 * max(self.least, 1e-3)


@study(
    "shockpc place anymal_b --vary strike-angle=-30:75:4",
    more=(
        "Without --contact the landings are those on all level feet together, on each edge of "
        "their support, and on each foot. Places are compared by the maximum shock over all "
        "landings. The optimum over the body is exact up to the stated gap; the shock at the "
        "places is exact. --pulse (or --imu-bandwidth) with --range-g also gives the unused range "
        "of a sensor along each axis."
    ),
    # What `refuse_ground` refuses, and parts, whose places are given.
    without=(
        SOFT,
        "part",
    ),
    uses=("pulse", "imu-bandwidth", "range-g"),
    reads="landings",
    passed=("progress",),
    fails=True,
)
def place(
    landings: Scene | str | Mapping[str, Scene | str],
    robot: Robot | None = None,
    *,
    vary: Annotated[
        Vary,
        Option(
            "Repeat each landing with these values, a:b:n or a,b,c, of strike-angle [deg], speed "
            "[m/s], base-pitch [deg], joints by name or glob [deg; m if prismatic], and other "
            "names of a landing that sweep varies.",
            "Landings",
            "NAME=VALUES",
            holds="varied",
        ),
    ] = (),
    body: Annotated[
        str | None,
        Option(
            "The body, or a link or site fixed to it, by name or glob.",
            "Where a sensor may be",
            "BODY",
            default="base",
        ),
    ] = None,
    within: Annotated[
        Box | None,
        Option(
            "Only in this box of the body's frame, whatever the geometry.",
            "Where a sensor may be",
            "X0:X1,Y0:Y1,Z0:Z1",
            unit="m",
            least=-1e6,
            greatest=1e6,
        ),
    ] = None,
    surface: Annotated[
        bool,
        Option(
            "Only on the surface of its visual geometry (within the box, if one is given).",
            "Where a sensor may be",
        ),
    ] = False,
    alternatives: Annotated[
        int,
        Option(
            "Number of further places, each the best at a tenth of the region's size from those "
            "before.",
            "Where a sensor may be",
            "N",
            least=0.0,
            greatest=20.0,
        ),
    ] = 2,
    progress: Callable[[int], Callable[[str], None]] = lambda landings: lambda name: None,
) -> PlaceStudy:
    """Find where on a body a sensor has the smallest shock.

    The largest shock over the landings is a convex function of the place, so that its minimum over
    each convex piece of the body is a second-order cone program; bounds tell which piece is the
    best. The shock at the places found, and at the present sensors, is then taken from the
    enclosures of the exact solutions.

    Args:
        landings: one landing, or landings of one robot by name.
        robot: is taken for every landing instead of the scenes'; for a robot that was changed after
            it was loaded.
        progress: is called with the number of landings; what it returns with the name of each when
            it is computed.

    Raises:
        StudyError: there is no landing, no such region, or a number is out of range.
        ShockError: the robot cannot be read, or none of the landings computed.
    """
    scenes = named_scenes(landings)
    robot = robot or common_robot(scenes)
    scenes = _varied(with_default_landings(scenes, robot), robot, vary)
    for scene in scenes.values():
        refuse_ground(scene, friction=False, remedy="use shockpc analyze, sweep, check or compare")
    i = 0 if body is None else robot.body(body)
    region = region_of(robot, i, within, surface)
    cases = {name: (scene, robot) for name, scene in scenes.items()}
    as_modelled = _as_modelled(cases, robot, i, region, alternatives, progress(len(cases)))
    # The same study, with the drives of its scenes at an end of what they may be.
    at_end = partial(place, robot=robot, body=body, within=within, surface=surface, alternatives=0)
    return replace(as_modelled, ends=at_drive_ends(as_modelled, cases, at_end))


def _as_modelled(
    cases: Mapping[str, tuple[Scene, Robot]],
    robot: Robot,
    body: int,
    region: Region,
    alternatives: int,
    progress: Callable[[str], None],
) -> PlaceStudy:
    """The study with the drives as modelled. Args: as of the study and its result."""
    profiles, failures = profiles_and_failures(cases, done=progress)
    computed = tuple(profiles.values())
    fields = _fields(computed, body)
    apart = max(region.size / 10.0, NEAREST)
    optima, smallest = _optima(fields, region, alternatives, apart, by_mean=_nested(computed))
    points = _points(scene for scene, _ in cases.values())
    today, places = _sensor_places(robot, body, points, computed, fields, optima)
    return PlaceStudy(
        robot=robot,
        body=body,
        region=region,
        landings=tuple(profiles),
        profiles=computed,
        fields=fields,
        today=today,
        places=places,
        combined=places[0].combined,
        least=smallest.value,
        bound=smallest.bound,
        apart=apart,
        failures=tuple(failures.items()),
    )


def _varied(scenes: dict[str, Scene], robot: Robot, vary: Vary) -> dict[str, Scene]:
    """The landings by name, each repeated with what varies."""
    varied = pairs(vary)
    if not varied:
        return scenes
    every: dict[str, Scene] = {}
    for name, scene in scenes.items():
        every |= scene_grid(name, scene, robot, varied)
    return every


def _fields(profiles: Sequence[ShockProfile], body: int) -> Fields:
    """Shock over a body; with friction where a contact slides."""
    jumps = []
    for profile in profiles:
        # (6,) angular part first, body coordinates
        friction = profile.friction
        if friction is None or friction.impact is None:
            jumps.append(np.concatenate([profile.delta_omega[body], profile.delta_v[body]]))
        else:
            jumps.append(np.asarray(friction.impact.strike_jumps[0, 0, body]))
    by_landing = np.array(jumps)
    v_in = np.array([profile.v_in for profile in profiles])
    return fields_of(by_landing[:, :3], by_landing[:, 3:], v_in)


def _optima(
    fields: Fields, region: Region, alternatives: int, apart: float, *, by_mean: bool
) -> tuple[list[Optimum], Optimum]:
    """The best place and its alternatives, and the place of the smallest number.

    Args:
        fields: shock over the body.
        region: where a sensor may be.
        alternatives: number of further places.
        apart: distance of these [m].
        by_mean: whether the mean decides among nearly equal places.

    Raises:
        StudyError: there is no place in the region.
    """
    ranked = best_places(fields, region.cells, region.outside, apart)
    smallest = next(ranked, None)
    if smallest is None:
        raise StudyError(
            f"there is no place {region.text}: the region lies inside other shapes of the body, "
            "or outside the box"
        )
    if not by_mean:
        return [smallest, *itertools.islice(ranked, alternatives)], smallest
    if smallest.value <= ACCURACY:
        return [smallest], smallest
    return _of_smallest_mean(fields, region, 1 + alternatives, apart), smallest


def _of_smallest_mean(fields: Fields, region: Region, number: int, apart: float) -> list[Optimum]:
    """Places with the smallest mean over the landings, each among those that are nearly equal."""
    outside = list(region.outside)
    optima: list[Optimum] = []
    for _ in range(number):
        smallest = next(best_places(fields, region.cells, outside), None)
        if smallest is None:
            break
        nearly_equal = fields._replace(limit=(1.0 + EQUAL) * smallest.value)
        point = next(best_places(nearly_equal, region.cells, outside), smallest).point
        (value,) = fields.at(point[None]).tolist()
        optima.append(Optimum(point, value, smallest.bound))
        outside.append(box_faces(point - apart, point + apart))
    return optima


def _nested(profiles: Iterable[ShockProfile]) -> bool:
    """True if one of the landings is on some of the contacts of another.

    Landings of feet that are level are so.
    """
    contacts: list[set[str]] = []
    for profile in profiles:
        contacts.append({contact.frame for contact in profile.scene.contact})
    return any(some < more for some, more in itertools.permutations(contacts, 2))


def _points(scenes: Iterable[Scene]) -> tuple[Point, ...]:
    """The points that scenes name, each once."""
    points = itertools.chain.from_iterable(scene.point for scene in scenes)
    return tuple(dict.fromkeys(points))


def _sensor_places(
    robot: Robot,
    body: int,
    points: tuple[Point, ...],
    profiles: Sequence[ShockProfile],
    fields: Fields,
    optima: Sequence[Optimum],
) -> tuple[tuple[SensorPlace, ...], tuple[SensorPlace, ...]]:
    """The body's present sensors, and the places of optima, with their proven numbers."""
    today = [place for place in point_places(robot, points) if place.body == body]
    new_points = []
    for optimum in optima:
        x, y, z = optimum.point.tolist()
        new_points.append(Point(frame=robot.bodies[body].name, offset=(x, y, z)))
    places = [*today, *(point_place(robot, point) for point in new_points)]
    shocks, delta_v = _proven(profiles, places, new_points)
    names = [*(place.name for place in today), *map(_rank, range(len(optima)))]
    bounds = [*[None] * len(today), *(optimum.bound for optimum in optima)]
    sensors = []
    for k, place in enumerate(places):
        sensors.append(
            SensorPlace(
                name=names[k],
                position=place.r,
                shocks=shocks[k],
                combined=float(fields.combined(shocks[k])),
                delta_v=delta_v[k],
                bound=bounds[k],
                margin=_axis_peaks(delta_v[k], profiles),
            )
        )
    return tuple(sensors[: len(today)]), tuple(sensors[len(today) :])


def _proven(
    profiles: Sequence[ShockProfile], places: Sequence[Place], new: Sequence[Point]
) -> tuple[Array, Array]:
    """Shock (n, L) and jump of velocity (n, L, 3) at places.

    They are from the enclosures of the exact solutions.

    Args:
        profiles: of the landings.
        places: named points of the scenes, then new ones.
        new: the new points.
    """
    points = tuple(dict.fromkeys((*_points(profile.scene for profile in profiles), *new)))
    shocks, delta_v = [], []
    for profile in profiles:
        scene = replace(profile.landing.scene, point=points)
        at_points = replace(profile, landing=replace(profile.landing, scene=scene))
        names = [point.name for point in at_points.landing.points]
        rows = [names.index(place.name) for place in places]
        end = "" if scene.friction is None else "_friction"
        shocks.append(np.asarray(at_points.value(f"shock{end}", "point"))[rows])
        delta_v.append(np.asarray(at_points.value(f"delta_v{end}", "point"))[rows])
    return np.array(shocks).T, np.array(delta_v).swapaxes(0, 1)


def _axis_peaks(delta_v: Array, profiles: Sequence[ShockProfile]) -> AxisPeaks | None:
    """Peaks along the axes of a sensor, and what is left of its range.

    They are for the scenes' pulses and bandwidths.

    Args:
        delta_v: (L, 3) jump of velocity along the axes [m/s].
        profiles: of the landings.

    Returns: None if a scene has neither a pulse nor a bandwidth.

    Raises:
        StudyError: a scene gives a range, and one has neither.
    """
    scenes = [profile.scene for profile in profiles]
    ranges = [scene.range_g for scene in scenes if scene.range_g is not None]
    # Peak acceleration of a unit jump [1/s].
    scales = np.array([peak_of(pulse_of(scene), scene_low_pass(scene)) for scene in scenes])
    if np.isnan(scales).any():
        if ranges:
            raise StudyError(
                "a sensor's range needs accelerations; give a pulse, such as half-sine:5ms, or a "
                "bandwidth"
            )
        return None
    peaks = delta_v * (scales / GRAVITY)[:, None]
    largest = np.abs(peaks).max(axis=0)
    return AxisPeaks(largest, 1.0 - largest / min(ranges) if ranges else None)


def _rank(k: int) -> str:
    """The name of the place with this index: "best", "2nd", "3rd", "4th" and so on."""
    return ("best", "2nd", "3rd")[k] if k < 3 else f"{k + 1}th"
