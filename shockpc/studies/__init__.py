"""Studies of many landings: each takes scenes and returns a record, or an iterator of chunks; none knows another."""

__all__: list[str] = []
