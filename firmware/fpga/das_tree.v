// Delay and sum of complex words: a tree of adders, a vector a clock.
// The mean is (sum + ELEMENTS/2) >>> log2(ELEMENTS): halves are rounded up. See docs/fpga.md.
module das_tree #(
    parameter ELEMENTS = 16,       // a power of two, from 2 on
    parameter BITS = 16            // of a real part
) (
    input wire clock,
    input wire reset,
    input wire enable,             // low: no vector is taken
    input wire in_valid,
    output wire in_ready,
    input wire [ELEMENTS*2*BITS-1:0] words,  // {re, im} of the last element, ..., the first
    output reg out_valid,
    input wire out_ready,
    output reg [2*BITS-1:0] mean   // {re, im}
);
    localparam LEVELS = $clog2(ELEMENTS);
    localparam [BITS+LEVELS:0] HALF = 1 << (LEVELS - 1);
    wire advance = !out_valid || out_ready;
    assign in_ready = enable && advance;
    reg [LEVELS-1:0] valid;

    genvar level, k;
    generate
        // Sums of 2^level elements, two a word.
        for (level = 0; level <= LEVELS; level = level + 1) begin : tree
            localparam W = BITS + level;
            reg [2*(ELEMENTS>>level)*W-1:0] sums;
            if (level == 0) begin : leaves
                always @* sums = words;
            end else begin : sum
                for (k = 0; k < 2 * (ELEMENTS >> level); k = k + 1) begin : number
                    wire [W-2:0] a = tree[level-1].sums[(k/2*4 + k%2)*(W-1) +: W-1];
                    wire [W-2:0] b = tree[level-1].sums[(k/2*4 + k%2 + 2)*(W-1) +: W-1];
                    always @(posedge clock) if (advance) sums[k*W +: W] <= {a[W-2], a} + {b[W-2], b};
                end
            end
        end
        for (k = 0; k < 2; k = k + 1) begin : root
            localparam W = BITS + LEVELS;
            wire [W-1:0] sum = tree[LEVELS].sums[k*W +: W];
            wire [W:0] rounded = {sum[W-1], sum} + HALF;
            wire unused = &{rounded[W], rounded[LEVELS-1:0]};
            always @(posedge clock) if (advance) mean[k*BITS +: BITS] <= rounded[LEVELS +: BITS];
        end
    endgenerate

    always @(posedge clock) begin
        if (advance) {out_valid, valid} <= {valid, in_valid && enable};
        if (reset) {out_valid, valid} <= 0;
    end
endmodule
