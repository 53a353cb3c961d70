"""Robots and bases for tests of reduced models."""
