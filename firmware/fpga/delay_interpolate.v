// Delay, linear interpolation and apodization of I/Q: an element a clock, 14 deep, with the bits of
// core/src/delay/iq/fixed.rs. See docs/fpga.md.
//
// Positions and carrier phases of a line are accumulators. Receive delays come from a table or a root outside, in
// the order [output sample][element].
module delay_interpolate #(
    parameter ELEMENTS = 16,       // from 2 on
    parameter SAMPLES = 280,       // of a record, from 3 on
    parameter BITS = 16,           // of a count
    parameter TABLE = "phasors.hex"
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
    localparam H = $clog2((SAMPLES + 1) / 2);
    localparam [E-1:0] LAST = ELEMENTS[E-1:0] - 1'b1;

    reg [2*BITS-1:0] even [0:(1<<(H+E))-1];
    reg [2*BITS-1:0] odd [0:(1<<(H+E))-1];
    reg [31:0] phasors [0:2047];   // {cosine, sine} of half a cycle, 2^-14
    initial $readmemh(TABLE, phasors);
    wire [E+H-1:0] record_address = {record_sample[H:1], record_element};
    always @(posedge clock) begin
        if (record_write && !record_sample[0]) even[record_address] <= record_word;
        if (record_write && record_sample[0]) odd[record_address] <= record_word;
    end

    reg [14:1] valid, last;
    assign out_valid = valid[14];
    assign out_last = last[14];
    wire advance = !out_valid || out_ready;
    assign in_ready = enable && advance && !start;
    wire taken = in_valid && in_ready;
    reg [E-1:0] element;
    wire last_element = element == LAST;
    always @(posedge clock) begin
        if (advance) begin
            valid <= {valid[13:1], taken};
            last <= {last[13:1], last_element};
        end
        if (reset) valid <= 0;
    end

    // --- 1: the line's position, 2^-13 samples, and phase, 2^-44 cycles. To 4: the element's phase.
    reg [51:0] position;
    reg [43:0] cycles, cycles_1, cycles_2, cycles_3, cycles_4;
    reg [32:0] position_1;
    reg signed [31:0] delay_1;
    reg [E-1:0] element_1, element_2, element_3;
    wire signed [60:0] turn_4;
    multiply #(32, 29) turn (clock, advance, delay_1, {1'b0, rate}, turn_4);
    wire unused_4 = &{turn_4[60:44], position[18:0]};
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
        if (advance) begin
            position_1 <= position[51:19];
            // So that cutting the phase rounds.
            {cycles_4, cycles_3, cycles_2, cycles_1} <= {cycles_3, cycles_2, cycles_1, cycles + 44'h80000000};
            delay_1 <= in_delay;
            {element_3, element_2, element_1} <= {element_2, element_1, element};
        end
    end

    // --- 2 to 6: the samples on both sides; 0 outside of the record.
    reg [33:0] at_2;
    reg [20:0] index_3, next_3;
    reg [12:0] fraction_3, fraction_4, fraction_5, fraction_6, fraction_7;
    reg [2*BITS-1:0] even_4, odd_4, even_5, odd_5, earlier_6, later_6;
    reg swap_4, swap_5, first_4, first_5, second_4, second_5;
    wire unused_3 = next_3[0];
    always @(posedge clock) if (advance) begin
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
        {fraction_7, fraction_6, fraction_5, fraction_4, fraction_3} <=
            {fraction_6, fraction_5, fraction_4, fraction_3, at_2[12:0]};
    end

    // --- 5 to 9: the phase, and its cosine and sine from the table.
    wire [43:0] phase = cycles_4 + turn_4[43:0];
    wire unused_5 = &phase[31:0];
    reg [11:0] phase_5;
    reg [10:0] address_6;
    reg [8:6] negative, half;
    reg [31:0] phasor_7, phasor_8;
    reg signed [15:0] cosine_9, sine_9;
    always @(posedge clock) if (advance) begin
        phase_5 <= phase[43:32];
        address_6 <= phase_5[11] ? -phase_5[10:0] : phase_5[10:0];
        negative <= {negative[7:6], phase_5[11]};
        half <= {half[7:6], phase_5 == 12'h800};
        phasor_7 <= phasors[address_6];
        phasor_8 <= phasor_7;
        cosine_9 <= half[8] ? -16'sd16384 : phasor_8[31:16];
        sine_9 <= half[8] ? 16'sd0 : negative[8] ? -phasor_8[15:0] : phasor_8[15:0];
    end

    // --- To 9: the sample between them, 2^-13 of a count. To 11: its products.
    genvar k;
    generate
        for (k = 0; k < 2; k = k + 1) begin : part
            wire signed [BITS-1:0] a = earlier_6[BITS*k +: BITS], b = later_6[BITS*k +: BITS];
            reg signed [BITS-1:0] a_7, a_8;
            reg signed [BITS:0] rise_7;
            reg signed [BITS+14:0] risen_8;
            reg signed [BITS+12:0] between_9;
            wire signed [BITS+28:0] cosine_11, sine_11;
            wire unused = &{risen_8[BITS+14:BITS+13], cosine_11[BITS+28], cosine_11[15:0], sine_11[BITS+28],
                sine_11[15:0]};
            always @(posedge clock) if (advance) begin
                rise_7 <= {b[BITS-1], b} - {a[BITS-1], a};
                {a_8, a_7} <= {a_7, a};
                risen_8 <= rise_7 * $signed({1'b0, fraction_7});
                between_9 <= {a_8, 13'd0} + risen_8[BITS+12:0];
            end
            multiply #(BITS + 13, 16) by_cosine (clock, advance, between_9, cosine_9, cosine_11);
            multiply #(BITS + 13, 16) by_sine (clock, advance, between_9, sine_9, sine_11);
        end
    endgenerate

    // --- 12: the rotated sample, each product truncated. 14: its weight.
    reg signed [BITS+11:0] re_12, im_12;
    reg [15:0] weights [0:15];     // of the last 16 elements
    reg [3:0] newest;
    wire [3:0] needed = newest - 4'd11;
    reg [15:0] weight_12;
    wire signed [BITS+28:0] re_14, im_14;
    wire unused_14 = &{re_14[BITS+28:BITS+27], re_14[14:0], im_14[BITS+28:BITS+27], im_14[14:0]};
    always @(posedge clock) begin
        if (advance) begin
            re_12 <= part[1].cosine_11[BITS+27:16] - part[0].sine_11[BITS+27:16];
            im_12 <= part[1].sine_11[BITS+27:16] + part[0].cosine_11[BITS+27:16];
            newest <= newest + 1'b1;
            weights[newest] <= in_weight;
            weight_12 <= weights[needed];
        end
        if (reset) newest <= 0;
    end
    multiply #(BITS + 12, 17) re_weight (clock, advance, re_12, {1'b0, weight_12}, re_14);
    multiply #(BITS + 12, 17) im_weight (clock, advance, im_12, {1'b0, weight_12}, im_14);
    assign re = re_14[BITS+26:15];
    assign im = im_14[BITS+26:15];
endmodule
