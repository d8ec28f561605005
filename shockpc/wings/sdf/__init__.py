"""Robots of SDFormat files."""
