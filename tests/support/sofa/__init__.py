"""Robots of SOFA that act on what they touch."""
