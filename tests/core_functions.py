"""Lists the functions of Rust's `core` in bonebeam's code on a Cortex-M7 and on AArch64, for an auditor.

    tests/core_functions.py [LIST]

The image `no_panic` calls every public function of bonebeam, so what it calls and inlines of `core` is what bonebeam
does; on AArch64, `every-target` computes the golden cases. Names are those of the debug information, without generic
arguments. LIST, or the environment variable FERROCENE_SYMBOLS, names the certified subset of a qualified compiler, a
function a line: for Ferrocene, ferrocene/doc/symbol-report.csv of its repository at the release. Then those outside of
it are marked. The last lines name compiler and list.
"""

import hashlib
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = (ROOT / os.environ.get("CARGO_TARGET_DIR", "firmware/target")).resolve()
BUILD = ["cargo", "build", "--locked", "--quiet", "--release", "--config", "profile.release.debug=\"limited\"", "--target"]
# Folder, target and options of each image.
IMAGES = {
    "no_panic": ("firmware", "thumbv7em-none-eabihf", "--features no-panic --bin no_panic"),
    "every-target": ("firmware/every-target", "aarch64-unknown-none", "--bin every-target"),
}
# The escapes of mangled names.
ESCAPES = {"LT": "<", "GT": ">", "RF": "&", "BP": "*", "C": ",", "LP": "(", "RP": ")"}


def demangled(name):
    """The path of a mangled name, without the hash; closures count as the function around them."""
    parts, rest = [], name.removeprefix("_ZN")
    while match := re.match(r"\d+", rest):
        start, length = match.end(), int(match[0])
        parts.append(rest[start : start + length])
        rest = rest[start + length :]
    path = "::".join(part.removeprefix("_") if part.startswith("_$") else part for part in parts[:-1])
    # From the left: the end of one escape may look like the beginning of another.
    character = lambda code: ESCAPES.get(code[1]) or chr(int(code[1][1:], 16))
    path = re.sub(r"\$(u[0-9a-f]+|LT|GT|RF|BP|C|LP|RP)\$", character, path).replace("..", "::")
    return plain(path.split("::{{closure}}")[0])


def plain(name):
    """A name without lifetimes and names of lengths, which mangled names do not have."""
    name = re.sub(r"<'\w+>", "", re.sub(r"'\w+,? ", "", name.strip())).replace(", ", ",")
    return re.sub(r"(?<=,)[NM](?=[,>])", "_", name)


def of_core(image):
    """The functions of `core` that an image's debug information names."""
    text = subprocess.run(["llvm-dwarfdump", "--debug-info", image], check=True, capture_output=True, text=True).stdout
    names = set()
    for entry in re.split(r"\n\n", text):
        name = re.search(r'DW_AT_linkage_name\t\("(_ZN\w[^"]*)"', entry)
        if "DW_TAG_subprogram" in entry and name and re.search(r'DW_AT_decl_file\t\(".*/library/core/', entry):
            names.add(demangled(name[1]))
    return sorted(names)


def main():
    environment = {**os.environ, "CARGO_TARGET_DIR": str(TARGET), "MACHINE": "virt-aarch64"}
    of = {}
    for image, (folder, target, options) in IMAGES.items():
        subprocess.run([*BUILD, target, *options.split()], check=True, cwd=ROOT / folder, env=environment)
        of[target] = of_core(TARGET / target / "release" / image)
        if len(of[target]) < 50:
            sys.exit(f"{len(of[target])} functions of core: the debug information has none")
    path = (sys.argv[1:] or [os.environ.get("FERROCENE_SYMBOLS")])[0]
    listed = Path(path).read_bytes() if path else b""
    certified = {plain(line) for line in listed.decode().splitlines()}
    names = sorted(set().union(*of.values()))
    for name in names:
        mark = "" if not path else "certified  " if name in certified else "outside    "
        where = " ".join(f"{target:21}" if name in of[target] else " " * 21 for target in of)
        print(f"{mark}{where} {name}")
    print(subprocess.run(["rustc", "--version"], check=True, capture_output=True, text=True, cwd=ROOT).stdout, end="")
    if path:
        print(f"{len(certified)} functions in {path}, SHA-256 {hashlib.sha256(listed).hexdigest()}")
    for target, here in of.items():
        outside = f", {sum(name not in certified for name in here)} outside of the list" if path else ""
        print(f"{target}: {len(here)} functions of core{outside}")


if __name__ == "__main__":
    main()
