// Delay and sum of 16 complex words: a tree of adders, a vector a clock, five clocks deep.
// The mean is (sum + 8) >>> 4: halves are rounded up. See docs/fpga.md.
module das_tree (
    input wire clock,
    input wire valid_in,
    input wire [16*32-1:0] words,  // {re, im} of element 15, ..., element 0
    output reg valid_out,
    output reg [31:0] mean         // {re, im}
);
    genvar k;
    wire signed [15:0] re [0:15], im [0:15];
    generate
        for (k = 0; k < 16; k = k + 1) begin : split
            assign re[k] = words[32*k+16 +: 16];
            assign im[k] = words[32*k +: 16];
        end
    endgenerate

    reg signed [16:0] re8 [0:7], im8 [0:7];
    reg signed [17:0] re4 [0:3], im4 [0:3];
    reg signed [18:0] re2 [0:1], im2 [0:1];
    reg signed [19:0] re1, im1;
    reg [3:0] valid;
    wire signed [20:0] rounded_re = re1 + 21'sd8, rounded_im = im1 + 21'sd8;

    integer i;
    always @(posedge clock) begin
        for (i = 0; i < 8; i = i + 1) begin
            re8[i] <= re[2*i] + re[2*i+1];
            im8[i] <= im[2*i] + im[2*i+1];
        end
        for (i = 0; i < 4; i = i + 1) begin
            re4[i] <= re8[2*i] + re8[2*i+1];
            im4[i] <= im8[2*i] + im8[2*i+1];
        end
        for (i = 0; i < 2; i = i + 1) begin
            re2[i] <= re4[2*i] + re4[2*i+1];
            im2[i] <= im4[2*i] + im4[2*i+1];
        end
        re1 <= re2[0] + re2[1];
        im1 <= im2[0] + im2[1];
        mean <= {rounded_re[19:4], rounded_im[19:4]};
        valid <= {valid[2:0], valid_in};
        valid_out <= valid[3];
    end
endmodule
