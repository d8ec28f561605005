"""Several sensors, of which in each landing the one with the smallest shock is used: which landings
belong to which sensor.

Branch and bound over assignments of landings to sensors. The best place for some of the landings is
a bound for every assignment in which they share a sensor. A node whose places already serve the
landings that it does not assign is optimal; otherwise the landing that they serve worst is given to
each of the sensors in turn. Few landings limit the result, so that few nodes are needed.
"""

import heapq
import itertools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from shockpc.studies.place.cone import ACCURACY, Optimum
from shockpc.studies.place.field import Fields

NODES = 2000
"""Nodes after which the search ends with the best sensors found and the bound proven so far."""


class SensorGroup(NamedTuple):
    """Places of several sensors.

    Attributes:
        places: one (3,) for each sensor [m].
        value: of the smallest shock in each landing, the number that places are compared by [1].
        bound: no such sensors have less than this [1].
        nodes: of the search.
    """

    places: tuple[np.ndarray, ...]
    value: float
    bound: float
    nodes: int


def best_group(fields: Fields, count: int, best: Callable[[Fields], Optimum]) -> SensorGroup:
    """The places of several sensors with which the landings are best covered.

    Args:
        fields: shock over the body.
        count: number of sensors.
        best: the best place for some of the landings.
    """
    everything = range(len(fields.c))
    known: dict[frozenset[int], Optimum] = {}

    def optimum(landings: frozenset[int]) -> Optimum:
        if landings not in known:
            known[landings] = best(fields.of(sorted(landings)))
        return known[landings]

    def places(node: tuple[frozenset[int], ...]) -> list[np.ndarray]:
        return [optimum(one).place for one in node if one]

    def served(node: tuple[frozenset[int], ...]) -> tuple[np.ndarray, np.ndarray]:
        """The smallest shock in each landing, and at which of the node's places."""
        shocks = fields.shocks(np.array(places(node)))
        return shocks.min(axis=0), shocks.argmin(axis=0)

    weights = fields.weights
    single = (
        np.zeros(len(fields.c))
        if weights is None
        else np.array([optimum(frozenset([k])).bound for k in everything])
    )

    def bound_of(node: tuple[frozenset[int], ...]) -> float:
        bounds = [optimum(one).bound for one in node if one]
        if weights is None:
            return max(bounds)
        return float(
            sum(bounds) + sum(single[k] for k in everything if not any(k in one for one in node))
        )

    first = max(everything, key=lambda k: (optimum(frozenset([k])).bound, -k))
    root = (frozenset([first]), *[frozenset[int]()] * (count - 1))
    number = itertools.count()
    queue = [(bound_of(root), next(number), root)]
    value, chosen = np.inf, places(root)
    bound, nodes = 0.0, 0
    while True:
        bound, _, node = heapq.heappop(queue)
        nodes += 1
        bound = min(bound, value)
        least, _ = served(node)
        improved = node
        while (
            improved_value := float(fields.combined(served(improved)[0]))
        ) < value - ACCURACY / 2.0:
            value, chosen = improved_value, places(improved)
            which = served(improved)[1]
            improved = tuple(
                frozenset(np.flatnonzero(which == k).tolist()) for k in range(len(places(improved)))
            )
        open_ = [k for k in everything if not any(k in one for one in node)]
        if value <= bound + ACCURACY or not open_ or nodes == NODES:
            return SensorGroup(tuple(chosen), value, bound, nodes)
        worst = max(
            open_, key=lambda k: least[k] if weights is None else weights[k] * least[k] - single[k]
        )
        for k in range(next((k for k, one in enumerate(node) if not one), count - 1) + 1):
            child = tuple(one | {worst} if i == k else one for i, one in enumerate(node))
            heapq.heappush(queue, (max(bound, bound_of(child)), next(number), child))
