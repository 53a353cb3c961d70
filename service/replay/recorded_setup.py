"""The robot of a run from the metadata of its log, checked before anything is opened or computed.

A log may come from another person. The paths in it are names that its writer chose: they are opened only
where they lie beside the log, unless the caller allows it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from tauten.controller import Order, beside
from tauten.model.load import shipped_folder
from tauten.reduction.contact import SUFFIX as BASIS
from tauten.service.log import LogError, logged_description
from tauten.service.setup import Setup, load_setup
from tauten.service.wire import RunDescription

_PATH = "robot_path"  # an entry of the node's logs, not of those of `tauten record`


@dataclass(frozen=True, slots=True)
class RecordedSetup:
    """The robot of a run, as its log names it.

    Attributes:
        log: the file.
        file: path of the robot file when it was recorded; "" for a shipped robot.
        description: of the robot.
        by_node: whether the node has written it, rather than `tauten record` beside it.
    """

    log: Path
    file: str
    description: RunDescription
    by_node: bool

    def load(
        self, against: str | None = None, model: Order | None = None, allowed: bool = False
    ) -> Setup:
        """The setup that decides again what the log has.

        Args:
            against: robot to use instead of the recorded one, a name or a file.
            model: model to use instead of the recorded one.
            allowed: whether files that are not beside the log may be opened.

        Raises:
            LogError: the log is none of a node, or the recorded file lies elsewhere, and recorded paths are
                not allowed.
            RobotFileError, MeshError, BasisError, StateBasisError: the robot cannot be used.
        """
        if not self.by_node:
            raise LogError(
                f"{self.log}: a log of tauten record, whose messages are in the order of their arrival, "
                "cannot be replayed: record the run with tauten serve --record"
            )
        if against is None:
            name, basis = self.robot_file(allowed), self.contact_basis(allowed)
        else:
            name, basis = against, None
        said = self.description
        setup = load_setup(name, said.rate, basis, model or said.model.order, accept_error=True)
        return replace(setup, start=said.start)

    def robot_file(self, allowed: bool) -> str:
        """The robot to load: a file beside the log, the recorded path, or the name of a shipped robot.

        Raises:
            LogError: the recorded file lies elsewhere, and recorded paths are not allowed, or is gone, and no
                shipped robot has its name.
        """
        if self.file:
            beside = self.log.parent / Path(self.file).name
            if beside.suffix == ".toml" and beside.is_file():
                return str(beside)
            if Path(self.file).is_file() and not _is_shipped(self.file, self.description.name):
                if allowed:
                    return self.file
                raise LogError(
                    f"{self.log}: recorded with {self.file}, which is not beside the log: allow "
                    "recorded paths (--recorded-paths), or name the robot (--against)"
                )
            if not (shipped_folder() / f"{self.description.name}.toml").is_file():
                raise LogError(
                    f"{self.log}: recorded with {self.file}, which is neither beside the log nor where that "
                    "path leads from this folder: name the robot (--against)"
                )
        return self.description.name

    def contact_basis(self, allowed: bool) -> str:
        """The contact basis to load: a file beside the log, the recorded path, or a shipped name.

        Raises:
            LogError: the recorded file lies elsewhere, and recorded paths are not allowed.
        """
        basis = self.description.basis.name
        if Path(basis).name == basis:
            return self._named_basis(basis, allowed)
        here = self.log.parent / Path(basis).name
        if here.is_file():
            return str(here.resolve())
        if allowed:
            return basis
        raise LogError(
            f"{self.log}: recorded with the basis {basis}, which is not beside the log: "
            "allow recorded paths (--recorded-paths)"
        )

    def _named_basis(self, name: str, allowed: bool) -> str:
        """A basis that the log has by a name alone: of a file beside the robot file, or another one.

        Where the robot file is beside the log, and such a basis was beside the recorded one only, its path.

        Raises:
            LogError: recorded paths are not allowed.
        """
        robot = Path(self.robot_file(allowed))  # a file, or the name of a shipped robot
        recorded = beside(Path(self.file), name, BASIS)
        if robot.suffix != ".toml" or robot == Path(self.file) or not isinstance(recorded, Path):
            return name
        if isinstance(beside(robot, name, BASIS), Path):
            return name
        if allowed:
            return str(recorded.resolve())
        raise LogError(
            f"{self.log}: recorded with the basis {name} beside {self.file}, which is not beside the log: "
            "allow recorded paths (--recorded-paths)"
        )


def recorded_setup(log: Path, metadata: dict[str, str]) -> RecordedSetup:
    """The checked metadata of a log.

    Raises:
        LogError: a missing or wrong entry; the message names it.
    """
    description, file = logged_description(log, metadata), metadata.get(_PATH, "")
    if "\0" in file + description.basis.name:
        raise LogError(f"{log}: its metadata: a path has a zero byte")
    return RecordedSetup(log, file, description, by_node=_PATH in metadata)


def _is_shipped(file: str, robot: str) -> bool:
    """Whether a path is that of the shipped robot of this name, in any installation."""
    return Path(file).parts[-3:] == ("model", "robots", f"{robot}.toml")
