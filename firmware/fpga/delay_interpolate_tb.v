// Delay, interpolation and apodization beside lines of the core, written by the test `delay_interpolate` of
// firmware/stream, with gaps and stalls on both sides.
module delay_interpolate_tb;
    localparam ELEMENTS = 4, SAMPLES = 40, OUTPUTS = 64, LINES = 3, LINE = ELEMENTS * OUTPUTS;
    reg [31:0] record [0:ELEMENTS*SAMPLES-1];
    reg [63:0] line [0:5*LINES-1];
    reg [47:0] in [0:LINES*LINE-1];
    reg [63:0] expected [0:LINES*LINE-1];
    reg clock = 0, reset = 1, enable = 1, write = 0, start = 0, in_valid = 0, out_ready = 0;
    reg [5:0] sample = 0;
    reg [1:0] element = 0;
    reg [31:0] word = 0;
    reg [31:0] delay;
    reg [15:0] weight;
    // Receive delays from another point of the line, so that they are negative: the same outputs.
    reg [63:0] ahead;
    reg [63:0] first_position, first_cycles, step_position, step_cycles, rate;
    wire in_ready, out_valid, last;
    wire signed [24:0] re, im;
    integer round, l, k, received = 0, errors = 0, gaps = 0, stalls = 0;

    delay_interpolate #(ELEMENTS, SAMPLES, 13) dut (clock, reset, enable, write, sample, element,
        {word[28:16], word[12:0]}, start, first_position[51:0], first_cycles[43:0], step_position[51:0],
        step_cycles[43:0], rate[27:0], in_valid, in_ready, delay, weight, out_valid, out_ready, last, re, im);
    `include "stalls.vh"

    always @(posedge clock) if (!reset && out_valid && out_ready) begin
        if ({{7{re[24]}}, re, {7{im[24]}}, im} !== expected[received] || last !== (received % ELEMENTS == ELEMENTS - 1)) begin
            if (errors < 5)
                $display("output %0d: %h %h %b, expected %h", received, re, im, last, expected[received]);
            errors = errors + 1;
        end
        received = received + 1;
    end

    // The first `count` receive delays of a line.
    task begin_line(input integer number, input integer count);
        begin
            {first_position, step_position, first_cycles, step_cycles, rate} = {line[5*number], line[5*number + 1],
                line[5*number + 2], line[5*number + 3], line[5*number + 4]};
            first_position = first_position + (ahead << 14);
            first_cycles = first_cycles + ahead * rate;
            start = 1;
            in_valid = 1;
            @(negedge clock) start = 0;
            in_valid = 0;
            for (k = 0; k < count; k = k + 1) begin
                while (chance(gaps)) @(negedge clock);
                {weight, delay} = in[number*LINE + k];
                delay = delay - ahead[31:0];
                in_valid = 1;
                #1 if (gaps + stalls == 0 && !in_ready) errors = errors + 1;   // an element a clock
                while (!in_ready) @(negedge clock) #1;
                @(negedge clock) in_valid = 0;
            end
        end
    endtask

    initial #10000000 begin
        $display("delay_interpolate: hangs in round %0d", round);
        $finish;
    end

    initial begin
        $readmemh("delay_interpolate.record.hex", record);
        $readmemh("delay_interpolate.lines.hex", line);
        $readmemh("delay_interpolate.in.hex", in);
        $readmemh("delay_interpolate.out.hex", expected);
        for (k = 0; k < ELEMENTS * SAMPLES; k = k + 1) begin
            sample = k / ELEMENTS;
            element = k % ELEMENTS;
            word = record[k];
            write = 1;
            @(negedge clock) write = 0;
        end
        for (round = 0; round < 12; round = round + 1) begin
            gaps = round % 3 * 30;
            stalls = round % 4 * 30;
            ahead = round % 2 * 100 << 18;
            reset = 1;
            in_valid = 1;
            @(negedge clock) reset = 0;
            in_valid = 0;
            received = 0;
            for (l = 0; l < LINES; l = l + 1) begin_line(l, LINE);
            repeat (1000) @(negedge clock);
            if (received != LINES * LINE) errors = errors + 1;
            // Broken off by the reset of the next round.
            received = 0;
            begin_line(0, 5);
        end
        $display("delay_interpolate: %0d rounds of %0d elements, %0d errors", round, LINES * LINE, errors);
        $finish;
    end
endmodule
