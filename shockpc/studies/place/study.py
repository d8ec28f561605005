"""Where on a body a sensor has the smallest shock over some landings: scenes in, one record out."""

import itertools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple

import numpy as np

from shockpc.core.low_pass import peak_of
from shockpc.core.spatial import Array
from shockpc.evaluation.declare import study
from shockpc.evaluation.drive_ends import MOVED, End, at_drive_ends
from shockpc.evaluation.evaluate import proven
from shockpc.evaluation.named_scenes import common_robot, named_scenes, with_default_landings
from shockpc.evaluation.table import Table
from shockpc.evaluation.unused_ground import refuse_ground
from shockpc.evaluation.variation import Vary, pairs
from shockpc.evaluation.varied_scene import scene_grid
from shockpc.landing.bandwidths import scene_low_pass
from shockpc.landing.places import Place, point_place, point_places
from shockpc.landing.record import Option
from shockpc.landing.resolve import pulse_of
from shockpc.landing.scene import Point, Scene
from shockpc.landing.strike import GRAVITY
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.studies.place.best_first import best_places, box
from shockpc.studies.place.cone import ACCURACY, Optimum
from shockpc.studies.place.field import Fields, fields_of
from shockpc.studies.place.groups import best_group
from shockpc.studies.place.region import Box, Region, region_of
from shockpc.text.errors import ShockError, StudyError
from shockpc.text.names import match
from shockpc.text.shown import brief, counted, shown_by

NEAREST = 1e-3
"""Smallest distance between alternatives [m]."""

ALTERNATIVES = 2
"""Default of their number."""

EQUAL_SHARE = 1.0 - 1e-6
"""Share of the largest shock from which others are equal to it, of which the first is named;
rounding makes them differ.
"""


EQUAL = 0.01
"""By how much more than the smallest the largest shock at a place may be, as a share of it, for the
mean over landings to decide.

On all level feet a robot rotates little, so that many places are nearly equal; the landings on some
of them tell these apart."""


class Margin(NamedTuple):
    """What a pulse means for the axes of a sensor.

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
        name: of the sensor or point that is there today; "best", "2nd" and so on, or for several
            "sensor 1" and so on.
        position: (3,) in the body's frame [m].
        shocks: (L,) in each landing [1].
        combined: the number by which places are compared: the largest of them, or the weighted mean
            [1].
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
    margin: Margin | None


@dataclass(frozen=True, eq=False)
class PlaceStudy:
    """Where on a body a sensor has the smallest shock.

    Attributes:
        robot: the robot.
        body: index of the body.
        region: where a sensor may be.
        landings: names of the landings that were computed.
        profiles: their results.
        fields: shock over the body, and the number by which places are compared.
        today: the body's sensors, and the points that the scenes name.
        places: the best place and its alternatives, or the places of several sensors that belong
            together; fewer than `count` where these already see as little as so many can.
        count: number of sensors that belong together.
        combined: the number by which places are compared, at the best; of several sensors the
            minimum shock in each landing [1].
        least: the minimum such number in the region; of landings on feet that are level and on some
            of them, the best place is that of the smallest mean among those within 1 % of it [1].
        bound: nothing in the region is below this [1].
        assigned: (L,) for several sensors, which of them has the smallest shock in each landing.
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
    count: int
    combined: float
    least: float
    bound: float
    assigned: np.ndarray
    apart: float
    failures: tuple[tuple[str, ShockError], ...]
    ends: Mapping[End, "PlaceStudy | ShockError"] = field(default_factory=dict, repr=False)

    _repr_html_ = shown_by("studies.place.report:place_report")

    def __repr__(self) -> str:
        body = self.robot.bodies[self.body].name
        return brief(self, f"{self.robot.name}, body {body}", counted(len(self.places), "place"))

    @property
    def weights(self) -> Array | None:
        """Weights (L,) of the landings with sum 1 if places are compared by the weighted mean; None
        for the largest shock.
        """
        return self.fields.weights

    @property
    def table(self) -> Table:
        """A row for each present sensor, for each place found, and for all of these together if
        there are several sensors.
        """
        entries = [
            (one.name, one.position, one.combined, one.shocks)
            for one in (*self.today, *self.places)
        ]
        if self.count > 1:
            together = np.stack([one.shocks for one in self.places]).min(axis=0)
            entries.append(("together", np.full(3, np.nan), self.combined, together))
        mean = self.weights is not None
        rows = (
            (
                name,
                *at,
                *([combined] * mean),
                shocks.max(),
                self.landings[(shocks >= EQUAL_SHARE * shocks.max()).argmax()],
            )
            for name, at, combined, shocks in entries
        )
        means = ["weighted mean [-]"] * mean
        return Table.of_rows(
            ("place", "x [m]", "y [m]", "z [m]", *means, "maximum shock [-]", "in landing"), rows
        )

    @property
    def gap(self) -> float:
        """Difference between the smallest number found and what is proven to be a lower bound [1]."""
        return max(0.0, self.least - self.bound)

    def better(self, one: SensorPlace) -> float:
        """By how much the best place is better than another one, as a share of its shock [1]."""
        if self.combined > 0.0:
            return max(0.0, one.combined / self.combined - 1.0)
        return math.inf if one.combined > 0.0 else 0.0

    @property
    def kept(self) -> SensorPlace | None:
        """The present sensor than which no place is better by more than 1 %; None if there is none."""
        least = min(self.today, key=lambda one: one.combined, default=None)
        return least if least is not None and self.better(least) <= MOVED else None

    @property
    def complete(self) -> bool:
        """Whether the search for several sensors ended with the optimum."""
        return self.gap <= 1e-6 * max(self.least, 1e-3)


@study(
    "shockpc place anymal_b --vary strike-angle=-30:75:4",
    more=(
        "Without --contact the landings are those on all level feet together, on each edge of "
        "their support, and on each "
        "foot. Places are compared by the maximum shock over all "
        "landings. The optimum over the body is exact up to the stated gap; the shock at the "
        "places is proven. "
        "--pulse (or --imu-bandwidth) with --range-g also gives the unused range of a sensor along "
        "each axis."
    ),
    # What `refuse_ground` refuses, and parts, whose places are given.
    without=(
        "contact_stiffness",
        "contact_damping",
        "contact_law",
        "no_gravity",
        "stop_stiffness",
        "motors",
        "torque",
        "flex",
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
            "[m/s], base-pitch [deg], "
            "joints by name or glob [deg; m if prismatic], and other names of a landing that sweep "
            "varies.",
            "Landings",
            "NAME=VALUES",
            holds="varied",
        ),
    ] = (),
    weights: Annotated[
        Mapping[str, float] | None,
        Option(
            "Weight of the landings with this name or glob; others weigh 1. Places are then "
            "compared by the weighted mean "
            "over the landings instead of the maximum shock.",
            "Landings",
            "LANDING=WEIGHT",
            "weight",
        ),
    ] = None,
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
    count: Annotated[
        int,
        Option(
            "Number of sensors: in each landing the sensor with the smallest shock counts.",
            "Sensors",
            "N",
            least=1.0,
            greatest=20.0,
        ),
    ] = 1,
    alternatives: Annotated[
        int | None,
        Option(
            "Number of further places of one sensor, each the best at a tenth of the region's size "
            "from those before.",
            "Sensors",
            "N",
            least=0.0,
            greatest=20.0,
            default="2",
        ),
    ] = None,
    progress: Callable[[int], Callable[[str], None]] = lambda landings: lambda name: None,
) -> PlaceStudy:
    """Find where on a body a sensor has the smallest shock.

    The largest shock over the landings (or its weighted mean) is a convex function of the place, so
    that its minimum over each convex piece of the body is a second-order cone program; bounds tell
    which piece is the best. The shock at the places found, and at the present sensors, is then
    taken from the enclosures of the exact solutions.

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
    if count > 1 and alternatives is not None:
        raise StudyError(
            f"alternatives are places of one sensor, and {count} sensors are asked for; leave one "
            f"of the two out"
        )
    alternatives = ALTERNATIVES if alternatives is None else alternatives
    named = named_scenes(landings)
    robot = robot or common_robot(named)
    named = with_default_landings(named, robot)
    if varied := pairs(vary):
        named = {
            label: case
            for name, scene in named.items()
            for label, case in scene_grid(name, scene, robot, varied).items()
        }
    scenes = list(named.values())
    for scene in scenes:
        refuse_ground(scene, friction=False, others="use shockpc analyze, sweep, check or compare")
    i = 0 if body is None else robot.body(body)
    region = region_of(robot, i, within, surface)
    apart = max(region.size / 10.0, NEAREST)
    profiles, failures = _profiles(named, robot, progress(len(named)))
    names = tuple(profiles)
    computed = tuple(profiles.values())
    jumps = np.array([_jump(profile, i) for profile in computed])
    fields = fields_of(
        jumps[:, :3],
        jumps[:, 3:],
        np.array([profile.v_in for profile in computed]),
        None if weights is None else _weights(names, named, weights),
    )
    optima, least, bound = _optima(
        fields, region, count, alternatives, apart, weights is None and _nested(computed)
    )
    titles = (
        [f"sensor {k + 1}" for k in range(len(optima))]
        if count > 1
        else [_rank(k) for k in range(len(optima))]
    )
    new = tuple(
        Point(
            frame=robot.bodies[i].name,
            offset=(float(one.place[0]), float(one.place[1]), float(one.place[2])),
        )
        for one in optima
    )
    today = [place for place in point_places(robot, _asked(scenes)) if place.body == i]
    every = [*today, *(point_place(robot, point) for point in new)]
    shocks, delta_v = _proven(computed, every, new)
    combined = fields.combined(shocks)
    together = shocks[len(today) :].min(axis=0)
    places = [
        SensorPlace(
            name=name,
            position=place.r,
            shocks=shocks[k],
            combined=float(combined[k]),
            delta_v=delta_v[k],
            bound=None if k < len(today) else optima[k - len(today)].bound,
            margin=_margin(delta_v[k], computed),
        )
        for k, (name, place) in enumerate(
            zip([*(place.name for place in today), *titles], every, strict=True)
        )
    ]
    modelled = PlaceStudy(
        robot=robot,
        body=i,
        region=region,
        landings=names,
        profiles=computed,
        fields=fields,
        today=tuple(places[: len(today)]),
        places=tuple(places[len(today) :]),
        count=count,
        combined=float(fields.combined(together)) if count > 1 else float(combined[len(today)]),
        least=least,
        bound=bound,
        assigned=shocks[len(today) :].argmin(axis=0),
        apart=apart,
        failures=failures,
    )

    def at_end(scenes: dict[str, Scene]) -> PlaceStudy:
        return place(
            scenes,
            robot,
            weights=weights,
            body=body,
            within=within,
            surface=surface,
            count=count,
            alternatives=0 if count == 1 else None,
        )

    cases = {name: (scene, robot) for name, scene in named.items()}
    return replace(modelled, ends=at_drive_ends(modelled, cases, at_end))


def _profiles(
    landings: Mapping[str, Scene], robot: Robot, progress: Callable[[str], None]
) -> tuple[dict[str, ShockProfile], tuple[tuple[str, ShockError], ...]]:
    """The landings' results by name, and those that could not be computed."""
    results = proven(
        {name: (scene, robot) for name, scene in landings.items()}, None, done=progress
    )
    failures = [
        (name, result) for name, result in results.items() if isinstance(result, ShockError)
    ]
    if len(failures) == len(results):
        raise failures[0][1]
    profiles = {
        name: result for name, result in results.items() if isinstance(result, ShockProfile)
    }
    return profiles, tuple(failures)


def _jump(profile: ShockProfile, body: int) -> Array:
    """The jump (6,) of a body, angular part first, body coordinates; with friction where a contact
    slides.
    """
    friction = profile.friction
    if friction is None or friction.impact is None:
        return np.concatenate([profile.delta_omega[body], profile.delta_v[body]])
    return np.asarray(friction.impact.strike_jumps[0, 0, body])


def _weights(names: tuple[str, ...], landings: Iterable[str], given: Mapping[str, float]) -> Array:
    """The weights of the landings that were computed, with sum 1.

    Args: given, by name or glob of any landing.
    """
    by_name = dict.fromkeys(landings, 1.0)
    for pattern, weight in given.items():
        by_name |= dict.fromkeys(
            match(pattern, by_name, "landing", "", "leave out --weight; the table names them"),
            weight,
        )
    weights = np.array([by_name[name] for name in names])
    if not (np.all(weights >= 0.0) and 0.0 < weights.sum() < math.inf):
        raise StudyError("weights of landings have to be finite, not negative, and not all zero")
    return np.asarray(weights / weights.sum())


def _optima(
    fields: Fields, region: Region, count: int, alternatives: int, apart: float, by_mean: bool
) -> tuple[list[Optimum], float, float]:
    """The places, the smallest number found and its bound.

    Args: by_mean, whether the mean decides among nearly equal places.
    """
    outside = list(region.outside)

    def ranked(some: Fields, number: int) -> list[Optimum]:
        optima = list(itertools.islice(best_places(some, region.cells, outside, apart), number))
        if not optima and len(outside) == len(region.outside):
            raise StudyError(
                f"there is no place {region.text}: all of it is inside other shapes of the body, "
                f"or outside the box"
            )
        return optima

    if count > 1:
        group = best_group(fields, min(count, len(fields.c)), lambda some: ranked(some, 1)[0])
        return (
            [Optimum(one, math.nan, group.bound) for one in group.places],
            group.value,
            group.bound,
        )
    optima = ranked(fields, 1 if by_mean else 1 + alternatives)
    first, places = optima[0], list[Optimum]()
    if not by_mean or first.value <= ACCURACY:
        return optima, first.value, first.bound
    mean = np.full(len(fields.c), 1.0 / len(fields.c))
    while optima and len(places) <= alternatives:
        limited = fields._replace(weights=mean, limit=(1.0 + EQUAL) * optima[0].value)
        place = (ranked(limited, 1) or optima)[0].place
        places.append(Optimum(place, float(fields.at(place[None])[0]), optima[0].bound))
        outside.append(box(place - apart, place + apart))
        optima = ranked(fields, 1)
    return places, first.value, first.bound


def _nested(profiles: Iterable[ShockProfile]) -> bool:
    """Whether one of the landings is on some of the contacts of another, as those of feet that are
    level.
    """
    contacts = [{contact.frame for contact in profile.scene.contact} for profile in profiles]
    return any(one < other for one in contacts for other in contacts)


def _asked(scenes: list[Scene]) -> tuple[Point, ...]:
    return tuple(dict.fromkeys(point for scene in scenes for point in scene.point))


def _proven(
    profiles: tuple[ShockProfile, ...], every: list[Place], new: tuple[Point, ...]
) -> tuple[Array, Array]:
    """Shock (n, L) and jump of velocity (n, L, 3) at places, from the enclosures of the exact
    solutions.
    """
    columns = []
    for profile in profiles:
        scene = profile.landing.scene
        extended = replace(
            scene, point=tuple(dict.fromkeys((*_asked([one.scene for one in profiles]), *new)))
        )
        at = replace(profile, landing=replace(profile.landing, scene=extended))
        names, end = (
            [point.name for point in at.landing.points],
            "" if scene.friction is None else "_friction",
        )
        numbers = [at.value(f"{key}{end}", "point") for key in ("shock", "delta_v")]
        columns.append([[values[names.index(place.name)] for place in every] for values in numbers])
    shocks, delta_v = zip(*columns, strict=True)
    return np.array(shocks).T, np.array(delta_v).swapaxes(0, 1)


def _margin(delta_v: Array, profiles: tuple[ShockProfile, ...]) -> Margin | None:
    """What the scenes' pulses and bandwidths mean for the axes of a sensor; None if a scene has
    neither.
    """
    scales = np.array(
        [peak_of(pulse_of(profile.scene), scene_low_pass(profile.scene)) for profile in profiles]
    )
    if np.isnan(scales).any():
        if any(profile.scene.range_g is not None for profile in profiles):
            raise StudyError(
                "a sensor's range needs accelerations; give a pulse, such as half-sine:5ms, or a "
                "bandwidth"
            )
        return None
    peaks = delta_v * (scales / GRAVITY)[:, None]
    ranges = [profile.scene.range_g for profile in profiles if profile.scene.range_g is not None]
    greatest = np.abs(peaks).max(axis=0)
    return Margin(greatest, 1.0 - greatest / min(ranges) if ranges else None)


def _rank(k: int) -> str:
    return "best" if k == 0 else f"{k + 1}{'nd' if k == 1 else 'rd' if k == 2 else 'th'}"
