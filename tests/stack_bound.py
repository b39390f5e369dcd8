"""Bounds the stack below functions of a Cortex-M image, from its disassembly.

    tests/stack_bound.py OBJDUMP IMAGE [write | compare] < what the image `stack` printed

Each line `stack NAME BYTES ADDRESS` names a function. Its bound is the bytes that it takes, pushed or subtracted, and
the largest bound of what it calls. Refused are recursion, an indirect call that INDIRECT does not list, a stack pointer
of another origin, and a bound below the bytes that were found by painting. Prints the table of docs/memory.md, writes
it there, or compares: figures of the document may be 5 % off.
"""

import pathlib
import re
import subprocess
import sys

DOCUMENT = pathlib.Path(__file__).parent.parent / "docs/memory.md"
# The document's table, with what is around it.
TABLE = re.compile(r"(<!-- stack -->\n)(.*?)(<!-- end of stack -->)", re.DOTALL)

# Functions that call by address, and all that they may call there; the first that fits counts.
INDIRECT = {
    # The caller's progress, from that of a stage.
    r"in_steps::\{\{closure": r"(image|median)::\{\{closure|call_once",
    # The external memory, the transforms, the gains; progress.
    r"phase_symmetry|^stack::call": r"phase_symmetry::external|Gains<.*::fill|Fft>::|closure|call_once",
    r"image::": r"closure|call_once",
}
# What ends the program: it does not return, and its stack is not counted.
ENDS = re.compile(r"core::panicking|rust_begin_unwind|slice_index_fail|unwrap_failed")


def registers(text):
    """The bytes of a list of registers, as in `{r4, r5, d8-d11}`."""
    total = 0
    for part in re.findall(r"[^{},\s]+", text):
        ends = re.findall(r"([a-z]+)(\d*)", part)
        count = int(ends[-1][1]) - int(ends[0][1]) + 1 if "-" in part else 1
        total += count * (8 if part[0] == "d" else 4)
    return total


def frame_of(mnemonic, operands, where):
    """The bytes that an instruction takes from the stack."""
    base = mnemonic.split(".")[0]
    if base in ("push", "vpush"):
        return registers(operands)
    if re.match(r"(v?stmdb|vstmdb)$", base) and operands.startswith("sp!"):
        return registers(operands.split(",", 1)[1])
    pre_indexed = re.search(r"\[sp, #-(\w+)\]!", operands)
    if pre_indexed:
        return int(pre_indexed[1], 0)
    if base in ("sub", "subw") and operands.startswith("sp"):
        immediate = re.search(r"#(\w+)$", operands)
        if not immediate:
            sys.exit(f"stack of unknown size: {where}: {mnemonic} {operands}")
        return int(immediate[1], 0)
    return 0


def plain(name):
    """A name as Rust writes it, where the disassembler leaves escapes."""
    for escape, written in (("$u7b$", "{"), ("$u7d$", "}"), ("$LT$", "<"), ("$GT$", ">"), ("$u20$", " "), ("..", "::")):
        name = name.replace(escape, written)
    return name.replace("_{", "{").replace("_<", "<")


class Function:
    def __init__(self, name):
        self.name, self.frame, self.calls, self.indirect = name, 0, set(), False


def read(objdump, image):
    """The functions by address."""
    command = [objdump, "-d", "-C", "--no-show-raw-insn", image]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    functions, current = {}, None
    for line in text.splitlines():
        if head := re.match(r"([0-9a-f]+) <(.*)>:$", line):
            current = functions[int(head[1], 16)] = Function(plain(head[2]))
            continue
        parts = re.match(r"\s*[0-9a-f]+:\s+(\S+)\s*(.*)$", line)
        if not parts or current is None:
            continue
        mnemonic, operands = parts[1], re.split(r"\s*[;@]", parts[2])[0].strip()
        current.frame += frame_of(mnemonic, operands, current.name)
        target = re.match(r"(?:0x)?([0-9a-f]+) <", operands)
        if target and mnemonic[:2] != "bl" and functions.get(int(target[1], 16)) is current:
            continue  # A loop from the first instruction on.
        if target and re.match(r"(b|bl|blx)([a-z]{2})?(\.[nw])?$", mnemonic):
            current.calls.add(int(target[1], 16))
        elif re.match(r"(blx|bx)([a-z]{2})?$", mnemonic) and operands != "lr":
            current.indirect = True
    for function in functions.values():
        # A jump within a function is no call.
        function.calls = {address for address in function.calls if address in functions}
    return functions


def bound(functions, address, known, path=()):
    """The largest stack below the caller of a function."""
    function = functions[address]
    if ENDS.search(function.name):
        return 0
    if address in path:
        names = " > ".join(functions[at].name for at in path[path.index(address):])
        sys.exit(f"recursion: {names}")
    if address not in known:
        calls = set(function.calls)
        if function.indirect:
            listed = [callees for caller, callees in INDIRECT.items() if re.search(caller, function.name)]
            if not listed:
                sys.exit(f"an indirect call that is not listed: {function.name}")
            calls |= {at for at, other in functions.items() if re.search(listed[0], other.name)}
        below = (bound(functions, at, known, (*path, address)) for at in calls)
        known[address] = function.frame + max(below, default=0)
    return known[address]


def main():
    objdump, image, *mode = sys.argv[1:]
    functions, known = read(objdump, image), {}
    table = "| entry | bytes, painted | bound |\n|---|---|---|\n"
    for line in sys.stdin:
        if not line.startswith("stack "):
            continue
        name, painted, address = re.match(r"stack (.*) (\d+) (\d+)$", line).groups()
        most = bound(functions, int(address) & ~1, known)
        table += f"| {name} | {painted} | {most} |\n"
        if most < int(painted):
            sys.exit(f"{name}: painted {painted} bytes, more than the bound")
    if not known:
        sys.exit("the image printed no line of a stack")
    document = DOCUMENT.read_text()
    if mode == ["write"]:
        DOCUMENT.write_text(TABLE.sub(lambda found: found[1] + table + found[3], document))
        return
    print(table, end="")
    if mode == ["compare"] and not alike(TABLE.search(document)[2], table):
        sys.exit("docs/memory.md: write the table of the stack by firmware/count --docs")


def alike(documented, counted):
    """Whether the tables have the same rows, with numbers 5 % apart at most."""
    documented, counted = (re.split(r"(\d+)", table) for table in (documented, counted))
    near = (
        abs(int(a) - int(b)) <= 0.05 * int(b) if b.isdigit() and a.isdigit() else a == b
        for a, b in zip(documented, counted)
    )
    return len(documented) == len(counted) and all(near)


main()
