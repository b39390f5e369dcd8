"""Compares the functions of Rust's `core` in bonebeam's code with docs/core-functions.md, for an auditor.

    tests/core_functions.py [LIST NAME]

The image `no_panic` calls every public function of bonebeam, so what it calls and inlines of `core` is what bonebeam
does on a Cortex-M7; on AArch64, `every-target` computes the golden cases. Names are those of the debug information,
without generic arguments. Each must be in the document, which says whether it is certified. LIST is the certified
subset of a qualified compiler, a function a line, and NAME its version: with them the document is written anew.
"""

import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = (ROOT / os.environ.get("CARGO_TARGET_DIR", "firmware/target")).resolve()
BUILD = ["cargo", "build", "--locked", "--quiet", "--release", "--config", "profile.release.debug=\"limited\"", "--target"]
# Folder, target and options of each image.
IMAGES = {
    "no_panic": ("firmware", "thumbv7em-none-eabihf", "--features no-panic --bin no_panic"),
    "every-target": ("firmware/every-target", "aarch64-unknown-none", "--bin every-target"),
}
DOCUMENT = ROOT / "docs/core-functions.md"
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
    """A name without lifetimes and names of lengths, which mangled names do not have; newer ones of `Infallible` are `!`."""
    name = re.sub(r"<'\w+>", "", re.sub(r"'\w+,? ", "", name.strip())).replace(", ", ",")
    name = re.sub(r"::<(?!impl )", "<", re.sub("(drop_in_place)<.*", r"\1", name)).replace("core::convert::Infallible", "!")
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
    names = sorted(set().union(*of.values()))
    if sys.argv[1:]:
        certified = {plain(line) for line in Path(sys.argv[1]).read_text().splitlines()}
        DOCUMENT.write_text(document(of, [[name for name in names if (name in certified) == inside] for inside in (False, True)]))
    looked_up = set(DOCUMENT.read_text().splitlines())
    if new := [name for name in names if line(name, of) not in looked_up]:
        sys.exit("\n".join([*new, f"{len(new)} functions are not in {DOCUMENT}"]))
    print(f"{len(names)} functions, all in {DOCUMENT}")


def line(name, of):
    return " ".join(("x" if name in here else "-") for here in of.values()) + " " + name


def document(of, parts):
    """The document of the functions outside of the list and in it."""
    compiler = subprocess.run(["rustc", "--version"], check=True, capture_output=True, text=True, cwd=ROOT).stdout.strip()
    about = f"""What bonebeam calls or inlines of `core`, by {compiler}, beside the certified subset of a qualified
        compiler: {sys.argv[2]}. The marks are those of the two targets, in the order of the table. A name that only a
        newer or older `core` has counts as outside, and so does a shim of the compiler (`FnOnce::call_once`). Written
        by `tests/core_functions.py LIST NAME`; the step `core-functions` fails if an image calls another function."""
    text = f"""# Core functions

<!-- functions -->

{textwrap.fill(" ".join(about.split()), 120, break_long_words=False, break_on_hyphens=False)}

| | functions | outside |
|---|---|---|
"""
    for target, here in of.items():
        text += f"| `{target}` | {len(here)} | {sum(name in here for name in parts[0])} |\n"
    for title, part in zip(("Outside", "Certified"), parts):
        lines = "\n".join(line(name, of) for name in part)
        text += f"\n## {title}\n\n```text\n{lines}\n```\n"
    return text + "\n<!-- end of functions -->\n"


if __name__ == "__main__":
    main()
