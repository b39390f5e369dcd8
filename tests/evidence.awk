# The claims of docs/safety.md with the outcome of their steps, as Markdown. Reads what tests/run printed, then the
# document. A claim without a step is an error, and so is one whose step is unknown.
FNR == 1 { file++ }
file == 1 && /^== / { step = $2 }
file == 1 && /^skipped/ { skipped[step] = skipped[step] " " $0 }
file == 1 && /^[a-z0-9-]+: [0-9]+ s, [0-9]+ s of the processor$/ { passed[substr($1, 1, length($1) - 1)] = 1 }
file == 1 && /^tests\/run: failed: / { lost[$3] = 1 }
file == 1 { next }
/^## / { inside = $0 == "## What is claimed, and what shows it" }
inside && /^\| / && !/^\| claim / {
    split($0, cell, / *\| */)
    parts = split(cell[3], part, "`")
    outcome = ""
    for (k = 2; k <= parts; k += 2) {
        name = part[k]
        if (index(" " steps " ", " " name " ") == 0) continue
        if (name in lost) state = " failed"
        else if (name in skipped) state = skipped[name]
        else state = name in passed ? " passed" : " not run"
        outcome = outcome (outcome == "" ? "" : "; ") "`" name "`" state
    }
    if (outcome == "") { print "no step shows: " cell[2] > "/dev/stderr"; failed = 1 }
    print "| " cell[2] " | " outcome " |"
    claims++
}
END { exit failed || !claims }
