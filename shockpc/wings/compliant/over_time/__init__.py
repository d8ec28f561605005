"""A landing on contacts of finite stiffness over time."""
