"""Sweeps: many landings that differ in posture, strike, contact, inertia or joint model, as columns of arrays."""
