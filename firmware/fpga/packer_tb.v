// The packer beside blocks of firmware/stream, written by its test `packer`: with gaps and a receiver that stalls,
// then each way to lose samples or transmits.
module packer_tb;
    localparam CHANNELS = 8, BITS = 14, SAMPLES = 7, BLOCKS = 6, BEATS = 16;
    reg [CHANNELS*BITS-1:0] in [0:BLOCKS*SAMPLES-1];
    reg [63:0] expected [0:BLOCKS*BEATS-1];
    reg clock = 0, reset = 1, enable = 1, start = 0, valid = 0, ready = 0, waits = 1;
    reg [15:0] beam = 0;
    reg [7:0] epoch = 8'h5A;
    reg [CHANNELS*BITS-1:0] sample = 0;
    reg [1:0] user = 0;
    wire [63:0] beat;
    wire sample_ready, beat_valid, last;
    integer gaps = 0, stalls = 0, round, b, errors = 0;

    packer #(CHANNELS, BITS, SAMPLES) dut (clock, reset, enable, start, beam, epoch, sample, user, valid,
        sample_ready, waits, beat, beat_valid, ready, last);
    always #5 clock = ~clock;

    function chance(input integer percent);
        chance = $unsigned($random) % 100 < percent;
    endfunction

    task fail(input [8*32-1:0] what, input integer at);
        begin
            if (errors < 5) $display("%0s: %0d", what, at);
            errors = errors + 1;
        end
    endtask

    // The receiver: keeps the beats of a round.
    reg [63:0] got [0:511], held;
    reg waited = 0;
    integer beats = 0;
    always @(negedge clock) ready = !chance(stalls);
    always @(posedge clock) begin
        if (waited && !reset && (!beat_valid || beat !== held)) fail("a beat did not wait", beats);
        waited = beat_valid && !ready && !reset;
        held = beat;
        if (beat_valid && ready && !reset) begin
            got[beats] = beat;
            if (last !== (beats % BEATS == BEATS - 1)) fail("last", beats);
            beats = beats + 1;
        end
    end

    task restart;
        begin
            reset = 1;
            @(negedge clock) reset = 0;
            beats = 0;
        end
    endtask

    task transmit(input integer block);
        begin
            beam = expected[block*BEATS][47:32];
            start = 1;
            @(negedge clock) start = 0;
        end
    endtask

    // Samples of a block: offered until they are taken, or once; then when they can be taken, or at once.
    task record(input integer block, input integer count, input polite);
        integer n;
        for (n = 0; n < count; n = n + 1) begin
            while (chance(gaps)) @(negedge clock);
            while (polite && !waits && !sample_ready) @(negedge clock);
            sample = in[block*SAMPLES + n];
            valid = 1;
            while (polite && waits && !sample_ready) @(negedge clock);
            @(negedge clock) valid = 0;
        end
    endtask

    task settle(input integer blocks);
        begin
            repeat (2000) if (beats < blocks * BEATS) @(negedge clock);
            repeat (50) @(negedge clock);
            if (beats != blocks * BEATS) fail("beats", beats);
        end
    endtask

    // Block `at` of the round is `block`, with its own header and the first `count` samples.
    task check(input integer at, input integer block, input [31:0] number, input [15:0] faults, input integer count);
        integer k;
        begin
            if (got[at*BEATS] !== {expected[block*BEATS][63:56], faults[7:0], expected[block*BEATS][47:32], number})
                fail("header", at);
            for (k = 1; k < BEATS; k = k + 1)
                if ((k <= 2 * count || k > 2 * SAMPLES) && got[at*BEATS + k] !== expected[block*BEATS + k])
                    fail("word", at * BEATS + k);
        end
    endtask

    initial #10000000 begin
        $display("packer: hangs in round %0d", round);
        $finish;
    end

    initial begin
        $readmemh("packer.in.hex", in);
        $readmemh("packer.out.hex", expected);
        for (round = 0; round < 60; round = round + 1) begin
            gaps = round % 3 * 40;
            stalls = round % 4 * 30;
            waits = round % 5 < 3;
            restart;
            for (b = 0; b < BLOCKS; b = b + 1) begin
                while (b > beats / BEATS + 1) @(negedge clock);
                transmit(b);
                record(b, SAMPLES, 1);
            end
            settle(BLOCKS);
            for (b = 0; b < BLOCKS; b = b + 1)
                check(b, b, b, expected[b*BEATS][63:48], SAMPLES);
        end
        gaps = 0;

        // No bank is free for transmits 2 and 3.
        stalls = 100;
        restart;
        for (b = 0; b < 4; b = b + 1) begin
            transmit(b);
            record(b, SAMPLES, 1);
        end
        stalls = 50;
        settle(2);
        transmit(4);
        record(4, SAMPLES, 1);
        settle(3);
        for (b = 0; b < 2; b = b + 1) check(b, b, b, expected[b*BEATS][63:48], SAMPLES);
        check(2, 4, 4, expected[4*BEATS][63:48], SAMPLES);

        // A short record ends with the next transmit.
        restart;
        transmit(0);
        record(0, 3, 1);
        transmit(5);
        record(5, SAMPLES, 1);
        settle(2);
        check(0, 0, 0, 2, 3);
        check(1, 5, 1, 0, SAMPLES);

        // Samples that do not wait: every second one is lost, and the others are in their places.
        restart;
        waits = 0;
        transmit(0);
        record(0, SAMPLES, 0);
        settle(1);
        check(0, 0, 0, 2, 1);
        for (b = 0; b < SAMPLES; b = b + 2)
            if ({got[2*b + 1], got[2*b + 2]} !== {expected[2*b + 1], expected[2*b + 2]}) fail("place", b);

        // Faults from before; samples after a record; no transmit without `enable`.
        restart;
        transmit(0);
        user = 1;
        record(0, 1, 1);
        user = 0;
        record(0, SAMPLES, 1);
        user = 2;
        record(1, SAMPLES, 1);
        transmit(5);
        record(5, SAMPLES, 1);
        settle(2);
        user = 0;
        enable = 0;
        transmit(1);
        record(1, SAMPLES, 1);
        enable = 1;
        transmit(3);
        record(3, SAMPLES, 1);
        settle(3);
        check(0, 0, 0, 1, 0);
        check(1, 5, 1, 2, SAMPLES);
        check(2, 3, 2, 0, SAMPLES);

        // Reset while a block is recorded and another one sent.
        restart;
        stalls = 90;
        transmit(0);
        record(0, SAMPLES, 1);
        transmit(1);
        record(1, 3, 1);
        if (!beat_valid) fail("nothing is sent", 0);
        restart;
        stalls = 0;
        transmit(0);
        record(0, SAMPLES, 1);
        settle(1);
        check(0, 0, 0, expected[0][63:48], SAMPLES);

        $display("packer: %0d rounds, %0d errors", round, errors);
        $finish;
    end
endmodule
