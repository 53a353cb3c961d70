"""The container files: what they promise can be checked without a container engine."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import zenoh
from jsonschema import Draft202012Validator
from ruamel.yaml import YAML
from support.processes import START, start_script

from tauten.service.link import Keys
from tauten.service.wire import read_config

ROOT = Path(__file__).resolve().parents[2]
DOCKER = ROOT / "docker"
SCHEMA = Path(__file__).with_name("compose_spec.json")


@pytest.fixture(scope="module")
def compose() -> dict[str, Any]:
    found = YAML(typ="safe").load(DOCKER / "compose.yaml")
    assert isinstance(found, dict)
    return found


def test_compose_fits_its_schema(compose: dict[str, Any]) -> None:
    schema = json.loads(SCHEMA.read_text())
    errors = [error.message for error in Draft202012Validator(schema).iter_errors(compose)]
    assert errors == []
    broken = {**compose, "services": {"node": {"imagine": "x"}}}
    assert not Draft202012Validator(schema).is_valid(broken)


@pytest.mark.long
def test_the_program_that_compiles_the_images_kernels_runs(tmp_path: Path) -> None:
    """With the kernels of this machine; the whole step, into an empty cache, takes minutes."""
    steps = (DOCKER / "build_steps.sh").read_text()
    program = tmp_path / "program.py"
    program.write_text(steps.split("<<'PYTHON'\n")[1].split("\nPYTHON\n")[0])
    process = start_script(tmp_path / "output.txt", program)
    assert process.process.wait(START) == 0, process.output.read_text()


def test_everything_that_compose_mentions_exists(compose: dict[str, Any]) -> None:
    for service in compose["services"].values():
        for kind in ("configs", "secrets"):
            for item in service.get(kind, []):
                assert item["source"] in compose[kind]
        for network in service["networks"]:
            assert network in compose["networks"]
        if "build" in service:
            build = service["build"]
            context = (DOCKER / build["context"]).resolve()
            assert (context / build["dockerfile"]).is_file()
        # tmpfs: for Matplotlib's folder in the Dockerfile; init: zenohd as first process ignores signals
        assert service["read_only"]
        assert service["tmpfs"] == ["/tmp"] if "build" in service else service["init"]
        # nothing runs as root with rights, nothing follows a moving tag
        assert service["cap_drop"] == ["ALL"]
        assert re.search(r":\d+\.\d+\.\d+$", service["image"])
    for config in compose["configs"].values():
        read_config(DOCKER / config["file"])


def test_every_configuration_is_one_for_zenoh() -> None:
    files = sorted((DOCKER / "zenoh").glob("*.json5"))
    assert len(files) == 4
    for file in files:
        read_config(file)


@pytest.mark.parametrize("name", ["router.json5", "router-password.json5"])
def test_routers_let_pass_every_key(name: str) -> None:
    """The rule of questions allows all keys, but no message that somebody publishes."""
    config = read_config(DOCKER / "zenoh" / name)
    rules = json.loads(config.get_json("access_control/rules"))
    allowed = [
        zenoh.KeyExpr(key)
        for rule in rules
        if {"put", "reply", "liveliness_token"} & set(rule["messages"])
        and "ingress" in rule["flows"]
        for key in rule["key_exprs"]
    ]
    keys = Keys("finger")
    texts = {name for name in dir(keys) if isinstance(getattr(keys, name), str)}
    names = {name for name in texts if not name.startswith("__")} - {"robot"}
    assert {"open_contacts", "starting"} <= names
    for key in sorted(names - {"plant"}):  # stands for several
        expression = zenoh.KeyExpr(getattr(keys, key))
        assert any(one.includes(expression) for one in allowed), key


def test_the_dockerfile_is_pinned_multi_stage_and_not_root() -> None:
    lines = (DOCKER / "Dockerfile").read_text().splitlines()
    bases = [line for line in lines if line.startswith("FROM ")]
    assert len(bases) == 2
    assert all(re.search(r"@sha256:[0-9a-f]{64}", base) for base in bases)
    assert any(line.startswith("HEALTHCHECK ") for line in lines)
    user = [index for index, line in enumerate(lines) if line.startswith("USER ")]
    assert lines[user[-1]] == "USER 10001"
    assert user[-1] > lines.index(bases[1])
    sent = (DOCKER / "Dockerfile.dockerignore").read_text().splitlines()
    for line in lines:
        if line.startswith("COPY ") and "--from" not in line:
            for source in line.split()[1:-1]:
                assert (ROOT / source).exists()
                assert f"!{source}" in sent
    # with the home of the user, which is read-only, each command that draws warned of it
    assert "    MPLCONFIGDIR=/tmp/matplotlib \\" in lines


def test_hadolint_finds_nothing() -> None:
    hadolint = Path(sys.executable).with_name("hadolint")  # a package of the extra "test"
    subprocess.run([str(hadolint), str(DOCKER / "Dockerfile")], check=True, timeout=60.0)


def test_docker_compose_accepts_it(compose: dict[str, Any]) -> None:
    """Version 2, a plugin of docker; version 1, the program docker-compose, does not know all keys."""
    docker = shutil.which("docker")
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    if docker is None or subprocess.call([docker, "compose", "version"], **quiet):
        pytest.skip("docker has no compose; test_services.py runs the services without it")
    command = [docker, "compose", "-f", str(DOCKER / "compose.yaml"), "config", "--services"]
    done = subprocess.run(command, check=True, timeout=60.0, capture_output=True, text=True)
    profiled = {name for name, service in compose["services"].items() if "profiles" in service}
    assert set(done.stdout.split()) == set(compose["services"]) - profiled


PLANT = """
from tauten.model import one_blas_thread
from tauten.service.plant import PlantSettings, plant_robot, plant_setup, warm_plant

with one_blas_thread():
    for model in (None, "full"):
        setup, _ = plant_setup(plant_robot("finger", None, model), model)
        warm_plant(setup.robot, PlantSettings())
"""


@pytest.mark.slow
def test_the_images_steps_run_without_an_engine(tmp_path: Path) -> None:
    steps = DOCKER / "build_steps.sh"
    prefix = tmp_path / "tauten"
    environment = {**os.environ, "TAUTEN_KERNEL_SEED": "off"}  # as with another Python
    source = tmp_path / "src"
    source.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE", ".ci/constraints.txt"):
        (source / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, source / name)
    ignored = shutil.ignore_patterns("__pycache__")
    for name in ("model", "reduction", "controller", "service"):
        shutil.copytree(ROOT / name, source / name, ignore=ignored)
    for arguments in (("install", prefix, source), ("warm", prefix), ("check", prefix)):
        step = ["bash", str(steps), *map(str, arguments)]
        subprocess.run(step, env=environment, check=True, timeout=900.0)
    compiled = set((prefix / "cache").rglob("*.nbi"))
    assert compiled
    # the image cannot be written to: what is not compiled by now would be at each start
    environment["NUMBA_CACHE_DIR"] = str(prefix / "cache")
    plant = [prefix / "bin" / "python", "-c", PLANT]
    subprocess.run(plant, env=environment, check=True, timeout=900.0)
    assert set((prefix / "cache").rglob("*.nbi")) == compiled
    bad = subprocess.run(["bash", str(steps), "fly"], capture_output=True, check=False)
    assert bad.returncode == 2
