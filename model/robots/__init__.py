"""The shipped robots: files, meshes, contact bases and the scripts that make them."""
