"""The shapes of a robot's bodies: convex pieces, meshes, and how far they reach."""
