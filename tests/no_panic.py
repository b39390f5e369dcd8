"""Is every function of the core in the image that cannot be linked while a panic is left in it?

    tests/no_panic.py            all functions, by one link
    tests/no_panic.py --panics   a real panic in every 68th of them, by a link each

Works on a copy of the tree below the target folder. Each function of the core gets a panic of its own at the
start of its body, behind a condition that the compiler knows nothing of: the call of a function that is nowhere,
has a number and does not return. The linker refuses the image and names all that it misses: these are the panics
that would be left, and so the functions that the image calls. What the compiler works out beforehand (`const`) or
has shown to be never called is not missed. The others must be among the exceptions; an exception that is called is
refused as well.

A function that the core exports must be called by the image itself, too, with arguments that the compiler knows
nothing of: what the core passes may rule out a panic.

So that a `const fn` may call it, the compiler's own `const_eval_select` chooses: nothing while compiling, the
call at run time. It is not stable, hence RUSTC_BOOTSTRAP.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = (ROOT / os.environ.get("CARGO_TARGET_DIR", "target")).resolve() / "no-panic"
TREE = TARGET / "tree"
# A condition that the compiler knows nothing of.
UNKNOWN = "core::hint::black_box(false)"

# Functions that the image does not call, by a pattern of their names, with the reason.
EXCEPTIONS = {
    r"^formats.rs:|defmt::Format for": "for defmt: called by the logger's table of symbols",
    r"^error.rs: .*Display": "the wording of an error: the standard library's formatting panics",
    r"^simd/(lanes|dispatch).rs:": "not built: vectors of several lanes",
    r"^simd/mod.rs: pub trait Vector.* is_finite$": "f32 has its own",
    r"^magnitude.rs: (side_by_side|magnitude)$": "registers of several lanes",
    r"^phase_symmetry/columns.rs: .*store_squares$": "several lanes",
    r"^delay/groups.rs: .*is_consecutive$": "several lanes",
    r"^beamform/snapshot.rs: (register|gather_lanes)$": "registers of several lanes",
    r"^delay/iq/(chunk.rs: .*Chunk<V> \w+$|(records|taps).rs:)": "several lanes; one has one_lane.rs",
    r"^delay/iq/line.rs: (impl IqParameters (chunks|depths|groups)|impl Depths \w+|turned|put)$": "several lanes",
    r"^delay/iq/interpolation.rs: (.* for (Linear|Cubic|Sinc) read|impl Sinc values)$": "several lanes",
    r"^simd/gather.rs:": "several lanes",
    r"^beamform/pushes.rs: impl SampleIndex next$": "several lanes",
    r"^beamform/methods/eigenspace.rs: (merge|exchange)$": "several lanes",
    r"^image/median.rs: neighbourhood$": "several lanes; one has row_by_columns",
    r"^linalg/implicit_ql.rs: .*(block|next)$": "several lanes; one has block_of_one",
    r"^instructions.rs: (prefetch|sqrt)$": "another processor's, or not called on this one",
    r"^delay/decimator/mod.rs: half_band$": "const: worked out while compiling",
    r"^delay/iq/(fixed.rs: half|interpolation.rs: impl Sinc new|phasor.rs: constant_phasor)$": "const",
    r"^surface/logarithm.rs: mantissa$": "const: worked out while compiling",
    r"^phase_symmetry/fft64.rs: twiddle$": "const: worked out while compiling",
    r"^phase_symmetry/log_gabor.rs: (orientation|impl LogGaborTables of|cubic_at)$": "const",
}


def without_comments(text):
    """The text with spaces for comments, strings and characters, as long as before."""
    pattern = r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\\n])\''
    return re.sub(pattern, lambda m: re.sub(r"[^\n]", " ", m[0]), text, flags=re.S)


def exported():
    """The names of functions and types that the core exports."""
    source = ROOT / "core/src"
    public = re.findall(r"^pub mod (\w+);", (source / "lib.rs").read_text(), re.M)
    names = set()
    for path in source.rglob("*.rs"):
        code = without_comments(path.read_text())
        for use in re.findall(r"^pub use ([^;]*);", code, re.M):
            names.update(re.findall(r"\w+", use))
        if path in [source / end for name in public for end in (f"{name}.rs", f"{name}/mod.rs")]:
            names.update(re.findall(r"^pub (?:const )?(?:fn|struct|enum|trait) (\w+)", code, re.M))
    return names


def functions(path):
    """Name and start of the body of each function of a file, without its tests."""
    code = without_comments(path.read_text())
    code = re.split(r"#\[cfg\(test\)\]\s+(?:pub\S* )?mod tests", code)[0]
    scopes = [
        (m.start(), code.find("\n}", m.start()), " ".join(m[0].split()))
        for m in re.finditer(r"^(?:impl|pub trait|pub\(crate\) trait|trait|macro_rules!)[^{]*", code, re.M)
    ]
    for m in re.finditer(r"(#\[cfg\(test\)\]\s*(?:pub\S* )?(?:const )?)?\bfn (\w+)", code):
        depth = 0
        for at in range(m.end(), len(code)):
            depth += {"(": 1, "[": 1, ")": -1, "]": -1}.get(code[at], 0)
            if depth == 0 and code[at] in "{;":
                break
        if m[1] or code[at] == ";":
            continue
        within = [scope for start, end, scope in scopes if start < m.start() < end]
        scope = within[-1] + " " if within else ""
        file = path.relative_to(TREE / "core/src").as_posix()
        yield f"{file}: {scope}{m[2]}", at + 1


def not_called_by_the_image():
    """Exported functions whose names the image's own sources do not have."""
    image = "".join(p.read_text() for p in (ROOT / "firmware/src/bin/no_panic").glob("*.rs"))
    called = set(re.findall(r"\w+", image))
    names = exported()
    for path in sorted((ROOT / "core/src").rglob("*.rs")):
        scope = ""
        for line in without_comments(path.read_text()).splitlines():
            if line.startswith(("impl", "macro_rules!", "mod tests")):
                owner = re.match(r"impl(?:<.*?>)? (\w+)", line)
                scope = owner[1] if owner else line
            if m := re.match(r"( *)pub (?:const )?fn (\w+)", line):
                at = m[2] if m[1] == "" else scope
                if (at in names or at.startswith("macro_rules!")) and m[2] not in called:
                    yield f"{path.relative_to(ROOT / 'core/src').as_posix()}: {m[2]}"


def put(calls):
    """Writes the copy of the core; `calls(k)` is what function k gets. Returns the functions' names."""
    # Not in what runs while the image is built.
    names = []
    for path in sorted((TREE / "core/src").rglob("*.rs")):
        relative = path.relative_to(TREE)
        if "tests" in path.parts or path.name == "tests.rs":
            continue
        text = (ROOT / relative).read_text()
        path.write_text(text)
        found = list(functions(path))
        for k, (_, at) in reversed(list(enumerate(found, len(names)))):
            if call := calls(k):
                call = f"const fn no() {{}} #[inline(always)] fn yes() {{ {call} }}"
                choice = "core::intrinsics::const_eval_select((), no, yes);"
                text = text[:at] + f' #[cfg(target_os = "none")] {{ {call} {choice} }} ' + text[at:]
        names += [name for name, _ in found]
        if relative.name == "lib.rs":
            gates = "#![feature(core_intrinsics, const_eval_select)]\n#![allow(internal_features, unsafe_code)]\n"
            text = text.replace("#![no_std]\n", gates + "#![no_std]\n", 1)
        path.write_text(text)
    return names


def link():
    """What the linker says of the image."""
    command = "cargo rustc --locked --release --features no-panic --bin no_panic --".split()
    environment = dict(os.environ, RUSTC_BOOTSTRAP="1", CARGO_TARGET_DIR=str(TARGET / "built"))
    run = subprocess.run(
        command + ["-Clink-arg=--error-limit=0"], cwd=TREE / "firmware", env=environment, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )
    if run.returncode != 0 and "undefined symbol" not in run.stdout:
        sys.exit(run.stdout)
    return run.stdout


def exception(name):
    return next((pattern for pattern in EXCEPTIONS if re.search(pattern, name)), None)


def all_at_once():
    names = put(lambda k: f'unsafe extern "C" {{ safe fn panic_{k}() -> !; }} if {UNKNOWN} {{ panic_{k}() }}')
    reached = {int(k) for k in re.findall(r"undefined symbol: panic_(\d+)", link())}
    missing = [n for k, n in enumerate(names) if k not in reached and not exception(n)]
    not_called = {name for k, name in enumerate(names) if k not in reached}
    called = {names[k] for k in reached} - not_called
    needless = {exception(name): name for name in called if exception(name)}
    unused = [p for p in EXCEPTIONS if not any(re.search(p, name) for name in names)]
    indirect = [n for n in not_called_by_the_image() if not exception(n)]
    for name in missing:
        print("not in the image:", name)
    for name in indirect:
        print("exported, and not called by the image itself:", name)
    for pattern, name in needless.items():
        print(f"in the image, though an exception ({pattern}): {name}")
    for pattern in unused:
        print("an exception of no function:", pattern)
    if missing or indirect or needless or unused:
        sys.exit("firmware/src/bin/no_panic must call each, or tests/no_panic.py name it with its reason")
    print(f"{len(names)} functions: {len(reached)} in the image, {len(names) - len(reached)} exceptions")
    return names, reached


def panics():
    names, reached = all_at_once()
    for chosen in sorted(reached)[::68]:
        call = f"if {UNKNOWN} {{ panic!() }}"
        put(lambda k: call if k == chosen else None)
        refused = "undefined symbol: a_panic_is_left" in link()
        print("refused:" if refused else "LINKED:", names[chosen])
        if not refused:
            sys.exit(1)


def copy():
    TREE.mkdir(parents=True, exist_ok=True)
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    files = subprocess.run(listed, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout
    for name in files.decode().split("\0"):
        source, copied = ROOT / name, TREE / name
        if name and source.is_file():
            copied.parent.mkdir(parents=True, exist_ok=True)
            if not copied.exists() or copied.read_bytes() != source.read_bytes():
                copied.write_bytes(source.read_bytes())
    # A file that is gone from the core is gone from the copy.
    for copied in (TREE / "core/src").rglob("*.rs"):
        if not (ROOT / copied.relative_to(TREE)).is_file():
            copied.unlink()


copy()
panics() if "--panics" in sys.argv else all_at_once()
