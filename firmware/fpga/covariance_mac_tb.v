// The covariance's multiplications and additions beside covariance.in.hex and covariance.out.hex of
// `host-sim golden`.
module covariance_mac_tb;
    parameter VECTORS = 206;
    localparam ENTRIES = 36;
    reg [31:0] in [0:16*VECTORS-1];
    reg [79:0] expected [0:ENTRIES*VECTORS-1];
    reg clock = 0, enable = 0, first = 0;
    reg [31:0] a, b;
    wire signed [39:0] re, im;
    integer v, i, j, l, entry = 0, errors = 0;

    covariance_mac mac (clock, enable, first, a, b, re, im);
    always #5 clock = ~clock;

    initial begin
        $readmemh("covariance.in.hex", in);
        $readmemh("covariance.out.hex", expected);
        @(negedge clock);
        for (v = 0; v < VECTORS; v = v + 1)
            for (i = 0; i < 8; i = i + 1)
                for (j = 0; j <= i; j = j + 1) begin
                    for (l = 0; l < 9; l = l + 1) begin
                        a = in[16*v + l + i];
                        b = in[16*v + l + j];
                        enable = 1;
                        first = (l == 0);
                        @(negedge clock);
                    end
                    enable = 0;
                    @(negedge clock);
                    if ({re, im} !== expected[entry]) begin
                        if (errors == 0)
                            $display("vector %0d, entry %0d %0d: %h, expected %h", v, i, j, {re, im}, expected[entry]);
                        errors = errors + 1;
                    end
                    entry = entry + 1;
                end
        $display("covariance_mac: %0d entries, %0d errors", entry, errors);
        $finish;
    end
endmodule
