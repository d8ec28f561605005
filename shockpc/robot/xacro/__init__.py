"""xacro files become URDFs."""
