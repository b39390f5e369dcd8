"""Runs every fuzz target, or those named, and tells what it cost.

    tests/fuzz.py SECONDS [TARGET…]
    tests/fuzz.py SECONDS --executions N [--table] [TARGET…]

Each target runs for so long, on the committed seeds and on what was found before in fuzz/corpus. The time is the
same for all, so that a dear target gets as much of the processor as a cheap one. With --executions the cheap ones
end after so many. --table writes what was counted into docs/CONTRIBUTING.md. An input that fails ends the run.
"""

import argparse
import datetime
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FUZZ = ROOT / "fuzz"
# Without a sanitizer: there is no unsafe code here for it to watch.
CARGO = ["cargo", "+nightly", "fuzz"]
PLAIN = ["--sanitizer", "none"]


def run(target, seconds, executions):
    """Executions, processor's seconds, edges found and edges there are."""
    corpus = FUZZ / "corpus" / target
    corpus.mkdir(parents=True, exist_ok=True)
    log = FUZZ / "corpus" / f"{target}.log"
    limits = [f"-max_total_time={seconds}", f"-runs={executions}", "-timeout=30", "-rss_limit_mb=3000"]
    command = [*CARGO, "run", *PLAIN, target, f"corpus/{target}", f"seeds/{target}", "--", *limits]
    with log.open("w") as out:
        child = subprocess.Popen(command, cwd=FUZZ, stdout=out, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(child.pid, 0)
    text = log.read_text(errors="replace")
    done = re.search(r"^Done (\d+) runs", text, re.M)
    if status or not done:
        sys.exit("".join(text.splitlines(keepends=True)[-60:]) + f"{target}: failed")
    edges = re.findall(r"cov: (\d+)", text)[-1]
    there = re.search(r"\((\d+) inline", text)[1]
    return int(done[1]), used.ru_utime + used.ru_stime, int(edges), int(there)


def table(rows, path):
    """Puts the rows in place of those that the document has of the same targets."""
    text = path.read_text()
    there = re.compile(r"(?<=<!-- fuzz -->\n)(.*?)(?=<!-- end of fuzz -->)", re.S)
    rows = dict(re.findall(r"^\| `(\w+)` (\|.*)$", there.search(text)[0], re.M)) | {
        name: f"| {n:,} | {cpu:.0f} | {edges} of {links} | {datetime.date.today()} |"
        for name, (n, cpu, edges, links) in rows
    }
    lines = [
        "",
        "| target | executions | seconds of the processor | edges found, of those linked | on |",
        "|---|---|---|---|---|",
        *(f"| `{name}` {row}" for name, row in sorted(rows.items())),
        "",
    ]
    path.write_text(there.sub(lambda _: "\n".join(lines) + "\n", text))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seconds", type=int)
    parser.add_argument("--executions", type=int, default=-1)
    parser.add_argument("--table", action="store_true")
    parser.add_argument("targets", nargs="*")
    arguments = parser.parse_intermixed_args()
    subprocess.run([*CARGO, "build", *PLAIN], cwd=FUZZ, check=True)
    every = subprocess.run([*CARGO, "list"], cwd=FUZZ, check=True, capture_output=True, text=True)
    rows = []
    for target in arguments.targets or every.stdout.split():
        row = run(target, arguments.seconds, arguments.executions)
        print(f"{target}: {row[0]:,} executions in {row[1]:.0f} s of the processor, {row[2]} of {row[3]} edges", flush=True)
        rows.append((target, row))
    if arguments.table:
        table(rows, ROOT / "docs/CONTRIBUTING.md")


main()
