// One entry of the forward covariance: a complex multiplication and addition a clock, exact in 40 bits.
// `first` begins a new sum with its product. See docs/fpga.md.
module covariance_mac (
    input wire clock,
    input wire enable,
    input wire first,
    input wire [31:0] a,           // {re, im} of x[l + i]
    input wire [31:0] b,           // {re, im} of x[l + j]
    output reg signed [39:0] re,
    output reg signed [39:0] im
);
    wire signed [15:0] a_re = a[31:16], a_im = a[15:0], b_re = b[31:16], b_im = b[15:0];
    reg signed [31:0] rr, ii, ir, ri;
    reg go, begin_sum;
    // a times the conjugate of b.
    wire signed [32:0] product_re = rr + ii, product_im = ir - ri;
    always @(posedge clock) begin
        go <= enable;
        begin_sum <= first;
        if (enable) begin
            rr <= a_re * b_re;
            ii <= a_im * b_im;
            ir <= a_im * b_re;
            ri <= a_re * b_im;
        end
        if (go) begin
            re <= (begin_sum ? 40'sd0 : re) + product_re;
            im <= (begin_sum ? 40'sd0 : im) + product_im;
        end
    end
endmodule
