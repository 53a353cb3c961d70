"""A router with the shipped configurations of Zenoh, and certificates of those who connect to it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import trustme
import zenoh

from tauten.service.wire import read_config

SHIPPED = Path(__file__).resolve().parents[2] / "docker" / "zenoh"
ROLES = ("node", "plant", "operator", "viewer")


@dataclass
class Site:
    """Where a router listens, and the files of those who connect to it."""

    folder: Path
    port: int
    password: bool

    def write(self, name: str, shipped: str, role: str, password: str = "") -> Path:
        """A shipped file with this site's paths, port and role."""
        text = (SHIPPED / shipped).read_text()
        for old, new in (
            ("/etc/tauten/tls/client", str(self.folder / role)),
            ("/etc/tauten/tls", str(self.folder)),
            ("/etc/tauten", str(self.folder)),
            ("router:7447", f"localhost:{self.port}"),
            ("0.0.0.0:7447", f"127.0.0.1:{self.port}"),
            ("USER", role),
            ("PASSWORD", password or f"{role}-secret"),
            ("timeout_ms: 10000", "timeout_ms: 2000"),
        ):
            text = text.replace(old, new)
        file = self.folder / f"{name}.json5"
        file.write_text(text)
        return file

    def client(self, role: str, password: str = "") -> Path:
        """The configuration of a role."""
        shipped = "client-password.json5" if self.password else "client.json5"
        return self.write(f"{role}-client", shipped, role, password)

    def router(self) -> zenoh.Session:
        shipped = "router-password.json5" if self.password else "router.json5"
        return zenoh.open(read_config(self.write("router", shipped, "router")))


def certificates(folder: Path) -> trustme.CA:
    """A CA, and a certificate for the router and each role."""
    authority = trustme.CA()
    authority.cert_pem.write_to_path(str(folder / "ca.pem"))
    issue(authority, folder, "router", "localhost")
    for role in ROLES:
        issue(authority, folder, role, role)
    return authority


def issue(authority: trustme.CA, folder: Path, role: str, name: str) -> None:
    found = authority.issue_cert(name, common_name=role)
    found.private_key_pem.write_to_path(str(folder / f"{role}.key"))
    for pem in found.cert_chain_pems:
        pem.write_to_path(str(folder / f"{role}.pem"), append=True)
