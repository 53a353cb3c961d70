"""What shows that a mesh file is cut off: readers take it for text, or read on without what is missing."""

from __future__ import annotations

import re
import struct

ENDS = {".ply": b"end_header", ".vtu": b"</VTKFile>", ".msh": b"$EndElements"}  # by suffix
STARTS = {".msh": b"$MeshFormat"}  # of the format that has this end, where a suffix has several
STL_HEADER, STL_TRIANGLE = 84, 50  # bytes


def why_not_whole(contents: bytes, suffix: str) -> str:
    """Why a file cannot be a whole mesh file of the format that its suffix names; "" if nothing shows it."""
    if not contents.strip():
        return "it is empty"
    if suffix == ".stl":
        return _why_no_stl(contents)
    if suffix in ENDS and STARTS.get(suffix, b"") in contents and ENDS[suffix] not in contents:
        return f"it is cut off, or of another format: '{ENDS[suffix].decode()}' is missing"
    return ""


def missing_cells(contents: bytes, found: int) -> str:
    """Why a VTK file of which this number of cells has been read is not whole; "" if nothing shows it."""
    said = re.search(rb"\nCELL_TYPES\s+(\d+)", contents)
    if said is None or found >= int(said[1]):
        return ""
    return f"it is cut off: it has {found} of {int(said[1])} cells"


def _why_no_stl(contents: bytes) -> str:
    """The same for the contents of an STL file: text ends with a word, binary files count their triangles."""
    binary = len(contents) >= STL_HEADER
    count = struct.unpack_from("<I", contents, STL_HEADER - 4)[0] if binary else 0
    expected = STL_HEADER + STL_TRIANGLE * count
    if binary and len(contents) == expected:
        return ""
    if contents.lstrip().startswith(b"solid") and b"\0" not in contents:
        return "" if b"endsolid" in contents else "it is cut off: 'endsolid' is missing"
    if not binary:
        return f"it has {len(contents)} bytes, the header of an STL file has {STL_HEADER}"
    return (
        f"it is cut off, or no STL file: it has {len(contents)} bytes, the {count} triangles that its "
        f"header counts need {expected}"
    )
