// One entry of the forward covariance: a complex multiplication and addition a clock, exact in SUM bits.
// A sum ends with the product of `in_last`. See docs/fpga.md.
module covariance_mac #(
    parameter BITS = 16,           // of a real part
    parameter SUM = 40             // of a sum: n products need 2*BITS + log2(n) bits
) (
    input wire clock,
    input wire reset,
    input wire enable,             // low: no product is taken
    input wire in_valid,
    output wire in_ready,
    input wire in_last,
    input wire [2*BITS-1:0] a,     // {re, im} of x[l + i]
    input wire [2*BITS-1:0] b,     // {re, im} of x[l + j]
    output reg out_valid,
    input wire out_ready,
    output reg signed [SUM-1:0] re,
    output reg signed [SUM-1:0] im
);
    localparam PRODUCT = 2 * BITS;
    wire signed [BITS-1:0] a_re = a[PRODUCT-1:BITS], a_im = a[BITS-1:0];
    wire signed [BITS-1:0] b_re = b[PRODUCT-1:BITS], b_im = b[BITS-1:0];
    reg signed [PRODUCT-1:0] rr, ii, ir, ri;
    reg multiplied, last, fresh;
    // a times the conjugate of b.
    wire signed [PRODUCT:0] product_re = {rr[PRODUCT-1], rr} + {ii[PRODUCT-1], ii};
    wire signed [PRODUCT:0] product_im = {ir[PRODUCT-1], ir} - {ri[PRODUCT-1], ri};
    wire advance = !out_valid || out_ready;
    assign in_ready = enable && advance;

    always @(posedge clock) begin
        if (advance) begin
            rr <= a_re * b_re;
            ii <= a_im * b_im;
            ir <= a_im * b_re;
            ri <= a_re * b_im;
            multiplied <= in_valid && enable;
            last <= in_last;
            out_valid <= multiplied && last;
            if (multiplied) begin
                re <= (fresh ? {SUM{1'b0}} : re) + {{SUM-PRODUCT-1{product_re[PRODUCT]}}, product_re};
                im <= (fresh ? {SUM{1'b0}} : im) + {{SUM-PRODUCT-1{product_im[PRODUCT]}}, product_im};
                fresh <= last;
            end
        end
        if (reset) begin
            multiplied <= 0;
            out_valid <= 0;
            fresh <= 1;
        end
    end
endmodule
