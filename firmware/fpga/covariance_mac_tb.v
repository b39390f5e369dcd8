// The covariance's multiplications and additions beside covariance.in.hex and covariance.out.hex of
// `host-sim golden`, with gaps and stalls on both sides.
module covariance_mac_tb;
    parameter VECTORS = 206;
    localparam ENTRIES = 36;
    reg [31:0] in [0:16*VECTORS-1];
    reg [79:0] expected [0:ENTRIES*VECTORS-1];
    reg clock = 0, reset = 1, enable = 1, in_valid = 0, last = 0, out_ready = 0;
    reg [31:0] a, b;
    wire in_ready, out_valid;
    wire signed [39:0] re, im;
    integer round, v, i, j, l, entry = 0, errors = 0, gaps = 0, stalls = 0;

    covariance_mac mac (clock, reset, enable, in_valid, in_ready, last, a, b, out_valid, out_ready, re, im);
    `include "stalls.vh"

    always @(posedge clock) if (!reset && out_valid && out_ready) begin
        if ({re, im} !== expected[entry]) begin
            if (errors == 0) $display("entry %0d: %h, expected %h", entry, {re, im}, expected[entry]);
            errors = errors + 1;
        end
        entry = entry + 1;
    end

    task product(input integer first, input integer second, input ends);
        begin
            while (chance(gaps)) @(negedge clock);
            a = in[first];
            b = in[second];
            last = ends;
            in_valid = 1;
            #1 while (!in_ready) @(negedge clock) #1;
            @(negedge clock) in_valid = 0;
        end
    endtask

    initial #10000000 begin
        $display("covariance_mac: hangs in round %0d", round);
        $finish;
    end

    initial begin
        $readmemh("covariance.in.hex", in);
        $readmemh("covariance.out.hex", expected);
        for (round = 0; round < 3; round = round + 1) begin
            gaps = round * 20;
            stalls = round % 3 * 45;
            // The sum that the round before began is forgotten.
            reset = 1;
            in_valid = 1;
            @(negedge clock) reset = 0;
            in_valid = 0;
            entry = 0;
            for (v = 0; v < VECTORS; v = v + 1)
                for (i = 0; i < 8; i = i + 1)
                    for (j = 0; j <= i; j = j + 1)
                        for (l = 0; l < 9; l = l + 1) product(16*v + l + i, 16*v + l + j, l == 8);
            repeat (100) @(negedge clock);
            if (entry != ENTRIES * VECTORS) errors = errors + 1;
            for (l = 0; l < 5; l = l + 1) product(l, l, 0);
        end
        $display("covariance_mac: %0d rounds of %0d entries, %0d errors", round, entry, errors);
        $finish;
    end
endmodule
