"""What goes into the program, as a bill of materials (CycloneDX 1.6, JSON) on the standard output.

sbom.py [--gateway]: with it, of the service without tools. Fails where something is under a licence that is not in LICENCES, of
what the program is made of and of what builds and tests it alike. The same lock file gives the same bytes."""

import json
import pathlib
import re
import subprocess
import sys

# Those under which everything may be passed on together with a program under MIT.
LICENCES = {"0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "CC0-1.0",
            "ISC", "MIT", "MIT-0", "Unicode-3.0", "Unlicense", "Zlib"}


def may(expression: str) -> bool:
    """Whether an SPDX expression leaves a choice among LICENCES."""
    tokens = re.findall(r"[()]|[^\s()]+(?: WITH [^\s()]+)?", expression)

    def either() -> bool:
        found = [both()]
        while tokens and tokens[0] == "OR":
            tokens.pop(0)
            found.append(both())
        return any(found)

    def both() -> bool:
        found = [one()]
        while tokens and tokens[0] == "AND":
            tokens.pop(0)
            found.append(one())
        return all(found)

    def one() -> bool:
        token = tokens.pop(0) if tokens else ""
        if token != "(":
            return token in LICENCES
        found = either()
        return bool(tokens) and tokens.pop(0) == ")" and found

    return either() and not tokens


def licence(package: dict) -> str:
    """As SPDX has it; a slash between two is an old way to say "or"."""
    return re.sub(r"\s*/\s*", " OR ", package["license"] or "")


def component(package: dict, kind: str) -> dict:
    reference = f"pkg:cargo/{package['name']}@{package['version']}"
    found = {"type": kind, "bom-ref": reference, "name": package["name"], "version": package["version"],
             "licenses": [{"expression": licence(package)}], "purl": reference}
    checksum = CHECKSUMS.get((package["name"], package["version"]))
    if checksum:
        found["hashes"] = [{"alg": "SHA-256", "content": checksum}]
    if package["repository"]:
        found["externalReferences"] = [{"type": "vcs", "url": package["repository"]}]
    return found


def plots() -> dict:
    """The library that draws a page's plots: it is no crate."""
    folder = pathlib.Path("src/lab/report/uplot")
    version = re.search(r"\(v([\d.]+)\)", (folder / "uPlot.iife.min.js").read_text())[1]
    reference = f"pkg:npm/uplot@{version}"
    return {"type": "library", "bom-ref": reference, "name": "uplot", "version": version,
            "licenses": [{"expression": "MIT"}], "purl": reference}


only_service = sys.argv[1:] == ["--gateway"]
if sys.argv[1:] and not only_service:
    sys.exit(__doc__)
LOCKED = re.compile(r'name = "(.+)"\nversion = "(.+)"\nsource = .+\nchecksum = "(.+)"')
CHECKSUMS = {(name, version): checksum for name, version, checksum in LOCKED.findall(pathlib.Path("Cargo.lock").read_text())}
asked = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", "x86_64-unknown-linux-gnu"]
metadata = json.loads(subprocess.run(asked, check=True, capture_output=True).stdout)
packages = {package["id"]: package for package in metadata["packages"]}
nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
wrong = [f"{one['name']} {one['version']}: {one['license']}" for one in packages.values() if not may(licence(one))]
if wrong:
    sys.exit("licences that are not in LICENCES of systemd/sbom.py: " + "; ".join(wrong))

# What cargo would build of the program, without what only its tests need.
tree = ["cargo", "tree", "--locked", "-p", "gripd", "-e", "normal", "--target", "x86_64-unknown-linux-gnu",
        "--prefix", "none", "--format", "{p}"] + ["--no-default-features"] * only_service
lines = subprocess.run(tree, check=True, capture_output=True, text=True).stdout.splitlines()
named = {tuple(line.split()[:2]) for line in lines}
of_name = {(one["name"], "v" + one["version"]): identity for identity, one in packages.items()}
used = sorted((of_name[name] for name in named), key=lambda identity: (packages[identity]["name"], packages[identity]["version"]))
program = next(identity for identity in used if packages[identity]["name"] == "gripd")
references = {identity: component(packages[identity], "library")["bom-ref"] for identity in used}
dependencies = []
for identity in used:
    needs = {references[need["pkg"]] for need in nodes[identity]["deps"]
             if need["pkg"] in references and any(kind["kind"] is None for kind in need["dep_kinds"])}
    dependencies.append({"ref": references[identity], "dependsOn": sorted(needs)})
components = [component(packages[identity], "library") for identity in used if identity != program]
if not only_service:
    components.append(plots())
    dependencies.append({"ref": components[-1]["bom-ref"]})
    lab = next(one for one in dependencies if "/gripd-lab@" in one["ref"])
    lab["dependsOn"].append(components[-1]["bom-ref"])
json.dump({
    "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
    "bomFormat": "CycloneDX",
    "specVersion": "1.6",
    "version": 1,
    "metadata": {"component": component(packages[program], "application")},
    "components": components,
    "dependencies": dependencies,
}, sys.stdout, indent=1)
print()
