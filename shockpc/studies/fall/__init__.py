"""What of a robot strikes the ground when it tips over or is dropped, and what that does."""
