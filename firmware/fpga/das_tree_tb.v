// The DAS tree beside das.in.hex and das.out.hex of `host-sim golden`, with gaps and stalls on both sides.
// Other sizes take the same words, and are compared with a plain sum.
module das_tree_tb;
    parameter VECTORS = 206;
    parameter ELEMENTS = 16;
    reg [31:0] in [0:16*VECTORS-1];
    reg [31:0] file [0:VECTORS-1];
    reg clock = 0, reset = 1, enable = 1, in_valid = 0, out_ready = 0;
    reg [ELEMENTS*32-1:0] words;
    wire in_ready, out_valid;
    wire [31:0] mean;
    reg [31:0] expected;
    integer round, sent, received = 0, errors = 0, gaps = 0, stalls = 0, limit, k, re, im;

    das_tree #(ELEMENTS) tree (clock, reset, enable, in_valid, in_ready, words, out_valid, out_ready, mean);
    `include "stalls.vh"

    always @(posedge clock) if (!reset && out_valid && out_ready) begin
        re = 0;
        im = 0;
        for (k = 0; k < ELEMENTS; k = k + 1) begin
            re = re + $signed(in[ELEMENTS*received + k][31:16]);
            im = im + $signed(in[ELEMENTS*received + k][15:0]);
        end
        re = (re + ELEMENTS / 2) >>> $clog2(ELEMENTS);
        im = (im + ELEMENTS / 2) >>> $clog2(ELEMENTS);
        expected = ELEMENTS == 16 ? file[received] : {re[15:0], im[15:0]};
        if (mean !== expected) begin
            if (errors == 0) $display("vector %0d: %h, expected %h", received, mean, expected);
            errors = errors + 1;
        end
        received = received + 1;
    end

    initial #10000000 begin
        $display("das_tree: hangs in round %0d", round);
        $finish;
    end

    initial begin
        $readmemh("das.in.hex", in);
        $readmemh("das.out.hex", file);
        for (round = 0; round < 12; round = round + 1) begin
            gaps = round % 3 * 30;
            stalls = round % 4 * 30;
            reset = 1;
            in_valid = 1;
            @(negedge clock) reset = 0;
            in_valid = 0;
            received = 0;
            // Every second round is broken off by the reset of the next one.
            limit = round % 2 ? VECTORS / 2 : VECTORS;
            for (sent = 0; sent < limit; sent = sent + 1) begin
                while (chance(gaps)) @(negedge clock);
                words = 0;
                for (k = 0; k < ELEMENTS; k = k + 1) words[32*k +: 32] = in[ELEMENTS*sent + k];
                in_valid = 1;
                #1 while (!in_ready) @(negedge clock) #1;
                @(negedge clock) in_valid = 0;
            end
            repeat (round % 2 ? 2 : 400) @(negedge clock);
            if (round % 2 ? received > limit : received != limit) errors = errors + 1;
        end
        $display("das_tree: %0d elements, %0d rounds, %0d errors", ELEMENTS, round, errors);
        $finish;
    end
endmodule
