"""The record of a quantity, and its evaluation on an impact."""

import functools
from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple, TypeAlias, TypeVar, cast

import numpy as np

from shockpc.core.spatial import Array, freeze
from shockpc.impact.impact import Impact
from shockpc.landing.landing import PosedLanding
from shockpc.landing.places import Place, PlaceKind
from shockpc.landing.scenes.scene import Scene
from shockpc.text.printed import unit_text

Places: TypeAlias = Sequence[Place]
T = TypeVar("T")


class Scope(NamedTuple):
    """The places where a quantity has values, and why it may have none.

    Attributes:
        missing: why a value may be missing.
        lacks: what a landing lacks for it, as a message; empty where it exists.
        fixed: its value at a point that is fixed to the world, which nothing moves.
        strikes: whether only contacts that strike have it, and no standing foot.
        parts_of: of which parts it is: of those at a "point", or those of a "joint"; empty for all.
        shared: whether it is one of many where contact or closure rows are redundant: that of the
            impulses of minimum norm.
    """

    missing: str = ""
    lacks: Callable[[PosedLanding], str] = lambda landing: ""
    fixed: Callable[[Place], Any] = lambda place: 0.0
    strikes: bool = False
    parts_of: Literal["", "point", "joint"] = ""
    shared: bool = False


class Computation(NamedTuple):
    """Arithmetic in which a quantity is computed, and of what.

    Attributes:
        on: of what: the impact of the scene, that of the same landing with joints of another model
            (as `ShockProfile.proof_with` names them), or the profile's health.
        postures: "many" at once in double precision, or one with a proof; "one" at a time, because
            double precision cannot decide it; or "clear": one at a time, and many in double
            precision, NaN where that is not clear.
        exact: "always"; "rigid", unless the landing lasts, which is computed in one posture
            at a time and in double precision; or "never", in double precision.
    """

    on: Literal["scene", "free", "locked", "springs_free", "health"] = "scene"
    postures: Literal["many", "one", "clear"] = "many"
    exact: Literal["always", "rigid", "never"] = "always"


class Relations(NamedTuple):
    """Relations of a quantity to others.

    Attributes:
        most_severe: of a shock: that of the most severe strike at the same place, to which errors
            of it are relative.
        reciprocal: what changes are ranked by where that is its reciprocal; empty where it is the
            quantity itself.
        role: what it says of whether flat ground allows a landing: "feasible" is 1 or 0, NaN where
            a proof decides, and so is "tilt", of a landing that a tilt makes feasible; "pull" is
            above zero where a contact would have to be pulled, and "gain" where the impact would
            make energy.
        also: for what else it exists: the impact with friction, and the jumps on contacts of finite
            stiffness.
        linear: whether it is linear in the jumps and impulses, by coefficients that do not change
            with the posture or the strike.
        length_of: a quantity of that kind of which it is the length, but for a factor that does not
            change with them either.
    """

    most_severe: "Quantity | None" = None
    reciprocal: str = ""
    role: Literal["", "feasible", "tilt", "pull", "gain"] = ""
    also: tuple[Literal["friction", "stiffness"], ...] = ()
    linear: bool = False
    length_of: "Quantity | None" = None


EXACT_IF_RIGID = Computation(exact="rigid")
IN_DOUBLES_WHERE_CLEAR = Computation(postures="clear")
IN_DOUBLES = Computation(postures="one", exact="never")


class Quantity(NamedTuple):
    """A number, or a vector, of a landing.

    Attributes:
        key: its name in JSON, budgets, sweeps and comparisons; unique among those of one kind of
            place.
        of: the kind of place that it belongs to.
        title: as a table heads it.
        unit: SI, but g; "1" for a ratio.
        worse: which change makes a design worse.
        compute: values (N, S, n) or (N, S, n, 3) at n places in N postures for S strikes, NaN where
            there is none; in the arithmetic of the impact. Of a profile's health values (n,).
        size: natural size of values (N, S, n, ...), against which a ball counts as narrow enough:
            of an impact and the values.
        form: of a value: a "number" of one sign; a "signed" one, of which "greater" means farther
            from zero; a "vector" (3,), whose length is taken where one number is needed; or a
            "flag", 1 or 0, which documents write as true or false.
        scope: where it has values.
        computation: how it is computed.
        relations: what it has to do with others.
    """

    key: str
    of: PlaceKind
    title: str
    unit: str
    worse: Literal["greater", "less", "neither"]
    compute: Callable[[Any, Places], Any]
    size: Callable[[Impact, Array], Any] = lambda impact, values: 0.0
    form: Literal["number", "signed", "vector", "flag"] = "number"
    scope: Scope = Scope()
    computation: Computation = Computation()
    relations: Relations = Relations()

    @property
    def unit_text(self) -> str:
        """The unit as tables and texts have it, with "-" for a ratio."""
        return unit_text(self.unit)

    @property
    def vector(self) -> bool:
        """True if a value is a vector (3,)."""
        return self.form == "vector"

    @property
    def signed(self) -> bool:
        """True if a value is a number that may be negative."""
        return self.form == "signed"

    @property
    def flag(self) -> bool:
        """True if a value is 1 or 0, which documents write as true or false."""
        return self.form == "flag"

    @property
    def decided_by_ground(self) -> bool:
        """True if it is 1 or 0 by what flat ground allows."""
        return self.relations.role in ("feasible", "tilt")

    def per_landing(self, scene: Scene) -> bool:
        """True if it is computed in one posture at a time, for a landing of a scene."""
        on_stiffness = self.computation.exact == "rigid" and scene.yields
        return self.computation.postures != "many" or on_stiffness

    def of_ground(self, scene: Scene) -> bool:
        """True if it depends on the friction or on the contact stiffness of a scene.

        It is then computed in double precision.
        """
        on_stiffness = self.computation.exact == "rigid" and scene.yields
        return self.computation.exact == "never" or on_stiffness

    def title_at(self, place: str, component: str = "") -> str:
        """The title with the name of a place, such as "largest shock over base" or "shock at imu".

        Args: component, x, y or z.
        """
        title, comma, frame = self.title.partition(",")
        along = f" along {component}" if component else ""
        if self.of in ("body", "joint"):
            noun = f"the {self.of}"
            title = title.replace(noun, place, 1) if noun in title else f"{title} of {place}"
        elif self.of != "robot":
            title += f" at {place}"
        return f"{title}{along}{comma}{frame}"

    @property
    def text(self) -> str:
        """Title, unit, and why there may be no value."""
        text = f"{self.title} [{self.unit}]"
        if self.scope.missing:
            text += f"; no value: {self.scope.missing}"
        return text

    @property
    def note(self) -> str:
        """Remarks that a user has to know."""
        one_posture = self.computation.postures != "many"
        exact = self.computation.exact
        remarks = {
            "vector": self.vector,
            "of either sign": self.signed,
            "always exact": one_posture and exact != "never",
            "in double precision": exact == "never",
            "in double precision with a contact stiffness": exact == "rigid",
            "of minimum norm where rows are redundant": self.scope.shared,
            f"no value: {self.scope.missing}": bool(self.scope.missing),
        }
        return "; ".join(text for text, holds in remarks.items() if holds)


def once_per_impact(compute: Callable[[Impact, Places], T]) -> Callable[[Impact, Places], T]:
    """A formula that several quantities share, computed once for an impact and places.

    Its arrays cannot be written to.
    """

    @functools.wraps(compute)
    def remembered(impact: Impact, places: Places) -> T:
        key = compute, *map(id, places)
        if key not in impact.remembered:
            values = compute(impact, places)
            freeze(values)
            # The places are kept too, so that no others can have their ids.
            impact.remembered[key] = values, tuple(places)
        return cast(T, impact.remembered[key][0])

    return remembered


def quantity_values(quantity: Quantity, impact: Impact, places: Places) -> Array:
    """The values (N, S, n, ...) of a quantity at some places, as doubles.

    Raises:
        PrecisionError: the impact is in balls, and they are too wide.
    """
    return impact.rounded(
        quantity.compute(impact, places), functools.partial(quantity.size, impact)
    )


def no_values(quantity: Quantity, places: Places) -> Array:
    """NaN (1, 1, n), or (1, 1, n, 3) of a vector, at n places."""
    shape = (1, 1, len(places), 3) if quantity.vector else (1, 1, len(places))
    return np.full(shape, np.nan)


def largest_jump(impact: Impact, values: Array) -> float:
    """The largest component of a jump of a body [m/s, rad/s]."""
    del values
    return float(np.abs(impact.strike_jumps.astype(float)).max())


def largest_shock(impact: Impact, values: Array) -> Any:
    """The largest component of a jump of a body, relative to the strike."""
    return largest_jump(impact, values) / impact.v_in.astype(float)[..., None]


def of_ratio(impact: Impact, values: Array) -> float:
    """The natural size of a ratio."""
    del impact, values
    return 1.0


def reach(impact: Impact, values: Array) -> float:
    """Largest distance of something of the robot from the world's origin, at least [m]."""
    del values
    origin = np.abs(impact.state.origin.astype(float)).max()
    bodies = np.abs(impact.state.position.astype(float)).max()
    return float(origin + bodies) + 1e-3
