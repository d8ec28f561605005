"""Mechanical shock of a landing, body by body, from the rigid-body model alone."""

import lazy_loader

__version__ = "0.1.0"

# The stub beside this file lists what the package offers; each module is imported when one of its names is first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
