// Makes a stream of a pipeline that never waits: its words are kept here, and `room` says early enough whether another
// may begin. No path leads through from one side to the other.
module credits #(
    parameter BITS = 64,
    parameter DEPTH = 16           // a power of two: for a word a clock, from 5 above the pipeline's clocks on
) (
    input wire clock,
    input wire reset,
    output reg room,
    input wire begins,             // with `room`: a word enters the pipeline
    input wire in_valid,           // it leaves the pipeline
    input wire [BITS-1:0] in,
    output reg [BITS-1:0] out,
    output reg out_valid,
    input wire out_ready
);
    localparam A = $clog2(DEPTH);
    reg [BITS-1:0] words [0:DEPTH-1];
    reg [A-1:0] to, from, begun;   // words that came, left and began
    wire advance = !out_valid || out_ready;
    wire waits = to != from;
    wire [A-1:0] kept = begun - from;
    always @(posedge clock) begin
        words[to] <= in;
        if (in_valid) to <= to + 1'b1;
        if (begins) begun <= begun + 1'b1;
        // Two more begin at most, before this stops them.
        room <= kept < {{A-1{1'b1}}, 1'b0};
        if (advance) begin
            out <= words[from];
            out_valid <= waits;
            if (waits) from <= from + 1'b1;
        end
        if (reset) {to, from, begun, room, out_valid} <= 0;
    end
endmodule
