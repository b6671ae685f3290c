"""Packs what [package.metadata.deb] of Cargo.toml names, where there is no cargo-deb. Called by deb.sh.

deb.py MAINTAINER [VARIANT]: a variant's keys replace those of the whole package, as cargo-deb has it."""

import glob
import gzip
import hashlib
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib

manifest = tomllib.loads(pathlib.Path("Cargo.toml").read_text())
package = {
    key: manifest["workspace"]["package"][key] if value == {"workspace": True} else value
    for key, value in manifest["package"].items()
}
deb = package["metadata"]["deb"]
maintainer, *variants = sys.argv[1:]
for variant in variants:
    deb = deb | deb["variants"][variant]
name = deb.get("name", package["name"])
arch = subprocess.run(["dpkg", "--print-architecture"], check=True, capture_output=True, text=True).stdout.strip()
version = f"{package['version']}-{deb.get('revision', '1')}"
root = pathlib.Path("target/debian/root")
shutil.rmtree(root, ignore_errors=True)


def put(source: pathlib.Path, target: str, mode: int) -> None:
    """One asset; manual pages and the changelog are compressed, as the distribution wants them."""
    place = root / target
    if target.endswith("/"):
        place /= source.name
    place.parent.mkdir(parents=True, exist_ok=True)
    if "usr/share/man/" in str(place) or place.name == "changelog.Debian":
        place = place.with_name(place.name + ".gz")
        place.write_bytes(gzip.compress(source.read_bytes(), mtime=0))
    else:
        shutil.copyfile(source, place)
    place.chmod(mode)


for pattern, target, mode in deb["assets"]:
    sources = sorted(glob.glob(pattern))
    assert sources, f"nothing is {pattern}"
    for source in sources:
        put(pathlib.Path(source), target, int(mode, 8))
put(pathlib.Path(deb["changelog"]), f"usr/share/doc/{name}/", 0o644)
licence = pathlib.Path(deb["license-file"][0]).read_text()
copyright = root / "usr/share/doc" / name / "copyright"
copyright.parent.mkdir(parents=True, exist_ok=True)
copyright.write_text(f"Copyright: {deb['copyright']}\nLicense: {package['license']}\n\n{licence}")


def depends() -> str:
    """Of the program, as cargo-deb's $auto: the packages of its libraries, in the versions of the symbols it needs."""
    packages = {"libc.so.6": "libc6", "libm.so.6": "libc6", "libgcc_s.so.1": "libgcc-s1"}
    readelf = ["readelf", "--dynamic", "--version-info", "--wide", str(root / "usr/bin" / package["name"])]
    told = subprocess.run(readelf, check=True, capture_output=True, text=True).stdout
    libraries = re.findall(r"\(NEEDED\).*\[(.*)\]", told)
    needed = {packages[library] for library in libraries if not library.startswith("ld-linux")}
    versions = {"libc6": "GLIBC", "libgcc-s1": "GCC"}
    newest = {name: max(re.findall(rf"\b{versions[name]}_([0-9.]+)", told), key=numbers) for name in needed}
    return ", ".join(f"{name} (>= {newest[name]})" for name in sorted(needed))


def numbers(version: str) -> list[int]:
    return [int(part) for part in version.split(".")]


control = root / "DEBIAN"
control.mkdir()
# A static program needs nothing.
needed = deb["depends"].replace("$auto", depends())
needed = f"Depends: {needed}\n" if needed else ""
relations = "".join(f"{key.title()}: {deb[key]}\n" for key in ("provides", "conflicts", "replaces") if key in deb)
size = sum(file.stat().st_size for file in root.rglob("*") if file.is_file()) // 1024
description = "\n".join(f" {line.strip() or '.'}" for line in deb["extended-description"].strip().splitlines())
(control / "control").write_text(f"""\
Package: {name}
Version: {version}
Architecture: {arch}
Maintainer: {maintainer}
Section: {deb["section"]}
Priority: {deb["priority"]}
{needed}{relations}Installed-Size: {size}
Description: {package["description"]}
{description}
""")
(control / "conffiles").write_text("".join(f"{name}\n" for name in deb["conf-files"]))
packed = sorted(file for file in root.rglob("*") if file.is_file() and control not in file.parents)
sums = (f"{hashlib.md5(file.read_bytes()).hexdigest()}  {file.relative_to(root)}\n" for file in packed)
(control / "md5sums").write_text("".join(sums))
for script in sorted(pathlib.Path(deb["maintainer-scripts"]).iterdir()):
    shutil.copyfile(script, control / script.name)
    (control / script.name).chmod(0o755)
for folder in [root, *(path for path in root.rglob("*") if path.is_dir())]:
    folder.chmod(0o755)
file = f"target/debian/{name}_{version}_{arch}.deb"
subprocess.run(["dpkg-deb", "--root-owner-group", "--build", str(root), file], check=True, stdout=subprocess.DEVNULL)
shutil.rmtree(root)
print(file)
