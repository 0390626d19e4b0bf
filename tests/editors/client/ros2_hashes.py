"""Hashes of the types of ROS 2 packages, as JSON: `ros2_hashes.py PACKAGES OUTPUT SHARE`.

The tools of ROS 2 convert each interface file to `.idl`, parse it and describe its types. `SHARE` has the
descriptions of the packages of ROS 2. A file that the tools refuse ends the program.
"""

import contextlib
import json
import pathlib
import sys

from catkin_pkg.topological_order import topological_order
from rosidl_adapter import convert_to_idl
from rosidl_generator_type_description import generate_type_hash

# Packages that the build adds to those with services or actions.
IMPLIED = {"builtin_interfaces", "service_msgs", "unique_identifier_msgs"}


def read(description: pathlib.Path, found: dict[str, str]) -> None:
    for entry in json.loads(description.read_text())["type_hashes"]:
        found[entry["type_name"]] = entry["hash_string"]


def hashes(packages: pathlib.Path, output: pathlib.Path, share: pathlib.Path) -> dict[str, str]:
    described = {folder.name: folder for folder in share.iterdir()}
    found = {}
    for file in share.glob("*/[ms][sr][gv]/*.json"):
        read(file, found)
    for path, package in topological_order(str(packages)):
        source, target = packages / path, output / package.name
        files = sorted(file.relative_to(source) for file in source.glob("*/*"))
        idl = [convert_to_idl(source, package.name, file, target) for file in files]
        # A type is only found in a package that the manifest names.
        needed = IMPLIED.union(depend.name for depend in package.build_depends)
        arguments = output / f"{package.name}.json"
        words = {
            "package_name": package.name,
            "output_dir": str(target),
            "idl_tuples": [f"{target}:{file.relative_to(target)}" for file in idl],
            "include_paths": [f"{name}:{described[name]}" for name in sorted(needed)],
        }
        arguments.write_text(json.dumps(words))
        for file in generate_type_hash(str(arguments)):
            read(file, found)
        described[package.name] = target
    return found


if __name__ == "__main__":
    # The tools print the names of their files.
    with contextlib.redirect_stdout(sys.stderr):
        result = hashes(*(pathlib.Path(argument).resolve() for argument in sys.argv[1:]))
    print(json.dumps(result))
