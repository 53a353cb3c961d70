"""The shipped robots: files, meshes and bases."""
