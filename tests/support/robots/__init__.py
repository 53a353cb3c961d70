"""Robots and bodies of tests."""
