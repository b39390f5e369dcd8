// Delay, linear interpolation and apodization of I/Q: an element a clock, 17 deep, with the bits of
// core/src/delay/iq/fixed.rs. See docs/fpga.md.
//
// Positions and carrier phases of a line are accumulators. Receive delays come from a table or a root outside, in
// the order [output sample][element].
module delay_interpolate #(
    parameter ELEMENTS = 16,       // from 2 on
    parameter SAMPLES = 280,       // of a record, from 3 on
    parameter BITS = 16,           // of a count
    parameter TABLE = "phasors.hex",
    parameter WEIGHTED = 1         // 0: by 1
) (
    input wire clock,
    input wire reset,
    input wire enable,             // low: no receive delay is taken
    input wire record_write,       // not while a line is computed
    input wire [$clog2(SAMPLES)-1:0] record_sample,
    input wire [$clog2(ELEMENTS)-1:0] record_element,
    input wire [2*BITS-1:0] record_word,   // {re, im}
    input wire start,              // begins a line, at these two:
    input wire [51:0] first_position,      // of output sample 0, 2^-32 samples
    input wire [43:0] first_cycles,        // its phase, 2^-44 cycles
    input wire [51:0] step_position,       // from one output sample to the next
    input wire [43:0] step_cycles,
    input wire [27:0] rate,        // f_demod/fs, 2^-26
    input wire in_valid,
    output wire in_ready,
    input wire signed [31:0] in_delay,     // receive delay, 2^-18 samples
    input wire [15:0] in_weight,   // apodization, 2^-15; at most 1
    output wire out_valid,
    input wire out_ready,
    output wire out_last,          // the last element of an output sample
    output wire signed [BITS+11:0] re,     // 2^-11 of a count
    output wire signed [BITS+11:0] im
);
    localparam E = $clog2(ELEMENTS);
    localparam END = WEIGHTED ? 17 : 14;   // stages
    localparam H = $clog2((SAMPLES + 1) / 2);
    localparam [E-1:0] LAST = ELEMENTS[E-1:0] - 1'b1;

    // Here and in other cores: no word is needed in the clock of its write, so Yosys adds no logic for that.
    (* no_rw_check *) reg [2*BITS-1:0] even [0:(1<<(H+E))-1];
    (* no_rw_check *) reg [2*BITS-1:0] odd [0:(1<<(H+E))-1];
    reg [31:0] phasors [0:2047];   // {cosine, sine} of half a cycle, 2^-14
    initial $readmemh(TABLE, phasors);
    wire [E+H-1:0] record_address = {record_sample[H:1], record_element};
    always @(posedge clock) begin
        if (record_write && !record_sample[0]) even[record_address] <= record_word;
        if (record_write && record_sample[0]) odd[record_address] <= record_word;
    end

    reg [END:1] valid, last;
    wire room;
    assign in_ready = enable && room && !start;
    wire taken = in_valid && in_ready;
    reg [E-1:0] element;
    wire last_element = element == LAST;
    always @(posedge clock) begin
        valid <= {valid[END-1:1], taken};
        last <= {last[END-1:1], last_element};
        if (reset) valid <= 0;
    end

    // --- 1: the line's position, 2^-13 samples, and phase, 2^-44 cycles. To 5: the element's phase.
    reg [51:0] position;
    reg [43:0] cycles, cycles_1, cycles_2, cycles_3, cycles_4, cycles_5;
    reg [32:0] position_1;
    reg signed [31:0] delay_1;
    reg [E-1:0] element_1, element_2, element_3;
    wire signed [60:0] turn_5;
    multiply #(32, 29) turn (clock, delay_1, {1'b0, rate}, turn_5);
    wire unused_5 = &{turn_5[60:44], position[18:0]};
    always @(posedge clock) begin
        if (start) begin
            position <= first_position;
            cycles <= first_cycles;
            element <= 0;
        end else if (taken) begin
            element <= last_element ? {E{1'b0}} : element + 1'b1;
            if (last_element) begin
                position <= position + step_position;
                cycles <= cycles + step_cycles;
            end
        end
        position_1 <= position[51:19];
        // So that cutting the phase rounds.
        {cycles_5, cycles_4, cycles_3, cycles_2, cycles_1} <=
            {cycles_4, cycles_3, cycles_2, cycles_1, cycles + 44'h80000000};
        delay_1 <= in_delay;
        {element_3, element_2, element_1} <= {element_2, element_1, element};
    end

    // --- 2 to 6: the samples on both sides; 0 outside of the record.
    reg [33:0] at_2;
    reg [20:0] index_3, next_3;
    reg [12:0] fraction_3, fraction_4, fraction_5, fraction_6, fraction_7, fraction_8;
    reg [2*BITS-1:0] even_4, odd_4, even_5, odd_5, earlier_6, later_6;
    reg swap_4, swap_5, first_4, first_5, second_4, second_5;
    wire unused_3 = next_3[0];
    always @(posedge clock) begin
        at_2 <= {position_1[32], position_1} + {{7{delay_1[31]}}, delay_1[31:5]};
        index_3 <= at_2[33:13];
        next_3 <= at_2[33:13] + 1'b1;
        even_4 <= even[{next_3[H:1], element_3}];
        odd_4 <= odd[{index_3[H:1], element_3}];
        {even_5, odd_5} <= {even_4, odd_4};
        {swap_5, swap_4} <= {swap_4, index_3[0]};
        {first_5, first_4} <= {first_4, index_3 < SAMPLES[20:0]};
        {second_5, second_4} <= {second_4, next_3 < SAMPLES[20:0]};
        earlier_6 <= first_5 ? (swap_5 ? odd_5 : even_5) : {2*BITS{1'b0}};
        later_6 <= second_5 ? (swap_5 ? even_5 : odd_5) : {2*BITS{1'b0}};
        {fraction_8, fraction_7, fraction_6, fraction_5, fraction_4, fraction_3} <=
            {fraction_7, fraction_6, fraction_5, fraction_4, fraction_3, at_2[12:0]};
    end

    // --- 6 to 10: the phase, and its cosine and sine from the table.
    wire [43:0] phase = cycles_5 + turn_5[43:0];
    wire unused_6 = &phase[31:0];
    reg [11:0] phase_6;
    reg [10:0] address_7;
    reg [9:7] negative, half;
    reg [31:0] phasor_8, phasor_9;
    reg signed [15:0] cosine_10, sine_10;
    always @(posedge clock) begin
        phase_6 <= phase[43:32];
        address_7 <= phase_6[11] ? -phase_6[10:0] : phase_6[10:0];
        negative <= {negative[8:7], phase_6[11]};
        half <= {half[8:7], phase_6 == 12'h800};
        phasor_8 <= phasors[address_7];
        phasor_9 <= phasor_8;
        cosine_10 <= half[9] ? -16'sd16384 : phasor_9[31:16];
        sine_10 <= half[9] ? 16'sd0 : negative[9] ? -phasor_9[15:0] : phasor_9[15:0];
    end

    // --- To 10: the sample between them, 2^-13 of a count. To 13: its products.
    genvar k;
    generate
        for (k = 0; k < 2; k = k + 1) begin : part
            wire signed [BITS-1:0] a = earlier_6[BITS*k +: BITS], b = later_6[BITS*k +: BITS];
            reg signed [BITS-1:0] a_7, a_8, a_9;
            reg signed [BITS:0] rise_7, rise_8;
            reg signed [BITS+14:0] risen_9;
            reg signed [BITS+12:0] between_10;
            wire signed [BITS+28:0] cosine_13, sine_13;
            wire unused = &{risen_9[BITS+14:BITS+13], cosine_13[BITS+28], cosine_13[15:0], sine_13[BITS+28],
                sine_13[15:0]};
            always @(posedge clock) begin
                rise_7 <= {b[BITS-1], b} - {a[BITS-1], a};
                {a_9, a_8, a_7} <= {a_8, a_7, a};
                rise_8 <= rise_7;
                risen_9 <= rise_8 * $signed({1'b0, fraction_8});
                between_10 <= {a_9, 13'd0} + risen_9[BITS+12:0];
            end
            multiply #(BITS + 13, 16) by_cosine (clock, between_10, cosine_10, cosine_13);
            multiply #(BITS + 13, 16) by_sine (clock, between_10, sine_10, sine_13);
        end
    endgenerate

    // --- 14: the rotated sample, each product truncated. 17: its weight.
    reg signed [BITS+11:0] re_14, im_14;
    always @(posedge clock) begin
        re_14 <= part[1].cosine_13[BITS+27:16] - part[0].sine_13[BITS+27:16];
        im_14 <= part[1].sine_13[BITS+27:16] + part[0].cosine_13[BITS+27:16];
    end
    wire signed [BITS+11:0] re_end, im_end;
    generate
        if (WEIGHTED) begin : weighted
            reg [15:0] weights [0:15];     // of the last 16 clocks
            reg [3:0] newest;
            wire [3:0] needed = newest - 4'd13;
            reg [15:0] weight_14;
            always @(posedge clock) begin
                newest <= reset ? 4'd0 : newest + 1'b1;
                weights[newest] <= in_weight;
                weight_14 <= weights[needed];
            end
            wire signed [BITS+28:0] re_17, im_17;
            multiply #(BITS + 12, 17) re_weight (clock, re_14, {1'b0, weight_14}, re_17);
            multiply #(BITS + 12, 17) im_weight (clock, im_14, {1'b0, weight_14}, im_17);
            assign {re_end, im_end} = {re_17[BITS+26:15], im_17[BITS+26:15]};
            wire unused = &{re_17[BITS+28:BITS+27], re_17[14:0], im_17[BITS+28:BITS+27], im_17[14:0]};
        end else begin : plain
            assign {re_end, im_end} = {re_14, im_14};
            wire unused = &in_weight;
        end
    endgenerate
    credits #(2 * BITS + 25, 32) leaving (clock, reset, room, taken, valid[END], {last[END], re_end, im_end},
        {out_last, re, im}, out_valid, out_ready);
endmodule
