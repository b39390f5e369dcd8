// A word of a stream waits here, so that no path leads through from one side's ready or valid to the other's.
module skid #(
    parameter BITS = 64
) (
    input wire clock,
    input wire reset,
    input wire [BITS-1:0] in,
    input wire in_valid,
    output wire in_ready,
    output reg [BITS-1:0] out,
    output reg out_valid,
    input wire out_ready
);
    reg [BITS-1:0] held;
    reg holds;
    assign in_ready = !holds;
    wire advance = !out_valid || out_ready;
    always @(posedge clock) begin
        if (advance) begin
            out <= holds ? held : in;
            out_valid <= holds || in_valid;
            holds <= 0;
        end else if (in_valid && !holds) begin
            held <= in;
            holds <= 1;
        end
        if (reset) {out_valid, holds} <= 0;
    end
endmodule
