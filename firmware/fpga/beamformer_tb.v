// Blocks to lines of MV, rank 1 and DAS beside the chain's vectors of `host-sim golden`, or by chain.v samples to lines: registers by
// AXI-Lite before each line, gaps and stalls on both streams, and the next block waits.
module beamformer_tb;
    parameter LINES = 12, PACKED = 0, SAMPLES = 175, OUTPUTS = 96;
    localparam BEATS = 8 * SAMPLES + 4, VALUES = 20;
    reg [63:0] in [0:LINES*BEATS-1], expected [0:LINES*OUTPUTS-1];
    reg [31:0] values [0:LINES*VALUES-1];
    reg clock = 0, reset = 1, start = 0, in_valid = 0, last = 0, out_ready = 0;
    reg aw_valid = 0, w_valid = 0, ar_valid = 0, b_ready = 0, r_ready = 0;
    reg [6:0] aw = 0, ar = 0;
    reg [31:0] w = 0;
    reg [511:0] word;              // a beat, or a sample
    wire aw_ready, w_ready, b_valid, ar_ready, r_valid, in_ready, out_valid, out_last;
    wire [1:0] b_resp, r_resp;
    wire [31:0] r;
    wire [63:0] z;
    integer l, k, sent, n, part, counted = 0, received = 0, errors = 0, gaps = 0, stalls = 0;

    generate
        if (PACKED) begin : top
            chain #(SAMPLES) dut (clock, reset, 1'b1, start, sent[15:0], 8'd0, word, 2'd0, in_valid, in_ready, 1'b1, aw,
                aw_valid, aw_ready, w, 4'hf, w_valid, w_ready, b_resp, b_valid, b_ready, ar, ar_valid, ar_ready, r, r_resp,
                r_valid, r_ready, z, out_valid, out_ready, out_last);
            wire idle = dut.beamformer.state == 0;
        end else begin : top
            beamformer #(SAMPLES) dut (clock, reset, aw, aw_valid, aw_ready, w, 4'hf, w_valid, w_ready, b_resp, b_valid,
                b_ready, ar, ar_valid, ar_ready, r, r_resp, r_valid, r_ready, word[63:0], in_valid, in_ready, last, z,
                out_valid, out_ready, out_last);
            wire idle = dut.state == 0;
        end
    endgenerate
    always #5 clock = ~clock;

    function chance(input integer percent);
        chance = $unsigned($random) % 100 < percent;
    endfunction

    always @(negedge clock) out_ready = !chance(stalls);

    always @(posedge clock) if (!reset && out_valid && out_ready) begin
        if (z !== expected[received] || out_last !== (received % OUTPUTS == OUTPUTS - 1)) begin
            if (errors < 5) $display("sample %0d: %h %b, expected %h", received, z, out_last, expected[received]);
            errors = errors + 1;
        end
        received = received + 1;
    end

    task write(input [4:0] to, input [31:0] value);
        begin
            {aw, w, aw_valid, w_valid} = {to, 2'd0, value, 2'b11};
            b_ready = 0;
            #1 while (!aw_ready || !w_ready) @(negedge clock) #1;
            @(negedge clock) {aw_valid, w_valid} = 0;
            while (!b_valid) @(negedge clock);
            b_ready = 1;
            @(negedge clock) b_ready = 0;
        end
    endtask

    task read(input [4:0] from);   // to `r`
        begin
            {ar, ar_valid} = {from, 2'd0, 1'b1};
            #1 while (!ar_ready) @(negedge clock) #1;
            @(negedge clock) ar_valid = 0;
            while (!r_valid) @(negedge clock);
            r_ready = 1;
            @(negedge clock) r_ready = 0;
        end
    endtask

    initial #(100000 * LINES * OUTPUTS) begin
        $display("beamformer: hangs in line %0d", l);
        $finish;
    end

    initial begin
        $readmemh("chain.in.hex", in);
        $readmemh("chain.out.hex", expected);
        $readmemh("chain.lines.hex", values);
        repeat (3) @(negedge clock);
        reset = 0;
        for (l = 0; l < LINES; l = l + 1) begin
            gaps = l % 3 * 30;
            stalls = l % 4 * 30;
            while (!top.idle) @(negedge clock);
            for (k = 0; k < VALUES; k = k + 1) write(k + 1, values[VALUES*l + k]);
            read(VALUES);
            if (r !== values[VALUES*l + VALUES - 1]) errors = errors + 1;
            read(31);
            if (r !== l) errors = errors + 1;
            write(0, 1);
            while (r !== l + 1) read(31);
            counted = l + 1;
            write(0, 0);
        end
        while (received < OUTPUTS * LINES) @(negedge clock);
        repeat (10000) @(negedge clock);
        if (received != OUTPUTS * LINES) errors = errors + 1;
        $display("beamformer: %0d lines, %0d clocks a sample with its block, %0d errors", LINES,
            ($time / 10 - 10000) / OUTPUTS / LINES, errors);
        $finish;
    end

    initial begin
        @(negedge reset);
        for (sent = 0; sent < LINES; sent = sent + 1) begin
            // A bank of the packer is free.
            while (sent > counted + 1) @(negedge clock);
            start = 1;
            @(negedge clock) start = 0;
            for (n = 0; n < (PACKED ? SAMPLES : BEATS); n = n + 1) begin
                while (chance(gaps)) @(negedge clock);
                word = in[BEATS*sent + n];
                if (PACKED) for (part = 0; part < 8; part = part + 1) word[64*part +: 64] = in[BEATS*sent + 8*n + part + 1];
                last = n == BEATS - 1;
                in_valid = 1;
                #1 while (!in_ready) @(negedge clock) #1;
                @(negedge clock) in_valid = 0;
            end
        end
    end
endmodule
