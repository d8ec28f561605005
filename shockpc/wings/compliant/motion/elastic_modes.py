"""The modes of a landing: frequencies, energies, and what elements carry of them."""

from typing import NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.compliant.motion.free_motion import modal_state
from shockpc.wings.compliant.motion.state import State


class ElasticModes(NamedTuple):
    """The m modes of the elements that are loaded first.

    Attributes:
        frequency: (m,) natural frequencies [Hz], descending.
        energy: (m,) kinetic energy before impact in each mode [J]. Its sum is the energy that the
            elements can take up.
        participation: (r, m) share of the elastic energy of each mode that is in each element [1].
        force: (r, m) amplitude of the force of each element in each mode [N, N m].
    """

    frequency: Array
    energy: Array
    participation: Array
    force: Array


def elastic_modes(state: State) -> ElasticModes:
    """The modes of the elements that are loaded in a state, without dampers."""
    loaded = state.loaded(dampers=False)
    modes, k = loaded.modes, state.system.elements.stiffness[:, None]
    moves = modes.sigma > 0.0
    amplitude = modal_state(state, loaded).oscillations.deflection[moves]
    # Forces of the elements for a unit deflection of each mode [N/√J].
    shape = (state.slope[:, None] * (loaded.held.to_all @ modes.U))[:, moves]
    return ElasticModes(
        frequency=modes.sigma[moves] / (2.0 * np.pi),
        energy=(modes.V.T @ state.u)[moves] ** 2 / 2.0,
        participation=np.divide(shape**2, k, out=np.zeros_like(shape), where=k > 0.0),
        force=np.abs(shape * amplitude),
    )
