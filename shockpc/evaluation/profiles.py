"""Landings one by one, each with its proof."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from shockpc.evaluation.unused_ground import refuse_unused_ground
from shockpc.landing.scenes.scene import Scene
from shockpc.profile import profile_of_scene
from shockpc.quantities.selection import Selection
from shockpc.quantities.shock_profile import ShockProfile
from shockpc.robot.robot import Robot
from shockpc.text.diagnostic import Diagnostic, warn
from shockpc.text.errors import ShockError, attempt, traces
from shockpc.text.trace import Trace


def proven_profiles(
    cases: Mapping[str, tuple[Scene, Robot]],
    selections: Sequence[Selection] | None,
    trace: Trace | None = None,
    done: Callable[[str], object] = str,
) -> dict[str, ShockProfile | ShockError]:
    """Landings one by one, each with its proof: the profiles by name, or why there is none.

    Their warnings are Python warnings.

    Args:
        cases: scene and robot of each landing, by name.
        selections: what is read of the profiles; None where they are read as a whole, or columns of
            the same landings follow.
        trace: collects what each stage cost.
        done: is called with the name of each landing that is computed.

    Raises:
        StudyError: a landing has a friction or a contact stiffness on which none of the selections
            depends.
    """
    if selections is not None:
        for scene, _ in cases.values():
            refuse_unused_ground(scene, selections)
    results: dict[str, ShockProfile | ShockError] = {}
    for name, (scene, robot) in cases.items():
        results[name] = attempt(profile_of_scene, scene, robot, trace)
        done(name)
    warn(lambda: _warnings(results.values()))
    return results


def _warnings(results: Iterable[ShockProfile | ShockError]) -> Iterator[Diagnostic]:
    for result in results:
        if isinstance(result, ShockProfile):
            yield from result.health.warnings


def profiles_and_failures(
    cases: Mapping[str, tuple[Scene, Robot]],
    trace: Trace | None = None,
    done: Callable[[str], object] = str,
) -> tuple[dict[str, ShockProfile], dict[str, ShockError]]:
    """The profiles of landings by name, as `proven_profiles`, and why there are none of others.

    Raises:
        ShockError: there is none at all; the error is the first one, or one in shockpc itself.
    """
    computed: dict[str, ShockProfile] = {}
    failures: dict[str, ShockError] = {}
    for name, result in proven_profiles(cases, None, trace, done).items():
        if isinstance(result, ShockError):
            failures[name] = result
        else:
            computed[name] = result
    if not computed:
        raise max(failures.values(), key=lambda failure: bool(traces([failure])))
    return computed, failures


def profiles(
    cases: Mapping[str, tuple[Scene, Robot]], trace: Trace | None = None
) -> dict[str, ShockProfile]:
    """The profiles of landings by name, as `proven_profiles`; an error of one of them is raised.

    Raises:
        ShockError: the first of these.
    """
    read: dict[str, ShockProfile] = {}
    for name, result in proven_profiles(cases, None, trace).items():
        if isinstance(result, ShockError):
            raise result
        read[name] = result
    return read
