"""What other packages add to tauten, by a name: entry points of installed packages.

A package registers it in its pyproject.toml, below `[project.entry-points."tauten.drivers"]` for instance.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.metadata import entry_points
from inspect import Parameter, signature
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from tauten.model.extension_error import extension_error, is_own
from tauten.model.schema import Parameters, RobotFileError

T = TypeVar("T")


def extension_names(group: str) -> tuple[str, ...]:
    """Names that installed packages register in a group of entry points, sorted."""
    return tuple(sorted({entry.name for entry in entry_points(group=group)}))


def extension(
    group: str, name: str, own: Mapping[str, Callable[..., Any]] = MappingProxyType({})
) -> Callable[..., Any] | None:
    """What makes something of a name: tauten's own, or what an installed package registers; None: nothing.

    Args:
        group: of entry points, such as "tauten.drivers".
        name: in the group.
        own: what tauten has itself, by its names.

    Raises:
        RobotFileError: a package cannot be imported, registers what cannot be called, or the
            name is taken.
    """
    found = list(entry_points(group=group, name=name))
    values = [entry.value for entry in found] + ["tauten"] * (name in own)
    if len(set(values)) > 1:
        raise RobotFileError(
            f"{name} of the entry points {group} is registered by {' and by '.join(values)}: all but one "
            "of these packages need another name for it, or have to be removed"
        )
    if not found:
        return own.get(name)
    where = f"{name} of the entry points {group}: {found[0].value}"
    try:
        make = found[0].load()
    except Exception as error:  # whatever a module raises that is imported
        raise RobotFileError(
            f"{where} cannot be imported ({type(error).__name__}: {error})"
        ) from error
    if not callable(make):
        raise RobotFileError(f"{where} is no function or class: found {type(make).__name__}")
    named: Callable[..., Any] = make
    return named


def required_extension(group: str, name: str, field: str) -> Callable[..., Any]:
    """What an installed package registers by a name of a robot file.

    Raises:
        RobotFileError: no package has it, or as `extension`.
    """
    found = extension(group, name)
    if found is None:
        known = ", ".join(extension_names(group)) or "none"
        raise RobotFileError(
            f"{field}: no installed package has an entry point {name!r} in {group}, found are: {known}"
        )
    return found


def made(
    make: Callable[..., Any], kind: type, field: str, parameters: Parameters, *given: Any
) -> Any:
    """What a function of tauten or of another package makes with the parameters of a robot file.

    Args:
        make: the function or class.
        kind: interface that the result should have, see `check_interface`.
        field: where the robot file names it, for errors.
        parameters: of the robot file.
        given: arguments before these.

    Raises:
        RobotFileError: it takes other parameters, refuses their values by a ValueError, fails, or makes
            something else.
    """
    keywords = {name: _as_array(field, name, value) for name, value in parameters.items()}
    _check_names(make, len(given), field, set(parameters))
    try:
        found = make(*given, **keywords)
    except ValueError as error:
        raise RobotFileError(f"{field}.parameters: {error}") from error
    except Exception as error:
        if is_own(make):  # files that cannot be read
            raise
        raise RobotFileError(str(extension_error(field, error))) from error
    check_interface(found, kind, field)
    return found


def check_interface(found: object, kind: type, field: str) -> None:
    """Refuse what lacks a part of an interface, a protocol; the robot file names it in a field, for errors.

    Raises:
        RobotFileError: it lacks one, or a property fails.
    """
    try:
        lacking = [one for one in vars(kind) if not one.startswith("_") and not hasattr(found, one)]
    except Exception as error:
        raise RobotFileError(str(extension_error(field, error))) from error
    if lacking:
        kind_found = type(found).__name__
        raise RobotFileError(f"{field} makes a {kind_found}, which lacks {', '.join(lacking)}")


def at_rest(call: Callable[..., T], field: str, *given: Any) -> T:
    """What a function of another package gives where the robot is at rest.

    Raises:
        RobotFileError: it fails.
    """
    try:
        return call(*given)
    except Exception as error:
        raise RobotFileError(f"{extension_error(field, error)}, with the points at rest") from error


def _check_names(make: Callable[..., Any], given: int, field: str, names: set[str]) -> None:
    """Refuse parameters that a function does not have, and missing ones.

    Raises:
        RobotFileError: it takes others.
    """
    try:
        named = list(signature(make).parameters.values())[given:]
    except ValueError:  # compiled functions of some libraries do not say what they take
        return
    any_name = any(one.kind is Parameter.VAR_KEYWORD for one in named)
    named = [one for one in named if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)]
    allowed = [one.name for one in named]
    unknown = [] if any_name else sorted(names - set(allowed))
    missing = [one.name for one in named if one.default is one.empty and one.name not in names]
    if unknown or missing:
        wrong = [f"{name!r} is not one of them" for name in unknown]
        wrong += [f"{name!r} is missing" for name in missing]
        raise RobotFileError(
            f"{field}.parameters: {', '.join(wrong)}; allowed are: {', '.join(allowed)}"
        )


def _as_array(field: str, name: str, value: Any) -> Any:
    """A list as an array; other values as they are."""
    if not isinstance(value, list):
        return value
    try:
        return np.array(value)
    except ValueError as error:
        raise RobotFileError(
            f"{field}.parameters: {name}: rows of different lengths make no table"
        ) from error
