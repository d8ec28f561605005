"""A profile with some of its results replaced, to test what is printed of results that are hard to
compute or differ by machine.
"""

from shockpc.quantities.trust import Health


class Altered:
    """Looks like a profile; the attributes given are replaced."""

    def __init__(self, profile, **changes):
        self._profile = profile
        self.__dict__.update(changes)

    def __getattr__(self, name):
        return getattr(self._profile, name)


def health(**changes):
    """A health record in round numbers."""
    found = {
        "rank": 3,
        "rows": 3,
        "error_bound": 2e-16,
        "body_error_bounds": (2e-16,),
        "double_error": 6e-15,
        "data_sensitivity": 3e-15,
        "bits": 128,
        "warnings": (),
    }
    return Health(**found | changes)
