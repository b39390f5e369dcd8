// A signed product by multipliers of 18 bits, with registers of their own on both sides: 4 clocks, or 3 if `b` has at
// most 18 bits.
module multiply #(
    parameter A = 32,              // bits, 19 to 35
    parameter B = 32               // bits, to 35
) (
    input wire clock,
    input wire signed [A-1:0] a,
    input wire signed [B-1:0] b,
    output reg signed [A+B-1:0] product
);
    reg signed [A-1:0] near_a;
    reg signed [B-1:0] near_b;
    always @(posedge clock) {near_a, near_b} <= {a, b};
    // 17 bits, without a sign, and the rest.
    wire signed [17:0] a_low = {1'b0, near_a[16:0]};
    wire signed [A-18:0] a_high = near_a[A-1:17];
    generate
        if (B <= 18) begin : narrow
            reg signed [B+17:0] low;
            reg signed [A+B-18:0] high;
            always @(posedge clock) begin
                low <= a_low * near_b;
                high <= a_high * near_b;
                product <= {high, 17'd0} + {{A-17{low[B+16]}}, low[B+16:0]};
            end
            wire unused = low[B+17];
        end else begin : wide
            localparam M = A > B ? A : B;
            wire signed [17:0] b_low = {1'b0, near_b[16:0]};
            wire signed [B-18:0] b_high = near_b[B-1:17];
            reg signed [35:0] low;
            reg signed [B:0] low_high;
            reg signed [A:0] high_low;
            reg signed [A+B-35:0] high;
            reg signed [A+B-1:0] ends;
            reg signed [M:0] middle;
            always @(posedge clock) begin
                low <= a_low * b_low;
                low_high <= a_low * b_high;
                high_low <= a_high * b_low;
                high <= a_high * b_high;
                ends <= {high, low[33:0]};
                middle <= {{M+1-B{low_high[B-1]}}, low_high[B-1:0]} + {{M+1-A{high_low[A-1]}}, high_low[A-1:0]};
                product <= ends + {{A+B-M-18{middle[M]}}, middle, 17'd0};
            end
            wire unused = &{low[35:34], low_high[B], high_low[A]};
        end
    endgenerate
endmodule
