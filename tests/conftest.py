"""Settings that hold for every test: the same examples on every machine, and no clock.

To look further than the fixed examples: python -m pytest --hypothesis-profile explore
"""

from hypothesis import HealthCheck, settings

COMMON = {"deadline": None, "database": None, "suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large]}

settings.register_profile("fixed", derandomize=True, max_examples=30, **COMMON)
settings.register_profile("explore", max_examples=200, **COMMON)
settings.load_profile("fixed")
