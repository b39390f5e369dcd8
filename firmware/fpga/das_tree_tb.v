// The DAS tree beside das.in.hex and das.out.hex of `host-sim golden`.
module das_tree_tb;
    parameter VECTORS = 206;
    reg [31:0] in [0:16*VECTORS-1];
    reg [31:0] expected [0:VECTORS-1];
    reg clock = 0, valid_in = 0;
    reg [16*32-1:0] words;
    wire valid_out;
    wire [31:0] mean;
    integer sent = 0, received = 0, errors = 0, k;

    das_tree tree (clock, valid_in, words, valid_out, mean);
    always #5 clock = ~clock;

    initial begin
        $readmemh("das.in.hex", in);
        $readmemh("das.out.hex", expected);
        repeat (6) @(negedge clock);
        for (sent = 0; sent < VECTORS; sent = sent + 1) begin
            for (k = 0; k < 16; k = k + 1) words[32*k +: 32] = in[16*sent + k];
            valid_in = 1;
            @(negedge clock);
        end
        valid_in = 0;
        repeat (8) @(negedge clock);
        if (received != VECTORS) errors = errors + 1;
        $display("das_tree: %0d vectors, %0d errors", received, errors);
        $finish;
    end

    always @(negedge clock) if (valid_out === 1'b1) begin
        if (mean !== expected[received]) begin
            if (errors == 0) $display("vector %0d: %h, expected %h", received, mean, expected[received]);
            errors = errors + 1;
        end
        received = received + 1;
    end
endmodule
