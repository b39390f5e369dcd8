// MV, rank 1 and DAS by real_form.v and solver.v beside mv.in.hex, mv.out.hex, mv.rank1.hex and mv.das.hex of `host-sim
// golden`, with gaps and stalls on both sides. Lines end within a bank of eight samples, too.
module mv_tb;
    parameter VECTORS = 206;
    reg [31:0] in [0:16*VECTORS-1];
    localparam RANK1 = 0, MV = 663, DAS = 980;
    reg [63:0] mv [0:VECTORS-1], rank1 [0:VECTORS-1], das [0:VECTORS-1];
    reg [9:0] first;
    wire [63:0] expected = first == MV ? mv[received] : first == DAS ? das[received] : rank1[received];
    reg clock = 0, reset = 1, enable = 1, in_valid = 0, in_end = 0, out_ready = 0;
    reg [31:0] word;
    wire in_ready, valid, ready, last, line_end, out_valid, out_end;
    wire [31:0] number;
    wire [6:0] address;
    wire [4:0] exponent;
    wire [31:0] re, im;
    integer round, sent, k, length, at, received = 0, errors = 0, gaps = 0, stalls = 0, began;

    real_form form (clock, reset, enable, 16'd6554, in_valid, in_ready, word, in_end, valid, ready, number, address, last,
        line_end, exponent);
    solver solver (clock, reset, 1'b1, first, valid, ready, number, address, last, line_end, exponent, out_valid, out_ready,
        out_end, re, im);
    `include "stalls.vh"

    always @(posedge clock) if (!reset && out_valid && out_ready) begin
        if ({re, im} !== expected || out_end !== (received == VECTORS - 1 || received % length == length - 1)) begin
            if (errors < 5) $display("vector %0d: %h %h %b, expected %h", received, re, im, out_end, expected);
            errors = errors + 1;
        end
        received = received + 1;
    end

    initial #200000000 begin
        $display("mv: hangs in round %0d", round);
        $finish;
    end

    initial begin
        $readmemh("mv.in.hex", in);
        $readmemh("mv.out.hex", mv);
        $readmemh("mv.rank1.hex", rank1);
        $readmemh("mv.das.hex", das);
        for (round = 0; round < 10; round = round + 1) begin
            gaps = round % 3 * 30;
            stalls = round % 4 * 30;
            first = round < 4 ? MV : round < 8 ? RANK1 : DAS;
            length = round % 4 == 0 ? VECTORS : 3 + 10 * round;
            reset = 1;
            in_valid = 1;
            @(negedge clock) reset = 0;
            in_valid = 0;
            received = 0;
            began = $time;
            for (sent = 0; sent < VECTORS; sent = sent + 1)
                for (k = 0; k < 16; k = k + 1) begin
                    while (chance(gaps)) @(negedge clock);
                    word = in[16*sent + k];
                    in_end = k == 15 && (sent == VECTORS - 1 || sent % length == length - 1);
                    in_valid = 1;
                    #1 while (!in_ready) @(negedge clock) #1;
                    @(negedge clock) in_valid = 0;
                end
            while (received < VECTORS) @(negedge clock);
            if (round % 4 == 0) $display("mv: %0d clocks a sample from term %0d", ($time - began) / 10 / VECTORS, first);
            repeat (100) @(negedge clock);
            if (received != VECTORS) errors = errors + 1;
            // A line that the reset breaks off.
            if (round == 1) repeat (20) begin
                in_valid = 1;
                in_end = 0;
                @(negedge clock);
            end
        end
        $display("mv: %0d rounds of %0d vectors, %0d errors", round, VECTORS, errors);
        $finish;
    end
endmodule
